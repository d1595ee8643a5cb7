/* SPDX-License-Identifier: MIT */
/* 113-bit arithmetic, for the oracle's own files: gcc's __float128, or long double where that is
 * binary128. Products of two doubles are exact in it. */
#ifndef TESTS_PROPERTY_ORACLE_QUAD_H
#define TESTS_PROPERTY_ORACLE_QUAD_H

#include <float.h>
#include <math.h>

#include "property/oracle.h"

#if LDBL_MANT_DIG == 113
typedef long double quad;
#else
__extension__ typedef __float128 quad;
#endif

#define U ((quad)0x1p-53)

struct quad3 {
    quad x, y, z;
};

static inline struct quad3 q3(struct pen_vec3 v)
{
    return (struct quad3){v.x, v.y, v.z};
}

static inline struct quad3 q_sub(struct quad3 a, struct quad3 b)
{
    return (struct quad3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline struct quad3 q_along(struct quad3 a, struct quad3 d, quad t)
{
    return (struct quad3){a.x + t * d.x, a.y + t * d.y, a.z + t * d.z};
}

static inline quad q_dot(struct quad3 a, struct quad3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct quad3 q_cross(struct quad3 a, struct quad3 b)
{
    return (struct quad3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline quad q_abs(quad x)
{
    return x < 0 ? -x : x;
}

/* Newton's method from the double root; x within the range of doubles. */
static inline quad q_sqrt(quad x)
{
    quad y = (quad)sqrt((double)x);
    for (int i = 0; i < 3 && y > 0; i++)
        y = (y + x / y) / 2;
    return y;
}

static inline quad q_length(struct quad3 a)
{
    return q_sqrt(q_dot(a, a));
}

static inline struct truth q_truth(quad x)
{
    double hi = (double)x;
    return (struct truth){hi, (double)(x - (quad)hi)};
}

#endif
