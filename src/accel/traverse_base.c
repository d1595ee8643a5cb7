/* SPDX-License-Identifier: MIT */
/* Queries in plain C, for any processor: the reference for the other variants. */
#include "accel/internal/boxes_base.h"
#include "accel/internal/lanes_base.h"
#include "accel/internal/ops.h"

enum { COUNTING = 0 };

#include "accel/internal/traverse_walk.h"

#include "accel/internal/fan_look.h"

const struct pen_trace_ops pen_trace_base = {"base", nearest, shadow, fan_begin, fan_look, fan_ray};
