/* SPDX-License-Identifier: MIT */
/* Queries in plain C that count their tests. */
#include "boxes_base.h"
#include "ops.h"

enum { COUNTING = 1 };

#include "traverse_walk.h"

const struct pen_trace_ops pen_trace_count_base = {
    "base, counting", nearest, shadow, NULL, NULL, NULL};
