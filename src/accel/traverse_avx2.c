/* SPDX-License-Identifier: MIT */
/* Queries with AVX2 and FMA: eight boxes, four primitives at once. */
#include "ops.h"

#ifdef __AVX2__

#include "boxes_avx2.h"
#include "lanes_avx2.h"

enum { COUNTING = 0 };

#include "traverse_walk.h"

#include "fan_look.h"

static const struct pen_trace_ops avx2 = {"avx2", nearest, shadow, fan_begin, fan_look, fan_ray};

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
