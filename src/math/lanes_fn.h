/* SPDX-License-Identifier: MIT */
/* Elementary functions in lanes. Those of math/fn.h are the same source with one lane (fn.c).
 *
 * The most frequent function is pow, for highlights: x^y = exp(y log x). A relative error of log x
 * is multiplied by y log x, up to 745, so the logarithm must have about 14 bits more than a double.
 * It is therefore an unevaluated sum of two doubles with a relative error below 2^-66, and the
 * exponential takes such a sum.
 *
 * Products that must be exact are formed from factors cut to 26 bits, not with fma, which on the
 * baseline x86-64 would be a slow call. Tables reduce arguments (Tang, ACM TOMS 15 and 16, 1989 and
 * 1990) so finely that Taylor polynomials are enough.
 *
 * Lanes with special arguments are computed like the others; their results are meaningless and are
 * then replaced. An expensive and rare step is skipped if no lane needs it. */
#ifndef PEN_MATH_LANES_FN_H
#define PEN_MATH_LANES_FN_H

#include <stdbool.h>

#include "math/internal/fn_tables.h"
#include "math/lanes.h"

struct lanes_sum {
    lanes hi, lo; /* hi + lo, |lo| within an ulp or so of hi */
};

/* Adding and subtracting it rounds a double below 2^51 in size to the nearest integer, which
 * remains in the low bits of the sum. */
static const double LANES_ROUNDER = 0x1.8p52;

/* x truncated to its upper 26 bits; the product of two such numbers is exact. */
static inline lanes lanes_upper(lanes x)
{
    return lanes_of_words(lanes_words(x) & UINT64_C(0xFFFFFFFFF8000000));
}

/* a + b exactly, given |a| >= |b| or a = 0.
 * Source: Dekker, Numer. Math. 18, 1971. */
static inline struct lanes_sum lanes_add_ordered(lanes a, lanes b)
{
    lanes s = a + b;
    return (struct lanes_sum){s, b - (s - a)};
}

/* a + b exactly.
 * Source: Knuth, TAOCP vol. 2, 4.2.2. */
static inline struct lanes_sum lanes_add(lanes a, lanes b)
{
    lanes s = a + b;
    return (struct lanes_sum){s, lanes_sum_error(a, b, s)};
}

/* The nearest integer of a number to which LANES_ROUNDER has been added. */
static inline lane_words lanes_shifted_integer(lanes shifted)
{
    return lanes_words(shifted) - UINT64_C(0x4338000000000000);
}

/* 2^e, e in two's complement, from -1022 to 1023. */
static inline lanes lanes_power_of_2(lane_words e)
{
    return lanes_of_words((e + 1023) << 52);
}

/* value 2^e for 1/2 < value < 4 and any whole number e. Rounds once, and only if the result is
 * subnormal. */
static inline lanes lanes_scale(lanes value, lanes e)
{
    const lane_words n = lanes_shifted_integer(e + LANES_ROUNDER);
    const lane_mask large = lanes_less(lanes_splat(1000), e);
    const lane_mask small = lanes_less(e, lanes_splat(-1000));
    lanes first = lanes_select(small, lanes_power_of_2(n + 1000), lanes_power_of_2(n));
    lanes then = lanes_select(small, lanes_splat(0x1p-1000), lanes_splat(1));
    first = lanes_select(large, lanes_splat(0x1p1000), first);
    then = lanes_select(large, lanes_power_of_2(n - 1000), then);
    return value * first * then;
}

/* e^(hi + lo), |lo| < 2^-20 max(1, |hi|).
 * hi + lo = k ln 2 / 128 + r with |r| <= 0.0028; e^r - 1 by Taylor's series to r^5, whose next term
 * is below 2^-60. All errors except that of the last addition are below 0.01 ulp. */
static inline lanes lanes_exp_of_sum(lanes hi, lanes lo)
{
    const lane_mask finite = lanes_less(hi, lanes_splat(710)); /* NaN stays NaN */
    const lane_mask vanishes = lanes_less(hi, lanes_splat(-746));
    lanes shifted = hi * STEPS_PER_UNIT + LANES_ROUNDER;
    lane_words k = lanes_shifted_integer(shifted), i = k & (EXP_STEPS - 1);
    lanes steps = shifted - LANES_ROUNDER;
    lanes r = ((hi - steps * STEP_HI) - steps * STEP_LO) + lo;
    lanes tail = lanes_gather(&exp_table[0].tail, i + i);
    lanes rr = r * r;
    lanes grown = tail + r + rr * (0.5 + r * (1. / 6)) + rr * rr * (1. / 24 + r * (1. / 120));
    lanes value = lanes_gather(&exp_table[0].value, i + i);
    /* (k - i) / EXP_STEPS is the exponent; here it is added to that of value. */
    lanes scaled = lanes_of_words(lanes_words(value) + ((k - i) << 45));
    lanes result = scaled + scaled * grown;
    const lane_mask usual = lanes_less(lanes_abs(steps), lanes_splat(1019 * EXP_STEPS));
    if (lane_mask_bits(usual) == LANES_ALL)
        return result;
    lanes e = (steps - lanes_of_small(i)) * (1. / EXP_STEPS);
    result = lanes_select(usual, result, lanes_scale(value + value * grown, e));
    result = lanes_select(vanishes, lanes_splat(0), result);
    return lanes_select(finite, result, hi + (double)INFINITY);
}

/* ln(1 + r) - r + r^2/2 for |r| < 0.0064, by Taylor's series to r^9. */
static inline lanes lanes_log_rest(lanes r)
{
    lanes rr = r * r;
    lanes a = 1. / 3 + r * (-1. / 4);
    lanes b = 1. / 5 + r * (-1. / 6);
    lanes c = 1. / 7 + r * (-1. / 8) + rr * (1. / 9);
    return r * rr * (a + rr * (b + rr * c));
}

/* ln x for finite x > 0.
 * x = 2^k z. With c the table's inverse of z's cell, ln x = k ln 2 - ln c + ln(1 + r), r = z c - 1.
 * c has so few bits that r is exact as a sum of two doubles. If x is near 1, c is 1 and k is 0, so
 * the relative error stays small where ln x vanishes. */
static inline struct lanes_sum lanes_log_sum(lanes x)
{
    const lane_mask subnormal = lanes_less(x, lanes_splat(0x1p-1022));
    const lane_words bits = lanes_words(lanes_select(subnormal, x * 0x1p54, x));
    const lane_words above = bits - LOG_FIRST;
    const lane_words exponent = above & UINT64_C(0xFFF0000000000000);
    lanes k = lanes_of_small((exponent ^ UINT64_C(1) << 63) >> 52);
    k -= lanes_select(subnormal, lanes_splat(2048 + 54), lanes_splat(2048));
    lane_words i = (above >> 45) & (LOG_STEPS - 1), zbits = bits - exponent;
    i = i + i + i; /* the table has three numbers in a row */
    lanes z = lanes_of_words(zbits), zh = lanes_of_words(zbits & UINT64_C(0xFFFFFFFF00000000));
    lanes c = lanes_gather(&log_table[0].inverse, i);
    struct lanes_sum r = lanes_add(zh * c - 1, (z - zh) * c);
    lanes rh = lanes_upper(r.hi);
    struct lanes_sum s =
        lanes_add_ordered(k * LN2_HI + lanes_gather(&log_table[0].log_hi, i), r.hi);
    struct lanes_sum t = lanes_add_ordered(s.hi, -0.5 * rh * rh);
    lanes small = k * LN2_LO + lanes_gather(&log_table[0].log_lo, i) + r.lo * (1 - r.hi);
    lanes lo = s.lo + t.lo + small - 0.5 * (r.hi - rh) * (r.hi + rh) + lanes_log_rest(r.hi);
    return lanes_add_ordered(t.hi, lo);
}

/* Whether x is finite and > 0. */
static inline lane_mask lanes_positive(lanes x)
{
    return lanes_less(lanes_splat(0), x) & lanes_at_most(x, lanes_splat(0x1.fffffffffffffp1023));
}

/* pen_exp */
static inline lanes lanes_exp(lanes x)
{
    return lanes_exp_of_sum(x, lanes_splat(0));
}

/* pen_ln */
static inline lanes lanes_ln(lanes x)
{
    const lane_mask usual = lanes_positive(x);
    lanes result = lanes_log_sum(lanes_select(usual, x, lanes_splat(1))).hi;
    if (lane_mask_bits(usual) == LANES_ALL)
        return result;
    const lane_mask zero = lanes_equal(x, lanes_splat(0));
    lanes edge = lanes_select(zero, lanes_splat(-(double)INFINITY), lanes_splat((double)NAN));
    edge = lanes_select(lanes_less(lanes_splat(0), x), x, edge); /* infinite */
    return lanes_select(usual, result, edge);
}

/* x^y for an infinite x > 0, for NaN x, and for a y that is huge, infinite or NaN. */
static inline lanes lanes_pow_edge(lanes x, lanes y)
{
    const lanes zero = lanes_splat(0), one = lanes_splat(1);
    const lane_mask falls = lanes_less(one, x) ^ lanes_less(zero, y);
    lanes result = lanes_select(falls, zero, lanes_splat((double)INFINITY));
    result = lanes_select(lanes_equal(x, one) | lanes_equal(y, zero), one, result);
    result = lanes_select(lanes_equal(y, y), result, y);
    return lanes_select(lanes_equal(x, x), result, x);
}

/* pen_pow */
static inline lanes lanes_pow(lanes x, lanes y)
{
    const lane_mask nothing = lanes_at_most(x, lanes_splat(0));
    const lane_mask usual = lanes_positive(x) & lanes_less(lanes_abs(y), lanes_splat(0x1p64));
    lanes result = lanes_splat(0);
    if (lane_mask_bits(usual)) {
        struct lanes_sum log = lanes_log_sum(lanes_select(usual, x, lanes_splat(1)));
        lanes yh = lanes_upper(y), lh = lanes_upper(log.hi);
        lanes lo = (y - yh) * lh + y * ((log.hi - lh) + log.lo);
        result = lanes_select(usual, lanes_exp_of_sum(yh * lh, lo), result);
    }
    const lane_mask edge = lane_mask_not(usual | nothing);
    return lane_mask_bits(edge) ? lanes_select(edge, lanes_pow_edge(x, y), result) : result;
}

/* Sine of a reduced angle, |hi| < 0.8, by Taylor's series to the 17th power. */
static inline lanes lanes_sine_of_sum(struct lanes_sum a)
{
    lanes z = a.hi * a.hi;
    lanes p =
        -1. / 6 +
        z * (1. / 120 + z * (-1. / 5040 +
                             z * (1. / 362880 +
                                  z * (-1. / 39916800 +
                                       z * (1. / 6227020800 + z * (-1. / 1307674368000 +
                                                                   z * (1. / 355687428096000)))))));
    return a.hi + (a.hi * z * p + a.lo * (1 - 0.5 * z));
}

/* Cosine of a reduced angle, to the 18th power. The rounding errors of 1 - z/2 and of z are added
 * back, since they are not small beside the result. */
static inline lanes lanes_cosine_of_sum(struct lanes_sum a)
{
    lanes z = a.hi * a.hi, h = lanes_upper(a.hi), l = a.hi - h;
    lanes lost = ((h * h - z) + 2 * h * l) + l * l;
    lanes q = 1. / 24 +
              z * (-1. / 720 +
                   z * (1. / 40320 +
                        z * (-1. / 3628800 +
                             z * (1. / 479001600 +
                                  z * (-1. / 87178291200 + z * (1. / 20922789888000 +
                                                                z * (-1. / 6402373705728000)))))));
    struct lanes_sum w = lanes_add_ordered(lanes_splat(1), -0.5 * z);
    return w.hi + (w.lo - 0.5 * lost + (z * z * q - a.hi * a.lo));
}

/* Adds quarter turns to an angle, given and returned as its sine and cosine. Outside the range of
 * the reduction they are NaN. */
static inline void lanes_turn(lane_words quarters, lane_mask inside, lanes *sine, lanes *cosine)
{
    const lane_mask odd = lane_words_odd(quarters);
    const lanes nan = lanes_splat((double)NAN);
    lanes s = lanes_select(odd, *cosine, *sine), c = lanes_select(odd, *sine, *cosine);
    s = lanes_select(lane_words_odd(quarters >> 1), -s, s);
    c = lanes_select(lane_words_odd((quarters + 1) >> 1), -c, c);
    *sine = lanes_select(inside, s, nan);
    *cosine = lanes_select(inside, c, nan);
}

/* pen_sincos. The reduced angle must keep its relative precision even when it is nearly 0. For
 * doubles below 2^20 it is never nearer to 0 than 2^-64, and the four parts of pi/2 reach 2^-150.
 */
static inline void lanes_sincos(lanes x, lanes *sine, lanes *cosine)
{
    const lane_mask inside = lanes_at_most(lanes_abs(x), lanes_splat(0x1p20));
    lanes shifted = x * QUARTERS_PER_RADIAN + LANES_ROUNDER;
    lanes k = shifted - LANES_ROUNDER;
    struct lanes_sum a = lanes_add(x - k * HALF_PI_1, -k * HALF_PI_2);
    struct lanes_sum b = lanes_add(a.hi, -k * HALF_PI_3);
    struct lanes_sum reduced = lanes_add_ordered(b.hi, a.lo + b.lo - k * HALF_PI_4);
    *sine = lanes_sine_of_sum(reduced);
    *cosine = lanes_cosine_of_sum(reduced);
    lanes_turn(lanes_shifted_integer(shifted), inside, sine, cosine);
}

/* pen_sincos_deg */
static inline void lanes_sincos_deg(lanes degrees, lanes *sine, lanes *cosine)
{
    const lane_mask inside = lanes_at_most(lanes_abs(degrees), lanes_splat(0x1p20));
    lanes shifted = degrees * (1. / 90) + LANES_ROUNDER;
    lanes f = degrees - (shifted - LANES_ROUNDER) * 90; /* exact */
    lanes fh = lanes_upper(f);
    struct lanes_sum a = lanes_add_ordered(fh * DEGREE_HI, (f - fh) * DEGREE_HI + f * DEGREE_LO);
    const lane_mask thirty = lanes_equal(lanes_abs(f), lanes_splat(30));
    *sine = lanes_select(thirty, f / 60, lanes_sine_of_sum(a));
    *cosine = lanes_cosine_of_sum(a);
    lanes_turn(lanes_shifted_integer(shifted), inside, sine, cosine);
}

#endif
