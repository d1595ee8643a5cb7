/* SPDX-License-Identifier: MIT */
/* With AVX-512, packets of rays have wider vectors (math/lanes.h). A single ray is traversed
 * through nodes of eight boxes and blocks of four primitives, as with AVX2. */
#ifndef PEN_ACCEL_INTERNAL_ISA_AVX512_H
#define PEN_ACCEL_INTERNAL_ISA_AVX512_H

#include "accel/internal/isa_avx2.h"

#endif
