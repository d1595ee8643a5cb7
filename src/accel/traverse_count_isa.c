/* SPDX-License-Identifier: MIT */
/* The queries that count their tests and their table, pen_trace_count_<instruction set>. The table
 * has no packets, so that every ray is counted alone. */
#include "accel/internal/isa.h"

enum { COUNTING = 1 };

#include "accel/internal/traverse_query.h"
#include "accel/internal/variants.h"

const struct pen_trace_ops ISA_NAMED(pen_trace_count_, PEN_ISA) = {
    .name = ISA_NAME(PEN_ISA) ", counting",
    .nearest = nearest,
    .shadow = shadow,
};
