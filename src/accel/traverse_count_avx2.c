/* SPDX-License-Identifier: MIT */
/* Queries with AVX2 and FMA that count their tests. */
#include "accel/internal/ops.h"

#ifdef __AVX2__

#include "accel/internal/boxes_avx2.h"

enum { COUNTING = 1 };

#include "accel/internal/traverse_walk.h"

static const struct pen_trace_ops avx2 = {"avx2, counting", nearest, shadow, NULL, NULL, NULL};

const struct pen_trace_ops *pen_trace_count_avx2(void)
{
    return &avx2;
}

#else

const struct pen_trace_ops *pen_trace_count_avx2(void)
{
    return NULL;
}

#endif
