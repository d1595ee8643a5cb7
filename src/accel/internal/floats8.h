/* SPDX-License-Identifier: MIT */
/* Vectors of eight floats in the compiler's own vector types, for any processor: the boxes of a
 * node, or of the parts of a packet. */
#ifndef PEN_ACCEL_INTERNAL_FLOATS8_H
#define PEN_ACCEL_INTERNAL_FLOATS8_H

#include <stdint.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

typedef float float8 __attribute__((vector_size(32), aligned(4), may_alias));
typedef int32_t mask8 __attribute__((vector_size(32)));

#define ABS8(x) ((float8)((mask8)(x)&INT32_MAX))

/* The lanes that are set, as bits. */
static inline unsigned mask8_bits(const mask8 *m)
{
#ifdef __AVX2__
    return (unsigned)_mm256_movemask_ps((__m256)*m);
#else
    unsigned bits = 0;
    for (int i = 0; i < 8; i++)
        bits |= (unsigned)((*m)[i] & 1) << i;
    return bits;
#endif
}

#endif
