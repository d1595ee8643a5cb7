/* SPDX-License-Identifier: MIT */
/* Compiles the queries of one instruction set and their table, pen_trace_<TRACE_ISA>. The including
 * file defines TRACE_ISA, a name of PEN_ISA_LIST (base/cpu.h), includes that instruction set's
 * header (see isa_base.h), and is compiled with its flags. */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_TABLE_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_TABLE_H

enum { COUNTING = 0 };

#include "accel/internal/packet_test.h"
#include "accel/internal/traverse_query.h"
#include "accel/internal/variants.h"

#define TRACE_NAME(isa) TRACE_NAME_OF_TOKEN(isa)
#define TRACE_NAME_OF_TOKEN(token) #token
#define TRACE_TABLE(isa) TRACE_TABLE_OF_TOKEN(isa)
#define TRACE_TABLE_OF_TOKEN(token) pen_trace_##token

const struct pen_trace_ops TRACE_TABLE(TRACE_ISA) = {
    .name = TRACE_NAME(TRACE_ISA),
    .nearest = nearest,
    .shadow = shadow,
    .packet_begin = packet_begin,
    .packet_test = packet_test,
    .packet_ray = packet_ray,
};

#endif
