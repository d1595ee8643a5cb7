/* SPDX-License-Identifier: MIT */
/* The functions of math/sample.h for four points at once, in vectors as the compiler knows them
 * on any processor. The same operations in the same order: the same bits. */
#ifndef PEN_SHADE_INTERNAL_POINTS_LANES_H
#define PEN_SHADE_INTERNAL_POINTS_LANES_H

#include <stdint.h>

typedef double point4 __attribute__((vector_size(32)));
typedef int64_t choice4 __attribute__((vector_size(32)));
typedef uint64_t word4 __attribute__((vector_size(32)));
typedef uint32_t half4 __attribute__((vector_size(16)));

/* The finalizer of SplitMix64. */
static inline void points_mix(word4 *z)
{
    *z = (*z ^ *z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    *z = (*z ^ *z >> 27) * UINT64_C(0x94D049BB133111EB);
    *z = *z ^ *z >> 31;
}

/* The middles of cells of 2^32: a number below 2^52 is made a double by its bits. */
static inline void points_unit(const word4 *cell, point4 *out)
{
    const point4 big = {0x1p52, 0x1p52, 0x1p52, 0x1p52};
    point4 whole = (point4)(*cell | UINT64_C(0x4330000000000000)) - big;
    *out = (whole + 0.5) * 0x1p-32;
}

/* pen_random2 of indices index .. index + 3. */
static inline void points_random(uint64_t hash, uint32_t index, point4 *x, point4 *y)
{
    const word4 step = {1, 2, 3, 4};
    word4 bits = hash + (index + step) * UINT64_C(0x9E3779B97F4A7C15);
    points_mix(&bits);
    word4 low = bits & UINT32_MAX, high = bits >> 32;
    points_unit(&low, x);
    points_unit(&high, y);
}

static inline void points_reverse(half4 *x)
{
    half4 v = *x >> 16 | *x << 16;
    v = (v >> 8 & 0x00FF00FF) | (v & 0x00FF00FF) << 8;
    v = (v >> 4 & 0x0F0F0F0F) | (v & 0x0F0F0F0F) << 4;
    v = (v >> 2 & 0x33333333) | (v & 0x33333333) << 2;
    *x = (v >> 1 & 0x55555555) | (v & 0x55555555) << 1;
}

static inline void points_scramble(half4 *x, uint32_t seed)
{
    half4 v = *x;
    v ^= v * 0x3D20ADEAu;
    v += seed;
    v *= seed >> 16 | 1u;
    v ^= v * 0x05526C56u;
    *x = v ^ v * 0x53A22864u;
}

static inline void points_widen(const half4 *x, word4 *out)
{
    *out = (word4){(*x)[0], (*x)[1], (*x)[2], (*x)[3]};
}

/* pen_sobol2 of indices index .. index + 3. */
static inline void points_sobol(uint64_t hash, uint32_t index, point4 *x, point4 *y)
{
    const half4 step = {0, 1, 2, 3};
    half4 s = index + step;
    points_reverse(&s);
    points_scramble(&s, (uint32_t)(hash * UINT64_C(0x9E3779B97F4A7C15) >> 32));
    points_reverse(&s);
    half4 first = s, second = s ^ s >> 16;
    second ^= second >> 8 & 0x00FF00FF;
    second ^= second >> 4 & 0x0F0F0F0F;
    second ^= second >> 2 & 0x33333333;
    second ^= second >> 1 & 0x55555555;
    points_scramble(&first, (uint32_t)hash);
    points_scramble(&second, (uint32_t)(hash >> 32));
    points_reverse(&first);
    points_reverse(&second);
    word4 wide;
    points_widen(&first, &wide);
    points_unit(&wide, x);
    points_widen(&second, &wide);
    points_unit(&wide, y);
}

#define CHOOSE4(m, a, b) ((point4)(((choice4)(a) & (m)) | ((choice4)(b) & ~(m))))

/* pen_disk_of_square; points of the sequences above are never in the square's middle lines. */
static inline void points_disk(point4 *x, point4 *y)
{
    point4 a = 2 * *x - 1, b = 2 * *y - 1;
    point4 size_a = (point4)((choice4)a & INT64_MAX), size_b = (point4)((choice4)b & INT64_MAX);
    choice4 wide = size_a > size_b;
    point4 longer = CHOOSE4(wide, a, b), shorter = CHOOSE4(wide, b, a);
    point4 angle = 0x1.921fb54442d18p-1 * (shorter / longer), z = angle * angle;
    point4 s = 1. / 6227020800 + z * (-1. / 1307674368000);
    s = 1. / 362880 + z * (-1. / 39916800 + z * s);
    s = -1. / 6 + z * (1. / 120 + z * (-1. / 5040 + z * s));
    point4 c = -1. / 87178291200 + z * (1. / 20922789888000);
    c = 1. / 40320 + z * (-1. / 3628800 + z * (1. / 479001600 + z * c));
    c = -0.5 + z * (1. / 24 + z * (-1. / 720 + z * c));
    point4 sine = longer * (angle + angle * z * s), cosine = longer * (1 + z * c);
    *x = CHOOSE4(wide, cosine, sine);
    *y = CHOOSE4(wide, sine, cosine);
}

#endif
