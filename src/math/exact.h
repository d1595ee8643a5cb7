/* SPDX-License-Identifier: MIT */
/* Differences of products with an exact sign, and functions built on them.
 * Source: Jeannerod, Louvet, Muller, "Further analysis of Kahan's algorithm for the accurate
 * computation of 2x2 determinants", Math. Comp. 82, 2013. */
#ifndef PEN_MATH_EXACT_H
#define PEN_MATH_EXACT_H

#include "math/vec3.h"

/* a b - c d with relative error <= 2u, unless it over- or underflows. Its sign is exact, and it is
 * 0 only if the true value is 0. */
static inline double pen_dop(double a, double b, double c, double d)
{
    double w = c * d;
    double e = fma(-c, d, w);
    double f = fma(a, b, -w);
    return f + e;
}

/* a b + c d, as pen_dop. */
static inline double pen_sop(double a, double b, double c, double d)
{
    return pen_dop(a, b, -c, d);
}

/* The cross product; each component has a relative error <= 2u. */
static inline struct pen_vec3 pen_cross(struct pen_vec3 a, struct pen_vec3 b)
{
    return pen_vec3(pen_dop(a.y, b.z, a.z, b.y), pen_dop(a.z, b.x, a.x, b.z),
                    pen_dop(a.x, b.y, a.y, b.x));
}

/* c + a.b + rest, as if summed in double-double. The error is some u of the result plus 2^-102 of
 * |c| + |a|.|b|, if `rest` is within 2^-50 of these.
 * Source: Ogita, Rump, Oishi, "Accurate sum and dot product", SIAM J. Sci. Comput. 26, 2005. */
static inline double pen_dot2_plus(double c, struct pen_vec3 a, struct pen_vec3 b, double rest)
{
    const double left[3] = {a.x, a.y, a.z}, right[3] = {b.x, b.y, b.z};
    double sum = c, low = 0;
#pragma GCC unroll 3
    for (int i = 0; i < 3; i++) {
        double product = left[i] * right[i];
        double next = sum + product;
        double part = next - sum;
        double lost = (sum - (next - part)) + (product - part); /* Knuth's exact sum */
        low += lost + fma(left[i], right[i], -product);
        sum = next;
    }
    return sum + (low + rest);
}

/* The dot product, compensated: as if computed in double-double and rounded once. */
static inline double pen_dot2(struct pen_vec3 a, struct pen_vec3 b)
{
    double sum = a.x * b.x, low = fma(a.x, b.x, -sum);
    const double left[2] = {a.y, a.z}, right[2] = {b.y, b.z};
    for (int i = 0; i < 2; i++) {
        double product = left[i] * right[i];
        double next = sum + product;
        double part = next - sum;
        double lost = (sum - (next - part)) + (product - part);
        low += lost + fma(left[i], right[i], -product);
        sum = next;
    }
    return sum + low;
}

#endif
