/* SPDX-License-Identifier: MIT */
/* Conversion from binary64 to binary32 in a chosen direction. */
#ifndef PEN_ACCEL_INTERNAL_ROUNDING_H
#define PEN_ACCEL_INTERNAL_ROUNDING_H

#include <float.h>
#include <stdint.h>
#include <string.h>

/* The next float towards +inf (step = 1) or -inf (step = -1); f is not NaN. */
static inline float pen_float_next(float f, int32_t step)
{
    int32_t bits;
    memcpy(&bits, &f, sizeof bits);
    if (f == 0)
        bits = step > 0 ? 1 : INT32_MIN + 1;
    else
        bits += bits < 0 ? -step : step;
    memcpy(&f, &bits, sizeof f);
    return f;
}

/* The nearest float, limited to finite ones. A cast that overflows is undefined in C without Annex
 * F. */
static inline float pen_float_near(double x)
{
    return (float)(x > (double)FLT_MAX    ? (double)FLT_MAX
                   : x < -(double)FLT_MAX ? -(double)FLT_MAX
                                          : x);
}

/* The smallest float >= x. */
static inline float pen_float_up(double x)
{
    float f = pen_float_near(x);
    return (double)f < x ? pen_float_next(f, 1) : f;
}

/* The largest float <= x. */
static inline float pen_float_down(double x)
{
    float f = pen_float_near(x);
    return (double)f > x ? pen_float_next(f, -1) : f;
}

#endif
