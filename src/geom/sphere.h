/* SPDX-License-Identifier: MIT */
/* Spheres. Outward is away from the centre. */
#ifndef PEN_GEOM_SPHERE_H
#define PEN_GEOM_SPHERE_H

#include "geom/ray.h"
#include "math/box.h"

struct pen_sphere {
    struct pen_vec3 c;
    double r;
    double rr, rr_low; /* r^2 = rr + rr_low exactly */
};

/* Makes a sphere.
 * Fails: returns false if c is not finite or r is outside 2^-400 ... 2^400. */
bool pen_sphere_make(struct pen_sphere *s, struct pen_vec3 c, double r);

/* The intersections by the quadratic equation in double-double; NaN for a miss. Used for origins
 * near the surface and for grazing rays, where the fast method of pen_sphere_roots loses digits. */
void pen_sphere_refine(const struct pen_sphere *s, const struct pen_ray *ray, double t[2]);

/* The two intersections of the ray's line, t[0] < t[1]; false if there are none. A tangent is a
 * miss. The discriminant is taken at the point l of the line nearest the centre. Its error is one
 * unit roundoff of l at any distance: o - c is exact, o - c + tp d rounds once, and its remaining
 * component along d corrects tp.
 * Source: Haines, Guenther, Akenine-Moeller, Ray Tracing Gems, 2019, chapter 7. */
static inline bool pen_sphere_roots(const struct pen_sphere *s, const struct pen_ray *ray,
                                    double t[2])
{
    struct pen_vec3 o = ray->permuted_o, d = ray->permuted_d, c = pen_permuted(ray, &s->c);
    struct pen_vec3 f = pen_sub(o, c), low = pen_difference_error3(o, c, f);
    double tp = -pen_dot(f, d) * ray->inv_dd;
    struct pen_vec3 l = pen_add(pen_along_once(f, d, tp), low);
    double rest = -pen_dot(l, d) * ray->inv_dd;
    double disc = (s->rr - pen_dot(l, l)) + s->rr_low;
    double h = sqrt(disc * ray->inv_dd); /* NaN for a miss */
    t[0] = tp + (rest - h);
    t[1] = tp + (rest + h);
    if (fabs(fabs(tp) - h) < ray->near * h || fabs(disc) < PEN_GRAZING * s->rr)
        pen_sphere_refine(s, ray, t);
    return t[0] < t[1];
}

/* Whether p is on the sphere, up to `bound` and the sphere's own rounding. */
static inline bool pen_sphere_touches(const struct pen_sphere *s, struct pen_vec3 p, double bound)
{
    struct pen_vec3 f = pen_sub(p, s->c);
    return fabs(pen_dot(f, f) - s->rr) <= 2 * s->r * (bound + 8 * PEN_U * s->r);
}

/* Whether a ray that leaves the sphere certainly does not meet it again. May be false for such a
 * ray. */
static inline bool pen_sphere_outward(const struct pen_sphere *s, const struct pen_ray *ray)
{
    struct pen_vec3 f = pen_sub(ray->o, s->c);
    return pen_dot(f, ray->d) > 0x1p-40 * (pen_norm1(f) * pen_norm1(ray->d));
}

static inline struct pen_vec3 pen_sphere_normal(const struct pen_sphere *s, struct pen_vec3 p)
{
    return pen_normalize(pen_sub(p, s->c));
}

static inline struct pen_vec3 pen_sphere_project(const struct pen_sphere *s, struct pen_vec3 p)
{
    return pen_along(s->c, pen_sphere_normal(s, p), s->r);
}

#endif
