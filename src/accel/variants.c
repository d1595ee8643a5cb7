/* SPDX-License-Identifier: MIT */
/* The choice of the compiled variant, and the views for counting queries: threads share an
 * accelerator, but not counts. */
#include "accel/internal/variants.h"

#include <stdlib.h>

#include "accel/internal/structure.h"

const struct pen_trace_ops *pen_trace_ops_get(enum pen_isa isa)
{
#define TABLE_ROW(UPPER, lower, ...) [PEN_ISA_##UPPER] = &pen_trace_##lower,
    static const struct pen_trace_ops *const ops[PEN_ISA_COUNT] = {PEN_ISA_LIST(TABLE_ROW)};
#undef TABLE_ROW
    return ops[isa];
}

const struct pen_trace_ops *pen_trace_count_ops_get(enum pen_isa isa)
{
#define TABLE_ROW(UPPER, lower, ...) [PEN_ISA_##UPPER] = &pen_trace_count_##lower,
    static const struct pen_trace_ops *const ops[PEN_ISA_COUNT] = {PEN_ISA_LIST(TABLE_ROW)};
#undef TABLE_ROW
    return ops[isa];
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
