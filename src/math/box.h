/* SPDX-License-Identifier: MIT */
/* Axis-aligned boxes in double precision. */
#ifndef PEN_MATH_BOX_H
#define PEN_MATH_BOX_H

#include "math/vec3.h"

struct pen_box {
    struct pen_vec3 lo, hi;
};

/* The empty box: lo = +inf, hi = -inf. */
static inline struct pen_box pen_box_empty(void)
{
    return (struct pen_box){pen_vec3(INFINITY, INFINITY, INFINITY),
                            pen_vec3(-INFINITY, -INFINITY, -INFINITY)};
}

static inline struct pen_box pen_box_add_point(struct pen_box b, struct pen_vec3 p)
{
    b.lo = pen_vec3(p.x < b.lo.x ? p.x : b.lo.x, p.y < b.lo.y ? p.y : b.lo.y,
                    p.z < b.lo.z ? p.z : b.lo.z);
    b.hi = pen_vec3(p.x > b.hi.x ? p.x : b.hi.x, p.y > b.hi.y ? p.y : b.hi.y,
                    p.z > b.hi.z ? p.z : b.hi.z);
    return b;
}

/* The smallest box around both; either may be empty. */
static inline struct pen_box pen_box_union(struct pen_box a, struct pen_box b)
{
    return (struct pen_box){
        pen_vec3(a.lo.x < b.lo.x ? a.lo.x : b.lo.x, a.lo.y < b.lo.y ? a.lo.y : b.lo.y,
                 a.lo.z < b.lo.z ? a.lo.z : b.lo.z),
        pen_vec3(a.hi.x > b.hi.x ? a.hi.x : b.hi.x, a.hi.y > b.hi.y ? a.hi.y : b.hi.y,
                 a.hi.z > b.hi.z ? a.hi.z : b.hi.z)};
}

static inline struct pen_vec3 pen_box_center(struct pen_box b)
{
    return pen_vec3(0.5 * b.lo.x + 0.5 * b.hi.x, 0.5 * b.lo.y + 0.5 * b.hi.y,
                    0.5 * b.lo.z + 0.5 * b.hi.z);
}

/* Half the surface area; 0 for the empty box. */
static inline double pen_box_half_area(struct pen_box b)
{
    double dx = b.hi.x - b.lo.x, dy = b.hi.y - b.lo.y, dz = b.hi.z - b.lo.z;
    if (!(dx >= 0 && dy >= 0 && dz >= 0))
        return 0;
    return dx * dy + dy * dz + dz * dx;
}

#endif
