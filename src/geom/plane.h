/* SPDX-License-Identifier: MIT */
/* Infinite planes. Outward is along the normal. */
#ifndef PEN_GEOM_PLANE_H
#define PEN_GEOM_PLANE_H

#include "geom/ray.h"

struct pen_plane {
    struct pen_vec3 q; /* a point of the plane near the origin */
    struct pen_vec3 g; /* the normal as given, times a power of two, so exact */
    struct pen_vec3 n; /* the unit normal */
};

/* Fails: returns false if an argument is not finite or the normal is zero. */
bool pen_plane_make(struct pen_plane *p, struct pen_vec3 point, struct pen_vec3 normal);

/* a.b, compensated if more than three bits cancel. */
static inline double pen_dot_guarded(struct pen_vec3 a, struct pen_vec3 b)
{
    double x = a.x * b.x, y = a.y * b.y, z = a.z * b.z;
    double sum = x + y + z;
    if (fabs(sum) * 8 >= fabs(x) + fabs(y) + fabs(z))
        return sum;
    return pen_dot2(a, b);
}

/* The t at which the ray's line meets the plane; false if it is parallel. */
static inline bool pen_plane_root(const struct pen_plane *p, const struct pen_ray *ray, double *t)
{
    struct pen_vec3 g = pen_permuted(ray, &p->g);
    struct pen_vec3 f = pen_sub(pen_permuted(ray, &p->q), ray->permuted_o), d = ray->permuted_d;
    double gd = pen_ray_tied(ray) ? pen_dot2(g, d) : pen_dot_guarded(g, d);
    *t = (pen_ray_tied(ray) ? pen_dot2(g, f) : pen_dot(g, f)) / gd;
    return gd != 0;
}

static inline struct pen_vec3 pen_plane_project(const struct pen_plane *pl, struct pen_vec3 p)
{
    return pen_along(p, pl->n, pen_dot(pl->n, pen_sub(pl->q, p)));
}

#endif
