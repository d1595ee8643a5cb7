/* SPDX-License-Identifier: MIT */
/* Four lanes: the operations of math/lanes.h with AVX2 and FMA. */
#ifndef PEN_MATH_INTERNAL_LANES_AVX2_H
#define PEN_MATH_INTERNAL_LANES_AVX2_H

#include <immintrin.h>
#include <stddef.h>
#include <stdint.h>

enum { LANES = 4 };

typedef double lanes __attribute__((vector_size(32)));
typedef int64_t lane_mask __attribute__((vector_size(32))); /* -1 or 0 */
typedef uint64_t lane_words __attribute__((vector_size(32)));
typedef uint32_t lane_halves __attribute__((vector_size(16)));

static inline lanes lanes_splat(double x)
{
    return (lanes)_mm256_set1_pd(x);
}

static inline lanes lanes_load(const double *x)
{
    return (lanes)_mm256_loadu_pd(x);
}

static inline void lanes_store(double *to, lanes x)
{
    _mm256_storeu_pd(to, (__m256d)x);
}

static inline lanes lanes_fma(lanes a, lanes b, lanes c)
{
    return (lanes)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
}

static inline lanes lanes_sqrt(lanes x)
{
    return (lanes)_mm256_sqrt_pd((__m256d)x);
}

static inline lanes lanes_abs(lanes x)
{
    return (lanes)_mm256_andnot_pd(_mm256_set1_pd(-0.0), (__m256d)x);
}

static inline lane_mask lanes_less(lanes a, lanes b)
{
    return (lane_mask)_mm256_cmp_pd((__m256d)a, (__m256d)b, _CMP_LT_OQ);
}

static inline lane_mask lanes_at_most(lanes a, lanes b)
{
    return (lane_mask)_mm256_cmp_pd((__m256d)a, (__m256d)b, _CMP_LE_OQ);
}

static inline lane_mask lanes_equal(lanes a, lanes b)
{
    return (lane_mask)_mm256_cmp_pd((__m256d)a, (__m256d)b, _CMP_EQ_OQ);
}

/* The smaller number of each lane; b if an operand is NaN. */
static inline lanes lanes_min(lanes a, lanes b)
{
    return (lanes)_mm256_min_pd((__m256d)a, (__m256d)b);
}

/* The larger number of each lane; b if an operand is NaN. */
static inline lanes lanes_max(lanes a, lanes b)
{
    return (lanes)_mm256_max_pd((__m256d)a, (__m256d)b);
}

/* The least and the largest of all lanes. */
static inline double lanes_smallest(lanes x)
{
    const __m128d half =
        _mm_min_pd(_mm256_castpd256_pd128((__m256d)x), _mm256_extractf128_pd((__m256d)x, 1));
    return _mm_cvtsd_f64(_mm_min_sd(half, _mm_unpackhi_pd(half, half)));
}

static inline double lanes_largest(lanes x)
{
    const __m128d half =
        _mm_max_pd(_mm256_castpd256_pd128((__m256d)x), _mm256_extractf128_pd((__m256d)x, 1));
    return _mm_cvtsd_f64(_mm_max_sd(half, _mm_unpackhi_pd(half, half)));
}

static inline lanes lanes_select(lane_mask m, lanes a, lanes b)
{
    return (lanes)_mm256_blendv_pd((__m256d)b, (__m256d)a, (__m256d)m);
}

static inline lane_words lanes_words(lanes x)
{
    return (lane_words)x;
}

static inline lanes lanes_of_words(lane_words w)
{
    return (lanes)w;
}

static inline lane_mask lane_words_odd(lane_words w)
{
    return (lane_mask) - (w & 1);
}

static inline lane_words lane_words_count(void)
{
    return (lane_words){0, 1, 2, 3};
}

static inline lane_halves lane_halves_count(void)
{
    return (lane_halves){0, 1, 2, 3};
}

static inline lane_words lane_words_of_halves(lane_halves w)
{
    return (lane_words)_mm256_cvtepu32_epi64((__m128i)w);
}

static inline lane_halves lane_halves_of_words(lane_words w)
{
    return __builtin_convertvector(w, lane_halves);
}

/* Loads numbers one by one, which on many processors is faster than the gather instruction. */
static inline lanes lanes_gather(const double *table, lane_words i)
{
    return (lanes){table[i[0]], table[i[1]], table[i[2]], table[i[3]]};
}

static inline lanes lanes_rows(const double *table, size_t stride, const uint32_t *i)
{
    return (lanes){table[stride * i[0]], table[stride * i[1]], table[stride * i[2]],
                   table[stride * i[3]]};
}

static inline lanes lanes_strided(const double *x, size_t stride)
{
    return (lanes){x[0], x[stride], x[2 * stride], x[3 * stride]};
}

static inline void lanes_store_strided(double *to, size_t stride, lanes x)
{
    to[0] = x[0];
    to[stride] = x[1];
    to[2 * stride] = x[2];
    to[3 * stride] = x[3];
}

static inline void lanes_store_rows(double *const *to, lanes a, lanes b, lanes c, lanes d)
{
    const __m256d ab = _mm256_unpacklo_pd((__m256d)a, (__m256d)b); /* lanes 0 and 2 */
    const __m256d ab1 = _mm256_unpackhi_pd((__m256d)a, (__m256d)b);
    const __m256d cd = _mm256_unpacklo_pd((__m256d)c, (__m256d)d);
    const __m256d cd1 = _mm256_unpackhi_pd((__m256d)c, (__m256d)d);
    _mm256_storeu_pd(to[0], _mm256_permute2f128_pd(ab, cd, 0x20));
    _mm256_storeu_pd(to[1], _mm256_permute2f128_pd(ab1, cd1, 0x20));
    _mm256_storeu_pd(to[2], _mm256_permute2f128_pd(ab, cd, 0x31));
    _mm256_storeu_pd(to[3], _mm256_permute2f128_pd(ab1, cd1, 0x31));
}

static inline double lanes_at(lanes x, int lane)
{
    return x[lane];
}

static inline lane_mask lane_mask_of(unsigned bits)
{
    return ((lane_mask){1, 2, 4, 8} & (int64_t)bits) != 0;
}

static inline lane_mask lane_mask_not(lane_mask m)
{
    return ~m;
}

static inline unsigned lane_mask_bits(lane_mask m)
{
    return (unsigned)_mm256_movemask_pd((__m256d)m);
}

#endif
