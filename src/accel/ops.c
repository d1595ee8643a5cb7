/* SPDX-License-Identifier: MIT */
/* Which compiled variant answers queries, and the views that counting queries need: an accelerator
 * is shared by threads, counts are not. */
#include "accel/internal/ops.h"

#include <stdlib.h>

#include "accel/internal/structure.h"

const struct pen_trace_ops *pen_trace_ops_get(enum pen_isa isa)
{
    const struct pen_trace_ops *avx2 = isa == PEN_ISA_AVX2 ? pen_trace_avx2() : NULL;
    return avx2 ? avx2 : &pen_trace_base;
}

const struct pen_trace_ops *pen_trace_count_ops_get(enum pen_isa isa)
{
    const struct pen_trace_ops *avx2 = isa == PEN_ISA_AVX2 ? pen_trace_count_avx2() : NULL;
    return avx2 ? avx2 : &pen_trace_count_base;
}

struct pen_accel *pen_accel_count_new(const struct pen_accel *accel, struct pen_test_counts *counts)
{
    struct pen_accel *view = malloc(sizeof *view);
    if (!view)
        return NULL;
    *view = *accel;
    view->counts = counts;
    return view;
}

void pen_accel_count_free(struct pen_accel *view)
{
    free(view);
}
