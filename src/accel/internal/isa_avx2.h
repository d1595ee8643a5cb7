/* SPDX-License-Identifier: MIT */
/* The operations of the traversals with AVX2 and FMA: eight boxes at once, four primitives at once;
 * see isa_base.h. Without these instructions, this header is isa_base.h, with the same results. */
#ifndef PEN_ACCEL_INTERNAL_ISA_AVX2_H
#define PEN_ACCEL_INTERNAL_ISA_AVX2_H

#ifdef __AVX2__
#include "accel/internal/blocks_avx2.h"
#else
#include "accel/internal/isa_base.h"
#endif

#endif
