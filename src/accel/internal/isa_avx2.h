/* SPDX-License-Identifier: MIT */
/* What the traversals need of AVX2 and FMA: eight boxes at once, four primitives at once; see
 * isa_base.h. Compiled without these instructions, it is isa_base.h: the same results. */
#ifndef PEN_ACCEL_INTERNAL_ISA_AVX2_H
#define PEN_ACCEL_INTERNAL_ISA_AVX2_H

#ifdef __AVX2__
#include "accel/internal/blocks_avx2.h"
#else
#include "accel/internal/isa_base.h"
#endif

#endif
