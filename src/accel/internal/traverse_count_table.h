/* SPDX-License-Identifier: MIT */
/* The same as traverse_table.h for queries that count their tests: pen_trace_count_<TRACE_ISA>. It
 * has no packets, so that every ray is counted by itself. */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_COUNT_TABLE_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_COUNT_TABLE_H

enum { COUNTING = 1 };

#include "accel/internal/traverse_query.h"
#include "accel/internal/variants.h"

#define TRACE_NAME(isa) TRACE_NAME_OF_TOKEN(isa)
#define TRACE_NAME_OF_TOKEN(token) #token
#define TRACE_TABLE(isa) TRACE_TABLE_OF_TOKEN(isa)
#define TRACE_TABLE_OF_TOKEN(token) pen_trace_count_##token

const struct pen_trace_ops TRACE_TABLE(TRACE_ISA) = {
    .name = TRACE_NAME(TRACE_ISA) ", counting",
    .nearest = nearest,
    .shadow = shadow,
};

#endif
