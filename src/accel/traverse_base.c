/* SPDX-License-Identifier: MIT */
/* Queries in plain C, for any processor: the reference for the other variants. */
#include "boxes_base.h"
#include "lanes_base.h"
#include "ops.h"

enum { COUNTING = 0 };

#include "traverse_walk.h"

#include "fan_look.h"

const struct pen_trace_ops pen_trace_base = {"base", nearest, shadow, fan_begin, fan_look, fan_ray};
