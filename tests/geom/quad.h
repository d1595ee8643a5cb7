/* SPDX-License-Identifier: MIT */
/* The geometry in __float128 (113 bits), where products of two inputs are exact. The tests of this
 * module compare results with it. */
#ifndef TESTS_GEOM_QUAD_H
#define TESTS_GEOM_QUAD_H

#include <float.h>

#include "math/vec3.h"

__extension__ typedef __float128 quad;

struct quad3 {
    quad x, y, z;
};

static inline struct quad3 quad3(struct pen_vec3 v)
{
    return (struct quad3){v.x, v.y, v.z};
}

static inline struct quad3 quad_sub(struct quad3 a, struct quad3 b)
{
    return (struct quad3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline quad quad_dot(struct quad3 a, struct quad3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct quad3 quad_cross(struct quad3 a, struct quad3 b)
{
    return (struct quad3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* Newton's method from the double root. */
static inline quad quad_sqrt(quad x)
{
    quad y = sqrt((double)x);
    for (int i = 0; i < 3 && y > 0; i++)
        y = (y + x / y) / 2;
    return y;
}

static inline quad quad_abs(quad x)
{
    return x < 0 ? -x : x;
}

/* Finds the roots of a t^2 + 2 b t + c. Returns the discriminant, and sets t[] if it is
 * positive. */
static inline quad quad_roots(quad a, quad b, quad c, quad t[2])
{
    quad disc = b * b - a * c;
    if (disc <= 0)
        return disc;
    quad h = quad_sqrt(disc), q = b < 0 ? h - b : -h - b;
    t[0] = b < 0 ? c / q : q / a;
    t[1] = b < 0 ? q / a : c / q;
    return disc;
}

/* Returns the distance of t from the true value, in units in the last place of the true value. */
static inline double quad_ulps(double t, quad truth)
{
    double size = fabs((double)truth);
    return (double)quad_abs(t - truth) / (nextafter(size, INFINITY) - size);
}

/* Finds a sphere's intersections. */
static inline quad quad_sphere(struct pen_vec3 c, double r, struct pen_vec3 o, struct pen_vec3 d,
                               quad t[2])
{
    struct quad3 f = quad_sub(quad3(o), quad3(c)), dd = quad3(d);
    return quad_roots(quad_dot(dd, dd), quad_dot(f, dd), quad_dot(f, f) - (quad)r * r, t);
}

/* Finds an infinite cylinder's intersections. Its axis goes through q along a; a has any length. */
static inline quad quad_tube(struct pen_vec3 q, struct pen_vec3 a, double r, struct pen_vec3 o,
                             struct pen_vec3 d, quad t[2])
{
    struct quad3 m = quad_cross(quad3(d), quad3(a));
    struct quad3 n = quad_cross(quad_sub(quad3(o), quad3(q)), quad3(a));
    quad rr = (quad)r * r * quad_dot(quad3(a), quad3(a));
    return quad_roots(quad_dot(m, m), quad_dot(m, n), quad_dot(n, n) - rr, t);
}

/* Finds where a line meets the plane of three points. *inside is +1 strictly inside the triangle,
 * -1 strictly outside, 0 too near the border to be sure. */
static inline quad quad_triangle(const struct pen_vec3 v[3], struct pen_vec3 o, struct pen_vec3 d,
                                 int *inside)
{
    struct quad3 p[3], n;
    quad side[3];
    for (int i = 0; i < 3; i++)
        p[i] = quad_sub(quad3(v[i]), quad3(o));
    n = quad_cross(quad_sub(p[1], p[0]), quad_sub(p[2], p[0]));
    quad sum = 0;
    for (int i = 0; i < 3; i++) {
        side[i] = quad_dot(quad3(d), quad_cross(p[i], p[(i + 1) % 3]));
        sum += side[i];
    }
    *inside = 1;
    for (int i = 0; i < 3; i++) {
        quad share = side[i] / sum;
        if (share < (quad)1e-9)
            *inside = share > (quad)-1e-9 && *inside >= 0 ? 0 : -1;
    }
    return quad_dot(n, p[0]) / quad_dot(n, quad3(d));
}

#endif
