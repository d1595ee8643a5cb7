/* SPDX-License-Identifier: MIT */
/* The operations that the types of lanes.h lack, for AVX2. */
#ifndef PEN_ACCEL_INTERNAL_LANES_AVX2_H
#define PEN_ACCEL_INTERNAL_LANES_AVX2_H

#include "accel/internal/lanes.h"
#include <immintrin.h>

static inline unsigned mask4_bits(const mask4 *m)
{
    return (unsigned)_mm256_movemask_pd((__m256d)*m);
}

static inline unsigned mask8_bits(const mask8 *m)
{
    return (unsigned)_mm256_movemask_ps((__m256)*m);
}

static inline void sqrt4(double4 *x)
{
    *x = (double4)_mm256_sqrt_pd((__m256d)*x);
}

#endif
