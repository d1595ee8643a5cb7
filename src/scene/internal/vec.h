/* SPDX-License-Identifier: MIT */
/* Operations on vectors of a document, which may have any length that a double can hold. */
#ifndef PEN_SCENE_INTERNAL_VEC_H
#define PEN_SCENE_INTERNAL_VEC_H

#include <stdbool.h>

#include "math/scale.h"
#include "math/vec3.h"

/* The largest absolute value of a component. */
static inline double vec_max_abs(struct pen_vec3 a)
{
    return pen_larger(fabs(a.x), pen_larger(fabs(a.y), fabs(a.z)));
}

/* a * 2^-exponent, exact unless it leaves the range of doubles. */
static inline struct pen_vec3 vec_scale2_down(struct pen_vec3 a, int exponent)
{
    return pen_vec3(pen_scale2(a.x, -exponent), pen_scale2(a.y, -exponent),
                    pen_scale2(a.z, -exponent));
}

/* The unit vector along a, which must be finite and not zero. Division, rather than multiplication
 * by the reciprocal, makes the unit vector of (0, 0, x) exactly (0, 0, 1). The vector is first
 * scaled by a power of two. So vectors that differ by a power of two give the same bits, and
 * squares stay in range. */
static inline struct pen_vec3 vec_normalize(struct pen_vec3 a)
{
    int exponent = pen_exponent(vec_max_abs(a));
    a = vec_scale2_down(a, exponent);
    double length = pen_length(a);
    return pen_vec3(a.x / length, a.y / length, a.z / length);
}

static inline bool vec_equal(struct pen_vec3 a, struct pen_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* Whether a colour is above 0 in some channel. */
static inline bool color_is_lit(struct pen_vec3 c)
{
    return c.x > 0 || c.y > 0 || c.z > 0;
}

#endif
