/* SPDX-License-Identifier: MIT */
/* What constructors share: tests for usable numbers, unit vectors of vectors of any length, and
 * boxes grown by a primitive's own rounding. */
#ifndef PEN_GEOM_INTERNAL_MAKE_H
#define PEN_GEOM_INTERNAL_MAKE_H

#include <stdbool.h>
#include <stdint.h>

#include "geom/ray.h"
#include "math/box.h"

static inline bool is_finite3(struct pen_vec3 v)
{
    return (v.x - v.x) + (v.y - v.y) + (v.z - v.z) == 0;
}

/* Whether x is finite, and is 0 or at least PEN_LEAST in size. */
static inline bool is_coordinate(double x)
{
    return x - x == 0 && (x == 0 || fabs(x) >= PEN_LEAST);
}

/* Whether v is a vertex. Products of its coordinates across a ray then stay in range. */
static inline bool is_vertex(struct pen_vec3 v)
{
    return is_coordinate(v.x) && is_coordinate(v.y) && is_coordinate(v.z);
}

/* Whether r is a length. Its square then stays in range. */
static inline bool is_length(double r)
{
    return r >= 0x1p-400 && r <= 0x1p400;
}

static inline double pen_largest3(struct pen_vec3 v)
{
    double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
    double m = x > y ? x : y;
    return m > z ? m : z;
}

/* v times the power of two that brings its largest component into [1/2, 1). v is finite and not
 * zero. Exact, except that components below 2^-1074 become 0. */
struct pen_vec3 pen_scale_to_one(struct pen_vec3 v);

/* The unit vector along v, which is finite and not zero. Each component is within 2 ulp. */
struct pen_vec3 pen_unit_of(struct pen_vec3 v);

/* A unit vector across the line on which points are; zero if they are one point, or too far apart.
 */
struct pen_vec3 pen_across_points(const struct pen_vec3 *v, uint32_t count);

/* The bounds of points. */
struct pen_box pen_box_of_points(const struct pen_vec3 *v, uint32_t count);

/* The box, grown on all sides by 32u of its own coordinates and of `size`. */
struct pen_box pen_box_grow(struct pen_box b, double size);

#endif
