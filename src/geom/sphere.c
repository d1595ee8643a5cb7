/* SPDX-License-Identifier: MIT */
/* Spheres: what is not hot. */
#include "geom/sphere.h"

#include "geom/internal/double_double.h"
#include "geom/internal/make.h"

bool pen_sphere_make(struct pen_sphere *s, struct pen_vec3 c, double r)
{
    if (!is_finite3(c) || !is_length(r))
        return false;
    struct twofold rr = two_prod(r, r);
    *s = (struct pen_sphere){c, r, rr.hi, rr.lo};
    return true;
}

void pen_sphere_refine(const struct pen_sphere *s, const struct pen_ray *ray, double t[2])
{
    struct twofold3 f = tf_sub3(ray->o, s->c), d = tf_of3(ray->d);
    struct twofold minus_rr = {-s->rr, -s->rr_low};
    tf_roots(tf_dot(d, d), tf_dot(f, d), tf_add(tf_dot(f, f), minus_rr), t);
}

double pen_sphere_chord(const struct pen_sphere *s, const struct pen_ray *ray)
{
    struct twofold b = tf_dot(tf_sub3(ray->o, s->c), tf_of3(ray->d));
    return -2 * b.hi / pen_dot(ray->d, ray->d);
}

struct pen_box pen_sphere_bounds(const struct pen_sphere *s)
{
    struct pen_vec3 r = pen_vec3(s->r, s->r, s->r);
    return pen_box_grow((struct pen_box){pen_sub(s->c, r), pen_add(s->c, r)}, s->r);
}
