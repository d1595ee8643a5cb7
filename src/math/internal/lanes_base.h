/* SPDX-License-Identifier: MIT */
/* One lane: the operations of math/lanes.h on plain doubles, for any processor. */
#ifndef PEN_MATH_INTERNAL_LANES_BASE_H
#define PEN_MATH_INTERNAL_LANES_BASE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { LANES = 1 };

typedef double lanes;
typedef int lane_mask; /* 1 or 0 */
typedef uint64_t lane_words;
typedef uint32_t lane_halves;

static inline lanes lanes_splat(double x)
{
    return x;
}

static inline lanes lanes_load(const double *x)
{
    return *x;
}

static inline void lanes_store(double *to, lanes x)
{
    *to = x;
}

static inline lanes lanes_fma(lanes a, lanes b, lanes c)
{
    return fma(a, b, c);
}

static inline lanes lanes_sqrt(lanes x)
{
    return sqrt(x);
}

static inline lanes lanes_abs(lanes x)
{
    return fabs(x);
}

static inline lane_mask lanes_less(lanes a, lanes b)
{
    return a < b;
}

static inline lane_mask lanes_at_most(lanes a, lanes b)
{
    return a <= b;
}

static inline lane_mask lanes_equal(lanes a, lanes b)
{
    return a == b;
}

/* The smaller number; b if an operand is NaN. */
static inline lanes lanes_min(lanes a, lanes b)
{
    return a < b ? a : b;
}

/* The larger number; b if an operand is NaN. */
static inline lanes lanes_max(lanes a, lanes b)
{
    return a > b ? a : b;
}

/* The least and the largest of all lanes. */
static inline double lanes_smallest(lanes x)
{
    return x;
}

static inline double lanes_largest(lanes x)
{
    return x;
}

static inline lanes lanes_select(lane_mask m, lanes a, lanes b)
{
    return m ? a : b;
}

static inline lane_words lanes_words(lanes x)
{
    lane_words w;
    memcpy(&w, &x, sizeof w);
    return w;
}

static inline lanes lanes_of_words(lane_words w)
{
    lanes x;
    memcpy(&x, &w, sizeof x);
    return x;
}

static inline lane_mask lane_words_odd(lane_words w)
{
    return w & 1;
}

static inline lane_words lane_words_count(void)
{
    return 0;
}

static inline lane_halves lane_halves_count(void)
{
    return 0;
}

static inline lane_words lane_words_of_halves(lane_halves w)
{
    return w;
}

static inline lane_halves lane_halves_of_words(lane_words w)
{
    return (lane_halves)w;
}

static inline lanes lanes_gather(const double *table, lane_words i)
{
    return table[i];
}

static inline lanes lanes_rows(const double *table, size_t stride, const uint32_t *i)
{
    return table[stride * *i];
}

static inline lanes lanes_strided(const double *x, size_t stride)
{
    (void)stride;
    return *x;
}

static inline void lanes_store_strided(double *to, size_t stride, lanes x)
{
    (void)stride;
    *to = x;
}

static inline void lanes_store_rows(double *const *to, lanes a, lanes b, lanes c, lanes d)
{
    to[0][0] = a;
    to[0][1] = b;
    to[0][2] = c;
    to[0][3] = d;
}

static inline double lanes_at(lanes x, int lane)
{
    (void)lane;
    return x;
}

static inline lane_mask lane_mask_of(unsigned bits)
{
    return (lane_mask)bits & 1;
}

static inline lane_mask lane_mask_not(lane_mask m)
{
    return !m;
}

static inline unsigned lane_mask_bits(lane_mask m)
{
    return (unsigned)m;
}

#endif
