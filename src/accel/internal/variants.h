/* SPDX-License-Identifier: MIT */
/* The tables of traversals, two for each instruction set of PEN_ISA_LIST (base/cpu.h). Token
 * pasting makes the names pen_trace_<instruction set> and pen_trace_count_<instruction set>.
 * traverse_isa.c and traverse_count_isa.c define them; each is compiled once for each instruction
 * set. */
#ifndef PEN_ACCEL_INTERNAL_VARIANTS_H
#define PEN_ACCEL_INTERNAL_VARIANTS_H

#include "accel/accel.h"

#define PEN_TRACE_DECLARE(UPPER, lower, ...)                                                       \
    extern const struct pen_trace_ops pen_trace_##lower, pen_trace_count_##lower;
PEN_ISA_LIST(PEN_TRACE_DECLARE)
#undef PEN_TRACE_DECLARE

#endif
