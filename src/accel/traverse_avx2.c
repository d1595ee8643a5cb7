/* SPDX-License-Identifier: MIT */
/* Queries with AVX2 and FMA: eight boxes, four primitives at once. */
#include "accel/internal/ops.h"

#ifdef __AVX2__

#include "accel/internal/boxes_avx2.h"
#include "accel/internal/lanes_avx2.h"

enum { COUNTING = 0 };

#include "accel/internal/traverse_walk.h"

#include "accel/internal/packet_test.h"

static const struct pen_trace_ops avx2 = {"avx2",       nearest,     shadow,
                                          packet_begin, packet_test, packet_ray};

const struct pen_trace_ops *pen_trace_avx2(void)
{
    return &avx2;
}

#else

const struct pen_trace_ops *pen_trace_avx2(void)
{
    return NULL;
}

#endif
