/* SPDX-License-Identifier: MIT */
/* Elementary functions. The one called most is pow, for highlights: x^y = exp(y log x). A relative
 * error of log x is multiplied by y log x, up to 745, so the logarithm must carry about 14 bits
 * more than a double. It is therefore an unevaluated sum of two doubles with a relative error below
 * 2^-66, and the exponential takes such a sum.
 *
 * Products that must be exact are formed from factors cut to 26 bits, not with fma, which on the
 * baseline x86-64 would be a slow call. Arguments are reduced by tables (Tang, ACM
 * TOMS 15 and 16, 1989 and 1990) so finely that Taylor polynomials serve. */
#include "math/fn.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "math/internal/fn_tables.h"

struct sum {
    double hi, lo; /* hi + lo, |lo| within an ulp or so of hi */
};

/* Adding and subtracting it rounds a double below 2^51 in size to the nearest integer. */
static const double ROUNDER = 0x1.8p52;

static uint64_t bits_of(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static double of_bits(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* x truncated to its upper 26 bits; the product of two such numbers is exact. */
static double upper(double x)
{
    return of_bits(bits_of(x) & UINT64_C(0xFFFFFFFFF8000000));
}

/* a + b exactly; |a| >= |b| or a = 0. Source: Dekker, Numer. Math. 18, 1971. */
static struct sum add_ordered(double a, double b)
{
    double s = a + b;
    return (struct sum){s, b - (s - a)};
}

/* a + b exactly. Source: Knuth, TAOCP vol. 2, 4.2.2. */
static struct sum add(double a, double b)
{
    double s = a + b, part = s - a;
    return (struct sum){s, (a - (s - part)) + (b - part)};
}

/* The nearest integer of a ROUNDER-shifted double, from its low bits. */
static int32_t shifted_integer(double shifted)
{
    return (int32_t)(uint32_t)bits_of(shifted);
}

/* value 2^e for 1/2 < value < 4, whatever e; rounds once, and only a result that is subnormal. */
static double scale(double value, int e)
{
    if (e > 1000)
        return value * 0x1p1000 * of_bits((uint64_t)(e - 1000 + 1023) << 52);
    if (e < -1000)
        return value * of_bits((uint64_t)(e + 1000 + 1023) << 52) * 0x1p-1000;
    return value * of_bits((uint64_t)(e + 1023) << 52);
}

/* e^(hi + lo), |lo| < 2^-20 max(1, |hi|).
 * hi + lo = k ln 2 / 128 + r with |r| <= 0.0028; e^r - 1 by Taylor's series to r^5, whose next
 * term is below 2^-60. All errors but the last addition's are below 0.01 ulp. */
static double exp_of_sum(double hi, double lo)
{
    if (!(hi < 710))
        return hi + (double)INFINITY; /* NaN stays NaN */
    if (hi < -746)
        return 0;
    double shifted = hi * STEPS_PER_UNIT + ROUNDER;
    int32_t k = shifted_integer(shifted);
    double steps = shifted - ROUNDER;
    double r = ((hi - steps * STEP_HI) - steps * STEP_LO) + lo;
    uint32_t i = (uint32_t)k % EXP_STEPS;
    int32_t e = (k - (int32_t)i) / EXP_STEPS;
    double rr = r * r;
    double grown =
        exp_table[i].tail + r + rr * (0.5 + r * (1. / 6)) + rr * rr * (1. / 24 + r * (1. / 120));
    double value = exp_table[i].value;
    if (e > -1020 && e < 1020) {
        value = of_bits(bits_of(value) + ((uint64_t)(int64_t)e << 52));
        return value + value * grown;
    }
    return scale(value + value * grown, e);
}

/* ln(1 + r) - r + r^2/2 for |r| < 0.0064, Taylor's series to r^9. */
static double log_rest(double r)
{
    double rr = r * r;
    double a = 1. / 3 + r * (-1. / 4);
    double b = 1. / 5 + r * (-1. / 6);
    double c = 1. / 7 + r * (-1. / 8) + rr * (1. / 9);
    return r * rr * (a + rr * (b + rr * c));
}

/* ln x for finite x > 0.
 * x = 2^k z; with c the table's inverse of z's cell, ln x = k ln 2 - ln c + ln(1 + r),
 * r = z c - 1. c has so few bits that r is exact as a sum of two doubles, and where x is near 1, c
 * is 1 and k is 0: the relative error stays small where ln x vanishes. */
static struct sum log_sum(double x)
{
    uint64_t bits = bits_of(x);
    int64_t subnormal = 0;
    if (bits < UINT64_C(0x0010000000000000)) {
        bits = bits_of(x * 0x1p54);
        subnormal = 54;
    }
    uint64_t above = bits - LOG_FIRST;
    uint32_t i = (uint32_t)(above >> 45) % LOG_STEPS;
    uint64_t exponent = above & UINT64_C(0xFFF0000000000000);
    double k = (double)((int64_t)exponent / (INT64_C(1) << 52) - subnormal);
    uint64_t zbits = bits - exponent;
    double z = of_bits(zbits), zh = of_bits(zbits & UINT64_C(0xFFFFFFFF00000000));
    double c = log_table[i].inverse;
    struct sum r = add(zh * c - 1, (z - zh) * c);
    double rh = upper(r.hi);
    struct sum s = add_ordered(k * LN2_HI + log_table[i].log_hi, r.hi);
    struct sum t = add_ordered(s.hi, -0.5 * rh * rh);
    double small = k * LN2_LO + log_table[i].log_lo + r.lo * (1 - r.hi);
    double lo = s.lo + t.lo + small - 0.5 * (r.hi - rh) * (r.hi + rh) + log_rest(r.hi);
    return add_ordered(t.hi, lo);
}

double pen_exp(double x)
{
    return exp_of_sum(x, 0);
}

double pen_ln(double x)
{
    if (!(x > 0))
        return x == 0 ? -(double)INFINITY : (double)NAN;
    return x <= 0x1.fffffffffffffp1023 ? log_sum(x).hi : x;
}

/* x^y where x > 0 is infinite or y is huge, infinite or NaN. */
static double pow_edge(double x, double y)
{
    if (y != y)
        return y;
    if (x == 1 || y == 0)
        return 1;
    return (x > 1) == (y > 0) ? (double)INFINITY : 0;
}

double pen_pow(double x, double y)
{
    if (!(x > 0))
        return x <= 0 ? 0 : x;
    if (!(x <= 0x1.fffffffffffffp1023 && fabs(y) < 0x1p64))
        return pow_edge(x, y);
    struct sum log = log_sum(x);
    double yh = upper(y), lh = upper(log.hi);
    double lo = (y - yh) * lh + y * ((log.hi - lh) + log.lo);
    return exp_of_sum(yh * lh, lo);
}

/* Sine of a reduced angle, |hi| < 0.8: Taylor's series to the 17th power. */
static double sine_of_sum(struct sum a)
{
    double z = a.hi * a.hi;
    double p =
        -1. / 6 +
        z * (1. / 120 + z * (-1. / 5040 +
                             z * (1. / 362880 +
                                  z * (-1. / 39916800 +
                                       z * (1. / 6227020800 + z * (-1. / 1307674368000 +
                                                                   z * (1. / 355687428096000)))))));
    return a.hi + (a.hi * z * p + a.lo * (1 - 0.5 * z));
}

/* Cosine of a reduced angle, to the 18th power; what 1 - z/2 and z itself lose in rounding is
 * added back, since it is not small beside the result. */
static double cosine_of_sum(struct sum a)
{
    double z = a.hi * a.hi, h = upper(a.hi), l = a.hi - h;
    double lost = ((h * h - z) + 2 * h * l) + l * l;
    double q = 1. / 24 +
               z * (-1. / 720 +
                    z * (1. / 40320 +
                         z * (-1. / 3628800 +
                              z * (1. / 479001600 +
                                   z * (-1. / 87178291200 + z * (1. / 20922789888000 +
                                                                 z * (-1. / 6402373705728000)))))));
    struct sum w = add_ordered(1, -0.5 * z);
    return w.hi + (w.lo - 0.5 * lost + (z * z * q - a.hi * a.lo));
}

/* Adds `quarters` quarter turns to an angle, given and returned as its sine and cosine. */
static void turn(int32_t quarters, double *sine, double *cosine)
{
    double s = *sine, c = *cosine;
    double turned_s = quarters & 1 ? c : s, turned_c = quarters & 1 ? s : c;
    *sine = quarters & 2 ? -turned_s : turned_s;
    *cosine = (quarters + 1) & 2 ? -turned_c : turned_c;
}

/* The reduced angle must keep its relative precision even when it is nearly 0. For doubles below
 * 2^20 it is never nearer to 0 than 2^-64, and the four parts of pi/2 reach 2^-150. */
void pen_sincos(double x, double *sine, double *cosine)
{
    if (!(fabs(x) <= 0x1p20)) {
        *sine = *cosine = (double)NAN;
        return;
    }
    double shifted = x * QUARTERS_PER_RADIAN + ROUNDER;
    double k = shifted - ROUNDER;
    struct sum a = add(x - k * HALF_PI_1, -k * HALF_PI_2);
    struct sum b = add(a.hi, -k * HALF_PI_3);
    struct sum reduced = add_ordered(b.hi, a.lo + b.lo - k * HALF_PI_4);
    *sine = sine_of_sum(reduced);
    *cosine = cosine_of_sum(reduced);
    turn(shifted_integer(shifted), sine, cosine);
}

void pen_sincos_deg(double degrees, double *sine, double *cosine)
{
    if (!(fabs(degrees) <= 0x1p20)) {
        *sine = *cosine = (double)NAN;
        return;
    }
    double shifted = degrees * (1. / 90) + ROUNDER;
    double f = degrees - (shifted - ROUNDER) * 90; /* exact */
    double fh = upper(f);
    struct sum a = add_ordered(fh * DEGREE_HI, (f - fh) * DEGREE_HI + f * DEGREE_LO);
    *sine = fabs(f) == 30 ? f / 60 : sine_of_sum(a);
    *cosine = cosine_of_sum(a);
    turn(shifted_integer(shifted), sine, cosine);
}
