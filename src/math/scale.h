/* SPDX-License-Identifier: MIT */
/* Powers of two: exact scaling and exponents without the system's math library. */
#ifndef PEN_MATH_SCALE_H
#define PEN_MATH_SCALE_H

#include <stdint.h>
#include <string.h>

/* The exponent e with |x| = m 2^e, 1/2 <= m < 1; 0 for zero, infinities and NaN. */
static inline int pen_exponent(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    int biased = (int)(bits >> 52 & 0x7ff), shift = 0;
    if (biased == 0 && x != 0) {
        double scaled = x * 0x1p64;
        memcpy(&bits, &scaled, sizeof bits);
        biased = (int)(bits >> 52 & 0x7ff);
        shift = 64;
    }
    return biased == 0 || biased == 0x7ff ? 0 : biased - 1022 - shift;
}

/* x 2^e. It is exact, except for overflow to infinity and for one rounding if the result is
 * subnormal. */
static inline double pen_scale2(double x, int e)
{
    for (int i = 0; i < 3 && e > 1023; i++, e -= 1023)
        x *= 0x1p1023;
    /* Steps down stay 53 bits above the subnormal range, so only the last one rounds. */
    for (int i = 0; i < 3 && e < -1022; i++, e += 969)
        x *= 0x1p-969;
    e = e > 1023 ? 1023 : e < -1022 ? -1022 : e;
    uint64_t bits = (uint64_t)(e + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return x * power;
}

/* The larger of two numbers; neither is NaN. */
static inline double pen_larger(double a, double b)
{
    return a > b ? a : b;
}

#endif
