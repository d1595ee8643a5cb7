/* SPDX-License-Identifier: MIT */
/* Planes: how they are made. */
#include "geom/plane.h"

#include "geom/internal/double_double.h"
#include "geom/internal/make.h"
#include "geom/triangle.h"

bool pen_plane_make(struct pen_plane *p, struct pen_vec3 point, struct pen_vec3 normal)
{
    if (!is_finite3(point) || !is_finite3(normal) || pen_largest3(normal) == 0)
        return false;
    p->g = pen_scale_to_one(normal);
    p->n = pen_unit_of(normal);
    /* The point nearest the origin, unless the given one, which is exact, is about as near. */
    struct twofold3 g = tf_of3(p->g);
    double s = tf_dot(g, tf_of3(point)).hi / tf_dot(g, g).hi;
    struct pen_vec3 foot = pen_scale(p->g, s);
    p->q = pen_norm1(point) <= 4 * pen_norm1(foot) ? point : foot;
    return is_finite3(p->q);
}

bool pen_plane_through(struct pen_plane *p, struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 c)
{
    struct pen_triangle tri;
    return pen_triangle_make(&tri, a, b, c) && pen_plane_make(p, a, tri.n);
}
