/* SPDX-License-Identifier: MIT */
/* Vectors of three doubles. Every operation rounds once per written operator, in the written order,
 * on every machine (the build forbids contraction), except where fma is written. */
#ifndef PEN_MATH_VEC3_H
#define PEN_MATH_VEC3_H

#include <math.h>

struct pen_vec3 {
    double x, y, z;
};

static inline struct pen_vec3 pen_vec3(double x, double y, double z)
{
    return (struct pen_vec3){x, y, z};
}

static inline struct pen_vec3 pen_add(struct pen_vec3 a, struct pen_vec3 b)
{
    return pen_vec3(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline struct pen_vec3 pen_sub(struct pen_vec3 a, struct pen_vec3 b)
{
    return pen_vec3(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline struct pen_vec3 pen_scale(struct pen_vec3 a, double s)
{
    return pen_vec3(a.x * s, a.y * s, a.z * s);
}

/* The product, component by component. */
static inline struct pen_vec3 pen_mul(struct pen_vec3 a, struct pen_vec3 b)
{
    return pen_vec3(a.x * b.x, a.y * b.y, a.z * b.z);
}

static inline struct pen_vec3 pen_neg(struct pen_vec3 a)
{
    return pen_vec3(-a.x, -a.y, -a.z);
}

static inline double pen_dot(struct pen_vec3 a, struct pen_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* a + t d */
static inline struct pen_vec3 pen_along(struct pen_vec3 a, struct pen_vec3 d, double t)
{
    return pen_vec3(a.x + t * d.x, a.y + t * d.y, a.z + t * d.z);
}

static inline double pen_length(struct pen_vec3 a)
{
    return sqrt(pen_dot(a, a));
}

/* |x| + |y| + |z|, the norm of rounding bounds. */
static inline double pen_norm1(struct pen_vec3 a)
{
    return fabs(a.x) + fabs(a.y) + fabs(a.z);
}

/* The unit vector along a. a must not be zero, and its squares must neither overflow nor underflow,
 * which holds for everything inside the local frame. */
static inline struct pen_vec3 pen_normalize(struct pen_vec3 a)
{
    double s = 1.0 / pen_length(a);
    return pen_scale(a, s);
}

/* Component by index 0, 1, 2. */
static inline double pen_component(struct pen_vec3 a, int axis)
{
    return axis == 0 ? a.x : axis == 1 ? a.y : a.z;
}

#endif
