/* SPDX-License-Identifier: MIT */
/* Queries in plain C, for any processor: the reference for the other variants. */
#include "accel/internal/boxes_base.h"
#include "accel/internal/lanes_base.h"
#include "accel/internal/ops.h"

enum { COUNTING = 0 };

#include "accel/internal/traverse_walk.h"

#include "accel/internal/packet_test.h"

const struct pen_trace_ops pen_trace_base = {"base",       nearest,     shadow,
                                             packet_begin, packet_test, packet_ray};
