/* SPDX-License-Identifier: MIT */
/* The functions of math/sample.h for four points at once, in the compiler's own vector types, which
 * work on any processor. The same operations in the same order, so the same bits. */
#ifndef PEN_SHADE_INTERNAL_LIGHT_POINTS4_H
#define PEN_SHADE_INTERNAL_LIGHT_POINTS4_H

#include <stdint.h>

typedef double double4 __attribute__((vector_size(32)));
typedef int64_t mask4 __attribute__((vector_size(32)));
typedef uint64_t ulong4 __attribute__((vector_size(32)));
typedef uint32_t uint4 __attribute__((vector_size(16)));

/* The finalizer of SplitMix64. */
static inline void points_mix(ulong4 *z)
{
    *z = (*z ^ *z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    *z = (*z ^ *z >> 27) * UINT64_C(0x94D049BB133111EB);
    *z = *z ^ *z >> 31;
}

/* The middles of 2^32 cells of [0, 1). A whole number below 2^52 becomes a double through its bits:
 * it is put in the fraction of 2^52. */
static inline void points_unit(const ulong4 *cell, double4 *out)
{
    const double4 big = {0x1p52, 0x1p52, 0x1p52, 0x1p52};
    double4 whole = (double4)(*cell | UINT64_C(0x4330000000000000)) - big;
    *out = (whole + 0.5) * 0x1p-32;
}

/* pen_random2 of indices index .. index + 3. */
static inline void points_random(uint64_t hash, uint32_t index, double4 *x, double4 *y)
{
    const ulong4 step = {1, 2, 3, 4};
    ulong4 bits = hash + (index + step) * UINT64_C(0x9E3779B97F4A7C15);
    points_mix(&bits);
    ulong4 low = bits & UINT32_MAX, high = bits >> 32;
    points_unit(&low, x);
    points_unit(&high, y);
}

static inline void points_reverse(uint4 *x)
{
    uint4 v = *x >> 16 | *x << 16;
    v = (v >> 8 & 0x00FF00FF) | (v & 0x00FF00FF) << 8;
    v = (v >> 4 & 0x0F0F0F0F) | (v & 0x0F0F0F0F) << 4;
    v = (v >> 2 & 0x33333333) | (v & 0x33333333) << 2;
    *x = (v >> 1 & 0x55555555) | (v & 0x55555555) << 1;
}

static inline void points_scramble(uint4 *x, uint32_t seed)
{
    uint4 v = *x;
    v ^= v * 0x3D20ADEAu;
    v += seed;
    v *= seed >> 16 | 1u;
    v ^= v * 0x05526C56u;
    *x = v ^ v * 0x53A22864u;
}

static inline void points_widen(const uint4 *x, ulong4 *out)
{
    *out = (ulong4){(*x)[0], (*x)[1], (*x)[2], (*x)[3]};
}

/* pen_sobol2 of indices index .. index + 3. */
static inline void points_sobol(uint64_t hash, uint32_t index, double4 *x, double4 *y)
{
    const uint4 step = {0, 1, 2, 3};
    uint4 s = index + step;
    points_reverse(&s);
    points_scramble(&s, (uint32_t)(hash * UINT64_C(0x9E3779B97F4A7C15) >> 32));
    points_reverse(&s);
    uint4 first = s, second = s ^ s >> 16;
    second ^= second >> 8 & 0x00FF00FF;
    second ^= second >> 4 & 0x0F0F0F0F;
    second ^= second >> 2 & 0x33333333;
    second ^= second >> 1 & 0x55555555;
    points_scramble(&first, (uint32_t)hash);
    points_scramble(&second, (uint32_t)(hash >> 32));
    points_reverse(&first);
    points_reverse(&second);
    ulong4 wide;
    points_widen(&first, &wide);
    points_unit(&wide, x);
    points_widen(&second, &wide);
    points_unit(&wide, y);
}

#define SELECT4(m, a, b) ((double4)(((mask4)(a) & (m)) | ((mask4)(b) & ~(m))))

/* pen_disk_of_square, without its case for the square's middle lines: points_unit gives no such
 * point. */
static inline void points_disk(double4 *x, double4 *y)
{
    double4 a = 2 * *x - 1, b = 2 * *y - 1;
    double4 size_a = (double4)((mask4)a & INT64_MAX), size_b = (double4)((mask4)b & INT64_MAX);
    mask4 wide = size_a > size_b;
    double4 longer = SELECT4(wide, a, b), shorter = SELECT4(wide, b, a);
    double4 angle = 0x1.921fb54442d18p-1 * (shorter / longer), z = angle * angle;
    double4 s = 1. / 6227020800 + z * (-1. / 1307674368000);
    s = 1. / 362880 + z * (-1. / 39916800 + z * s);
    s = -1. / 6 + z * (1. / 120 + z * (-1. / 5040 + z * s));
    double4 c = -1. / 87178291200 + z * (1. / 20922789888000);
    c = 1. / 40320 + z * (-1. / 3628800 + z * (1. / 479001600 + z * c));
    c = -0.5 + z * (1. / 24 + z * (-1. / 720 + z * c));
    double4 sine = longer * (angle + angle * z * s), cosine = longer * (1 + z * c);
    *x = SELECT4(wide, cosine, sine);
    *y = SELECT4(wide, sine, cosine);
}

#endif
