/* SPDX-License-Identifier: MIT */
/* Floats in lanes for meshes: the triangles of one or two blocks, the eight boxes of a node. Each
 * operation is one IEEE operation per lane, so every instruction set has the same bits. */
#ifndef PEN_ACCEL_INTERNAL_MESH_LANES_H
#define PEN_ACCEL_INTERNAL_MESH_LANES_H

#include <math.h>

#include "accel/internal/floats8.h"

#if defined __AVX2__ && defined __FMA__
#define MESH_FMA 1
enum { MESH_BLOCKS = 2 };
#else
#define MESH_FMA 0
enum { MESH_BLOCKS = 1 };
#endif
enum { MESH_LANES = 4 * MESH_BLOCKS };

/* Three coordinates; the last lane is 0 or of no use. */
typedef double double4 __attribute__((vector_size(32), aligned(8), may_alias));
typedef float float4 __attribute__((vector_size(16), aligned(4), may_alias));
typedef int32_t mask4 __attribute__((vector_size(16)));
/* MESH_LANES floats, and a mask for them. */
typedef float floats __attribute__((vector_size(4 * MESH_LANES), aligned(4), may_alias));
typedef int32_t masks __attribute__((vector_size(4 * MESH_LANES)));

#define SPLAT8(x) ((float8){(x), (x), (x), (x), (x), (x), (x), (x)})

#define THREE(x) ((float4)((mask4)(x) & (mask4){-1, -1, -1, 0}))

#if MESH_FMA

static inline float4 float4_max(float4 a, float4 b)
{
    return (float4)_mm_max_ps((__m128)a, (__m128)b);
}

/* The signs of four floats, as bits. */
static inline unsigned float4_signs(float4 a)
{
    return (unsigned)_mm_movemask_ps((__m128)a);
}

static inline floats floats_splat(float x)
{
    return SPLAT8(x);
}

/* Four floats of each block. */
static inline floats floats_load(const float *a, const float *b)
{
    return (floats)_mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(a)), _mm_loadu_ps(b),
                                        1);
}

static inline floats floats_fma(floats a, floats b, floats c)
{
    return (floats)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
}

/* a if a < b, else b; a if a > b, else b. */
static inline floats floats_min(floats a, floats b)
{
    return (floats)_mm256_min_ps((__m256)a, (__m256)b);
}

static inline floats floats_max(floats a, floats b)
{
    return (floats)_mm256_max_ps((__m256)a, (__m256)b);
}

/* a > b, a >= b. With AVX-512, the compiler's own comparisons would take the way round by its mask
 * registers. */
static inline masks floats_more(floats a, floats b)
{
    return (masks)_mm256_cmp_ps((__m256)a, (__m256)b, _CMP_GT_OQ);
}

static inline masks floats_at_least(floats a, floats b)
{
    return (masks)_mm256_cmp_ps((__m256)a, (__m256)b, _CMP_GE_OQ);
}

/* The lanes that are set, as bits. */
static inline unsigned masks_bits(masks m)
{
    return (unsigned)_mm256_movemask_ps((__m256)m);
}

/* *to = the larger, or smaller, of a b + c and *to; *to if the former is NaN. */
static inline void raise8f(float8 *to, const float *a, const float8 *b, const float8 *c)
{
    const __m256 x = _mm256_fmadd_ps(_mm256_loadu_ps(a), (__m256)*b, (__m256)*c);
    *to = (float8)_mm256_max_ps(x, (__m256)*to);
}

static inline void lower8f(float8 *to, const float *a, const float8 *b, const float8 *c)
{
    const __m256 x = _mm256_fmadd_ps(_mm256_loadu_ps(a), (__m256)*b, (__m256)*c);
    *to = (float8)_mm256_min_ps(x, (__m256)*to);
}

#else

static inline float4 float4_max(float4 a, float4 b)
{
    const mask4 more = a > b;
    return (float4)(((mask4)a & more) | ((mask4)b & ~more));
}

static inline unsigned float4_signs(float4 a)
{
    const mask4 m = (mask4)a < 0;
    return (unsigned)((m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8));
}

static inline floats floats_splat(float x)
{
    return (floats){x, x, x, x};
}

static inline floats floats_load(const float *a, const float *b)
{
    (void)b;
    return *(const floats *)a;
}

static inline floats floats_fma(floats a, floats b, floats c)
{
    return (floats){fmaf(a[0], b[0], c[0]), fmaf(a[1], b[1], c[1]), fmaf(a[2], b[2], c[2]),
                    fmaf(a[3], b[3], c[3])};
}

static inline floats floats_min(floats a, floats b)
{
    const masks less = a < b;
    return (floats)(((masks)a & less) | ((masks)b & ~less));
}

static inline floats floats_max(floats a, floats b)
{
    const masks more = a > b;
    return (floats)(((masks)a & more) | ((masks)b & ~more));
}

static inline masks floats_more(floats a, floats b)
{
    return a > b;
}

static inline masks floats_at_least(floats a, floats b)
{
    return a >= b;
}

static inline unsigned masks_bits(masks m)
{
    return (unsigned)((m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8));
}

static inline void raise8f(float8 *to, const float *a, const float8 *b, const float8 *c)
{
    for (int i = 0; i < 8; i++) {
        const float x = fmaf(a[i], (*b)[i], (*c)[i]);
        (*to)[i] = x > (*to)[i] ? x : (*to)[i];
    }
}

static inline void lower8f(float8 *to, const float *a, const float8 *b, const float8 *c)
{
    for (int i = 0; i < 8; i++) {
        const float x = fmaf(a[i], (*b)[i], (*c)[i]);
        (*to)[i] = x < (*to)[i] ? x : (*to)[i];
    }
}

#endif

static inline double double4_largest(const double4 *v)
{
    const double x = fabs((*v)[0]), y = fabs((*v)[1]), z = fabs((*v)[2]), m = x > y ? x : y;
    return m > z ? m : z;
}

/* The largest size of three coordinates. */
static inline float float4_largest(float4 x)
{
    const float4 size = (float4)((mask4)x & INT32_MAX);
    const float4 yzx = __builtin_shufflevector(size, size, 1, 2, 0, 3),
                 zxy = __builtin_shufflevector(size, size, 2, 0, 1, 3);
    return float4_max(float4_max(size, yzx), zxy)[0];
}

static inline floats floats_abs(floats x)
{
    return (floats)((masks)x & INT32_MAX);
}

/* x with its sign changed where `sign`, which is 0 or -0, is negative. */
static inline floats floats_turned(floats x, masks sign)
{
    return (floats)((masks)x ^ sign);
}

/* a b - c d, the first product not rounded. */
static inline floats floats_minus(floats a, floats b, floats c, floats d)
{
    return floats_fma(a, b, -(c * d));
}

struct floats3 {
    floats x, y, z;
};

static inline struct floats3 floats3_sub(struct floats3 a, struct floats3 b)
{
    return (struct floats3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline struct floats3 floats3_cross(struct floats3 a, struct floats3 b)
{
    return (struct floats3){floats_minus(a.y, b.z, a.z, b.y), floats_minus(a.z, b.x, a.x, b.z),
                            floats_minus(a.x, b.y, a.y, b.x)};
}

static inline floats floats3_dot(struct floats3 a, struct floats3 b)
{
    return floats_fma(a.x, b.x, floats_fma(a.y, b.y, a.z * b.z));
}

static inline floats floats3_norm1(struct floats3 a)
{
    return floats_abs(a.x) + floats_abs(a.y) + floats_abs(a.z);
}

#endif
