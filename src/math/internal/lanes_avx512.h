/* SPDX-License-Identifier: MIT */
/* Eight lanes: the operations of math/lanes.h with AVX-512 F and DQ. */
#ifndef PEN_MATH_INTERNAL_LANES_AVX512_H
#define PEN_MATH_INTERNAL_LANES_AVX512_H

#include <immintrin.h>
#include <stddef.h>
#include <stdint.h>

enum { LANES = 8 };

typedef double lanes __attribute__((vector_size(64)));
typedef unsigned lane_mask; /* bit i is lane i: the result of comparisons, as in __mmask8 */
typedef uint64_t lane_words __attribute__((vector_size(64)));
typedef uint32_t lane_halves __attribute__((vector_size(32)));

static inline lanes lanes_splat(double x)
{
    return (lanes)_mm512_set1_pd(x);
}

static inline lanes lanes_load(const double *x)
{
    return (lanes)_mm512_loadu_pd(x);
}

static inline void lanes_store(double *to, lanes x)
{
    _mm512_storeu_pd(to, (__m512d)x);
}

static inline lanes lanes_fma(lanes a, lanes b, lanes c)
{
    return (lanes)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c);
}

static inline lanes lanes_sqrt(lanes x)
{
    return (lanes)_mm512_sqrt_pd((__m512d)x);
}

static inline lanes lanes_abs(lanes x)
{
    return (lanes)_mm512_andnot_pd(_mm512_set1_pd(-0.0), (__m512d)x);
}

static inline lane_mask lanes_less(lanes a, lanes b)
{
    return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_LT_OQ);
}

static inline lane_mask lanes_at_most(lanes a, lanes b)
{
    return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_LE_OQ);
}

static inline lane_mask lanes_equal(lanes a, lanes b)
{
    return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_EQ_OQ);
}

/* The smaller number of each lane; b if an operand is NaN. */
static inline lanes lanes_min(lanes a, lanes b)
{
    return (lanes)_mm512_min_pd((__m512d)a, (__m512d)b);
}

/* The larger number of each lane; b if an operand is NaN. */
static inline lanes lanes_max(lanes a, lanes b)
{
    return (lanes)_mm512_max_pd((__m512d)a, (__m512d)b);
}

/* The least and the largest of all lanes. */
static inline double lanes_smallest(lanes x)
{
    return _mm512_reduce_min_pd((__m512d)x);
}

static inline double lanes_largest(lanes x)
{
    return _mm512_reduce_max_pd((__m512d)x);
}

static inline lanes lanes_select(lane_mask m, lanes a, lanes b)
{
    return (lanes)_mm512_mask_blend_pd((__mmask8)m, (__m512d)b, (__m512d)a);
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
    return _mm512_test_epi64_mask((__m512i)w, _mm512_set1_epi64(1));
}

static inline lane_words lane_words_count(void)
{
    return (lane_words){0, 1, 2, 3, 4, 5, 6, 7};
}

static inline lane_halves lane_halves_count(void)
{
    return (lane_halves){0, 1, 2, 3, 4, 5, 6, 7};
}

static inline lane_words lane_words_of_halves(lane_halves w)
{
    return (lane_words)_mm512_cvtepu32_epi64((__m256i)w);
}

static inline lane_halves lane_halves_of_words(lane_words w)
{
    return __builtin_convertvector(w, lane_halves);
}

/* Loads numbers one by one, which on many processors is faster than the gather instruction. */
static inline lanes lanes_gather(const double *table, lane_words i)
{
    return (lanes){table[i[0]], table[i[1]], table[i[2]], table[i[3]],
                   table[i[4]], table[i[5]], table[i[6]], table[i[7]]};
}

static inline lanes lanes_rows(const double *table, size_t stride, const uint32_t *i)
{
    return (lanes){table[stride * i[0]], table[stride * i[1]], table[stride * i[2]],
                   table[stride * i[3]], table[stride * i[4]], table[stride * i[5]],
                   table[stride * i[6]], table[stride * i[7]]};
}

static inline lanes lanes_strided(const double *x, size_t stride)
{
    return (lanes){x[0],          x[stride],     x[2 * stride], x[3 * stride],
                   x[4 * stride], x[5 * stride], x[6 * stride], x[7 * stride]};
}

static inline void lanes_store_strided(double *to, size_t stride, lanes x)
{
    for (int i = 0; i < LANES; i++)
        to[(size_t)i * stride] = x[i];
}

/* Stores rows of two lanes, i and i + 2. `ab` alternates the numbers of a and b, `cd` those of c
 * and d. */
static inline void lanes_store_two_rows(double *first, double *second, __m512d ab, __m512d cd,
                                        __m512i which)
{
    const __m512d rows = _mm512_permutex2var_pd(ab, which, cd);
    _mm256_storeu_pd(first, _mm512_castpd512_pd256(rows));
    _mm256_storeu_pd(second, _mm512_extractf64x4_pd(rows, 1));
}

static inline void lanes_store_rows(double *const *to, lanes a, lanes b, lanes c, lanes d)
{
    const __m512i low = _mm512_set_epi64(11, 10, 3, 2, 9, 8, 1, 0),
                  high = _mm512_set_epi64(15, 14, 7, 6, 13, 12, 5, 4);
    const __m512d even_ab = _mm512_unpacklo_pd((__m512d)a, (__m512d)b);
    const __m512d even_cd = _mm512_unpacklo_pd((__m512d)c, (__m512d)d);
    const __m512d odd_ab = _mm512_unpackhi_pd((__m512d)a, (__m512d)b);
    const __m512d odd_cd = _mm512_unpackhi_pd((__m512d)c, (__m512d)d);
    lanes_store_two_rows(to[0], to[2], even_ab, even_cd, low);
    lanes_store_two_rows(to[1], to[3], odd_ab, odd_cd, low);
    lanes_store_two_rows(to[4], to[6], even_ab, even_cd, high);
    lanes_store_two_rows(to[5], to[7], odd_ab, odd_cd, high);
}

static inline double lanes_at(lanes x, int lane)
{
    return x[lane];
}

static inline lane_mask lane_mask_of(unsigned bits)
{
    return bits;
}

static inline lane_mask lane_mask_not(lane_mask m)
{
    return m ^ 0xff;
}

static inline unsigned lane_mask_bits(lane_mask m)
{
    return m;
}

#endif
