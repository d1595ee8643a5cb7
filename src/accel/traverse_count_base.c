/* SPDX-License-Identifier: MIT */
/* Queries in plain C that count their tests. */
#include "accel/internal/boxes_base.h"
#include "accel/internal/ops.h"

enum { COUNTING = 1 };

#include "accel/internal/traverse_walk.h"

const struct pen_trace_ops pen_trace_count_base = {
    "base, counting", nearest, shadow, NULL, NULL, NULL};
