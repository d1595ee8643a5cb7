/* SPDX-License-Identifier: MIT */
/* Vectors of doubles, one number per lane, in files that are compiled once for each instruction set
 * (PEN_ISA_LIST, base/cpu.h). The instruction set's header defines
 *
 *   LANES                        their number: 1 for base, 4 for AVX2, 8 for AVX-512
 *   lanes                        the vector. + - * / and unary - work on it, lane by lane
 *   lane_mask                    the result of a comparison. & | ^ work on it
 *   lanes_splat, lanes_load, lanes_store, lanes_fma, lanes_sqrt, lanes_abs
 *   lanes_min, lanes_max         the second operand if one is NaN
 *   lanes_smallest, lanes_largest   of all lanes, as a double; none is NaN
 *   lanes_less, lanes_at_most, lanes_equal     false if an operand is NaN
 *   lanes_select                 a where the mask is set, else b
 *   lanes_at                     the number in one lane
 *   lanes_strided, lanes_store_strided         lane i at x[i stride]
 *   lanes_store_rows             lane i of four vectors at to[i][0] to to[i][3]
 *   lanes_rows                   table[stride row[i]], an array of row numbers
 *   lane_mask_not, lane_mask_bits              bit i is lane i
 *   lane_mask_of                 the mask with these bits
 *   lane_words                   64 bits per lane. + - * & | ^ << >> work on it
 *   lanes_words, lanes_of_words  the bits of numbers, and back
 *   lane_words_odd               whether the lowest bit is set
 *   lane_words_count             0, 1 and so on, by lane
 *   lane_halves                  32 bits per lane, with the same operations
 *   lane_halves_count, lane_words_of_halves
 *   lane_halves_of_words         the lower 32 bits
 *   lanes_gather                 table[i], i from 0 on
 *
 * Every operation rounds like the scalar one. So code that is written once in lanes gives the same
 * bits for every instruction set. These are also the bits of the scalar function with the same
 * operations in the same order; a comment names that function. Branches become masks. */
#ifndef PEN_MATH_LANES_H
#define PEN_MATH_LANES_H

#include "math/exact.h"

#if defined(__AVX512F__) && defined(__AVX512DQ__)
#include "math/internal/lanes_avx512.h"
#elif defined(__AVX2__)
#include "math/internal/lanes_avx2.h"
#else
#include "math/internal/lanes_base.h"
#endif

enum { LANES_ALL = (1 << LANES) - 1 }; /* as lane_mask_bits */

/* Converts words below 2^52 to numbers, through the fraction of 2^52. */
static inline lanes lanes_of_small(lane_words w)
{
    return lanes_of_words(w | UINT64_C(0x4330000000000000)) - 0x1p52;
}

/* Vectors of space, one per lane. */
struct lanes3 {
    lanes x, y, z;
};

static inline struct lanes3 lanes3_splat(struct pen_vec3 v)
{
    return (struct lanes3){lanes_splat(v.x), lanes_splat(v.y), lanes_splat(v.z)};
}

/* Lane i is v[i]. */
static inline struct lanes3 lanes3_load(const struct pen_vec3 *v)
{
    const double *x = (const double *)v;
    return (struct lanes3){lanes_strided(x, 3), lanes_strided(x + 1, 3), lanes_strided(x + 2, 3)};
}

static inline void lanes3_store(struct pen_vec3 *to, struct lanes3 v)
{
    double *x = (double *)to;
    lanes_store_strided(x, 3, v.x);
    lanes_store_strided(x + 1, 3, v.y);
    lanes_store_strided(x + 2, 3, v.z);
}

static inline struct pen_vec3 lanes3_at(struct lanes3 v, int lane)
{
    return pen_vec3(lanes_at(v.x, lane), lanes_at(v.y, lane), lanes_at(v.z, lane));
}

static inline struct lanes3 lanes3_select(lane_mask m, struct lanes3 a, struct lanes3 b)
{
    return (struct lanes3){lanes_select(m, a.x, b.x), lanes_select(m, a.y, b.y),
                           lanes_select(m, a.z, b.z)};
}

/* pen_add */
static inline struct lanes3 lanes3_add(struct lanes3 a, struct lanes3 b)
{
    return (struct lanes3){a.x + b.x, a.y + b.y, a.z + b.z};
}

/* pen_sub */
static inline struct lanes3 lanes3_sub(struct lanes3 a, struct lanes3 b)
{
    return (struct lanes3){a.x - b.x, a.y - b.y, a.z - b.z};
}

/* The vectors at table[stride row[i]]. */
static inline struct lanes3 lanes3_rows(const struct pen_vec3 *table, size_t stride,
                                        const uint32_t *row)
{
    const double *x = (const double *)table;
    return (struct lanes3){lanes_rows(x, stride, row), lanes_rows(x + 1, stride, row),
                           lanes_rows(x + 2, stride, row)};
}

/* pen_neg */
static inline struct lanes3 lanes3_neg(struct lanes3 a)
{
    return (struct lanes3){-a.x, -a.y, -a.z};
}

/* pen_scale */
static inline struct lanes3 lanes3_scale(struct lanes3 a, lanes s)
{
    return (struct lanes3){a.x * s, a.y * s, a.z * s};
}

/* pen_mul */
static inline struct lanes3 lanes3_mul(struct lanes3 a, struct lanes3 b)
{
    return (struct lanes3){a.x * b.x, a.y * b.y, a.z * b.z};
}

/* pen_dot */
static inline lanes lanes3_dot(struct lanes3 a, struct lanes3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* pen_length */
static inline lanes lanes3_length(struct lanes3 a)
{
    return lanes_sqrt(lanes3_dot(a, a));
}

/* pen_normalize */
static inline struct lanes3 lanes3_normalize(struct lanes3 a)
{
    return lanes3_scale(a, 1.0 / lanes3_length(a));
}

/* pen_along */
static inline struct lanes3 lanes3_along(struct lanes3 a, struct lanes3 d, lanes t)
{
    return (struct lanes3){a.x + t * d.x, a.y + t * d.y, a.z + t * d.z};
}

/* pen_norm1 */
static inline lanes lanes3_norm1(struct lanes3 a)
{
    return lanes_abs(a.x) + lanes_abs(a.y) + lanes_abs(a.z);
}

/* The sum of the sizes of the products in a dot product. */
static inline lanes lanes3_dot_size(struct lanes3 a, struct lanes3 b)
{
    return lanes_abs(a.x * b.x) + lanes_abs(a.y * b.y) + lanes_abs(a.z * b.z);
}

/* pen_dop */
static inline lanes lanes_dop(lanes a, lanes b, lanes c, lanes d)
{
    lanes w = c * d;
    lanes e = lanes_fma(-c, d, w);
    lanes f = lanes_fma(a, b, -w);
    return f + e;
}

/* pen_cross */
static inline struct lanes3 lanes3_cross(struct lanes3 a, struct lanes3 b)
{
    return (struct lanes3){lanes_dop(a.y, b.z, a.z, b.y), lanes_dop(a.z, b.x, a.x, b.z),
                           lanes_dop(a.x, b.y, a.y, b.x)};
}

/* pen_along_once */
static inline struct lanes3 lanes3_along_once(struct lanes3 a, struct lanes3 d, lanes t)
{
    return (struct lanes3){lanes_fma(t, d.x, a.x), lanes_fma(t, d.y, a.y), lanes_fma(t, d.z, a.z)};
}

/* pen_difference_error3 */
static inline struct lanes3 lanes3_difference_error(struct lanes3 a, struct lanes3 b,
                                                    struct lanes3 diff)
{
    const struct lanes3 part = lanes3_sub(diff, a);
    return (struct lanes3){(a.x - (diff.x - part.x)) - (b.x + part.x),
                           (a.y - (diff.y - part.y)) - (b.y + part.y),
                           (a.z - (diff.z - part.z)) - (b.z + part.z)};
}

/* The rounding error of a sum. */
static inline lanes lanes_sum_error(lanes a, lanes b, lanes sum)
{
    lanes part = sum - a;
    return (a - (sum - part)) + (b - part);
}

/* pen_dot2_plus */
static inline lanes lanes3_dot2_plus(lanes c, struct lanes3 a, struct lanes3 b, lanes rest)
{
    lanes x = a.x * b.x, y = a.y * b.y, z = a.z * b.z, low = lanes_splat(0), sum = c + x;
    low += lanes_sum_error(c, x, sum) + lanes_fma(a.x, b.x, -x);
    lanes next = sum + y;
    low += lanes_sum_error(sum, y, next) + lanes_fma(a.y, b.y, -y);
    sum = next + z;
    low += lanes_sum_error(next, z, sum) + lanes_fma(a.z, b.z, -z);
    return sum + (low + rest);
}

#endif
