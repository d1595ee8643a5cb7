/* SPDX-License-Identifier: MIT */
/* PEN_ISA, the instruction set for which this file is compiled: includes its header isa_<name>.h
 * and builds names from its name. */
#ifndef PEN_ACCEL_INTERNAL_ISA_H
#define PEN_ACCEL_INTERNAL_ISA_H

#define ISA_HEADER(isa) ISA_HEADER_OF_TOKEN(isa)
#define ISA_HEADER_OF_TOKEN(token) ISA_STRING(isa_##token.h)
#define ISA_STRING(path) #path
#include ISA_HEADER(PEN_ISA)

/* ISA_NAME(avx2) is "avx2"; ISA_NAMED(pen_trace_, avx2) is pen_trace_avx2. */
#define ISA_NAME(isa) ISA_STRING(isa)
#define ISA_NAMED(prefix, isa) ISA_NAMED_BY_TOKEN(prefix, isa)
#define ISA_NAMED_BY_TOKEN(prefix, token) prefix##token

#endif
