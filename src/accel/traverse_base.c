/* SPDX-License-Identifier: MIT */
/* Queries in plain C, for any processor: the reference for the other variants. */
#include "boxes_base.h"
#include "ops.h"

enum { COUNTING = 0 };

#include "traverse_walk.h"

const struct pen_trace_ops pen_trace_base = {"base", nearest, shadow};
