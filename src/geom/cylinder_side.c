/* SPDX-License-Identifier: MIT */
/* The round side of infinite cylinders and cylinders: the functions that are not hot. */
#include "geom/internal/cylinder_side.h"

#include "geom/internal/double_double.h"
#include "geom/internal/make.h"

bool pen_cylinder_side_make(struct pen_cylinder_side *s, struct pen_vec3 origin,
                            struct pen_vec3 axis, double r)
{
    if (!is_finite3(origin) || !is_finite3(axis) || pen_largest3(axis) == 0 || !is_length(r))
        return false;
    s->q = origin;
    s->a = pen_scale_to_one(axis);
    s->r = r;
    s->length = pen_length(s->a);
    struct dd3 a = dd_of3(s->a);
    struct dd rr = dd_mul(two_prod(r, r), dd_dot(a, a));
    s->rr = rr.hi;
    s->rr_low = rr.lo;
    return true;
}

void pen_cylinder_side_refine(const struct pen_cylinder_side *s, const struct pen_ray *ray,
                              double t[2])
{
    struct dd3 a = dd_of3(s->a), m = dd_cross(dd_of3(ray->d), a);
    struct dd3 n = dd_cross(dd_sub3(ray->o, s->q), a);
    struct dd minus_rr = {-s->rr, -s->rr_low};
    dd_roots(dd_dot(m, m), dd_dot(m, n), dd_add(dd_dot(n, n), minus_rr), t);
}

double pen_cylinder_side_chord(const struct pen_cylinder_side *s, const struct pen_ray *ray)
{
    struct dd3 a = dd_of3(s->a);
    struct dd3 m = dd_cross(dd_of3(ray->d), a);
    struct dd3 n = dd_cross(dd_sub3(ray->o, s->q), a);
    double mm = dd_dot(m, m).hi;
    return mm == 0 ? 0 : -2 * dd_dot(m, n).hi / mm;
}

bool pen_cylinder_side_contains(const struct pen_cylinder_side *s, struct pen_vec3 p)
{
    struct pen_vec3 n = pen_cylinder_side_across(s, p);
    return pen_dot(n, n) < s->rr;
}

struct pen_vec3 pen_cylinder_side_normal(const struct pen_cylinder_side *s, struct pen_vec3 p)
{
    struct pen_vec3 n = pen_cross(s->a, pen_cylinder_side_across(s, p));
    if (pen_largest3(n) == 0) {
        struct pen_vec3 a = s->a;
        bool x = fabs(a.x) <= fabs(a.y) && fabs(a.x) <= fabs(a.z);
        n = pen_cross(a, x                        ? pen_vec3(1, 0, 0)
                         : fabs(a.y) <= fabs(a.z) ? pen_vec3(0, 1, 0)
                                                  : pen_vec3(0, 0, 1));
    }
    return pen_unit_of(n);
}

struct pen_vec3 pen_cylinder_side_project(const struct pen_cylinder_side *s, struct pen_vec3 p)
{
    double distance = pen_length(pen_cylinder_side_across(s, p)) / s->length;
    return pen_along(p, pen_cylinder_side_normal(s, p), s->r - distance);
}

double pen_cylinder_side_reach(const struct pen_cylinder_side *s, struct pen_vec3 q, double h,
                               struct pen_vec3 n, struct pen_vec3 p)
{
    double along = pen_dot(n, s->a) / s->length;
    double rim = s->r * pen_length(pen_cross(n, s->a)) / s->length;
    if (h == INFINITY)
        along = fabs(along) <= 16 * PEN_U ? 0 : fabs(along);
    return pen_dot(n, pen_sub(q, p)) + rim + (along > 0 ? along * h : 0);
}
