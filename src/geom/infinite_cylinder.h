/* SPDX-License-Identifier: MIT */
/* Infinite cylinders. Outward is away from the axis. Rays are projected to the plane across the
 * axis, by cross products whose components are exact differences of products. So neither thin
 * cylinders nor rays nearly along the axis lose digits. */
#ifndef PEN_GEOM_INFINITE_CYLINDER_H
#define PEN_GEOM_INFINITE_CYLINDER_H

#include "geom/ray.h"
#include "math/box.h"

/* The round side that infinite cylinders, cylinders and the hulls of cones share. */
struct pen_cylinder_side {
    struct pen_vec3 q; /* a point of the axis */
    struct pen_vec3 a; /* the axis as given, times a power of two: largest component in [1/2, 1) */
    double r;
    double rr, rr_low; /* (r |a|)^2, in two doubles */
    double length;     /* |a| */
};

struct pen_infinite_cylinder {
    struct pen_cylinder_side round; /* q is the given point, exactly */
    struct pen_vec3 near;           /* the point of the axis nearest the origin, rounded */
};

/* Makes an infinite cylinder.
 * Fails: returns false if an argument is not finite, the axis is zero, or r is outside 2^-400 ...
 * 2^400. */
bool pen_infinite_cylinder_make(struct pen_infinite_cylinder *infinite_cylinder,
                                struct pen_vec3 origin, struct pen_vec3 axis, double r);

/* (p - q) x a: the component of p - q across the axis, rotated by a right angle, times |a|. p - q
 * is exact, so the distance from q along the axis does not matter. */
static inline struct pen_vec3 pen_axis_across(struct pen_vec3 p, struct pen_vec3 q,
                                              struct pen_vec3 a)
{
    struct pen_vec3 f = pen_sub(p, q), low = pen_difference_error3(p, q, f);
    struct pen_vec3 rest =
        pen_vec3(low.y * a.z - low.z * a.y, low.z * a.x - low.x * a.z, low.x * a.y - low.y * a.x);
    return pen_add(pen_cross(f, a), rest);
}

static inline struct pen_vec3 pen_cylinder_side_across(const struct pen_cylinder_side *s,
                                                       struct pen_vec3 p)
{
    return pen_axis_across(p, s->q, s->a);
}

/* As pen_sphere_refine, for the side. */
void pen_cylinder_side_refine(const struct pen_cylinder_side *s, const struct pen_ray *ray,
                              double t[2]);

/* The two intersections of the ray's line with the infinite side, t[0] < t[1]; false if there are
 * none. Tangents and lines parallel to the axis are misses; *parallel tells them apart. The method
 * is that of pen_sphere_roots, in the plane across the axis. */
static inline bool pen_cylinder_side_roots(const struct pen_cylinder_side *s,
                                           const struct pen_ray *ray, double t[2], bool *parallel)
{
    struct pen_vec3 q = pen_permuted(ray, &s->q), a = pen_permuted(ray, &s->a);
    struct pen_vec3 m = pen_cross(ray->permuted_d, a);
    struct pen_vec3 n = pen_axis_across(ray->permuted_o, q, a);
    double mm = pen_dot(m, m), inv = 1.0 / mm;
    double tp = -pen_dot(m, n) * inv;
    struct pen_vec3 l = pen_along_once(n, m, tp);
    double rest = -pen_dot(l, m) * inv;
    double disc = (s->rr - pen_dot(l, l)) + s->rr_low;
    double h = sqrt(disc * inv); /* NaN for a miss */
    t[0] = tp + (rest - h);
    t[1] = tp + (rest + h);
    if (fabs(fabs(tp) - h) < ray->near * h || fabs(disc) < PEN_GRAZING * s->rr)
        pen_cylinder_side_refine(s, ray, t);
    *parallel = mm == 0;
    return t[0] < t[1];
}

/* Whether p is on the infinite side, up to `bound`, which includes the primitive's own rounding. */
static inline bool pen_cylinder_side_touches(const struct pen_cylinder_side *s, struct pen_vec3 p,
                                             double bound)
{
    struct pen_vec3 n = pen_cylinder_side_across(s, p);
    return fabs(pen_dot(n, n) - s->rr) <= 2 * s->r * bound * (s->length * s->length);
}

/* The largest distance by which a computed point of the infinite cylinder may miss its surface. */
static inline double
pen_infinite_cylinder_rounding(const struct pen_infinite_cylinder *infinite_cylinder)
{
    return 8 * PEN_U * (infinite_cylinder->round.r + pen_norm1(infinite_cylinder->near));
}

/* The t of the other intersection of a ray whose origin is on the side by identity; 0 if the ray is
 * parallel to the axis. */
double pen_cylinder_side_chord(const struct pen_cylinder_side *s, const struct pen_ray *ray);

/* Whether pen_cylinder_side_chord is certainly not positive: a cheaper test. By Lagrange's identity
 * the chord has the sign of -(d x a).(f x a) = (d.a)(f.a) - (d.f)(a.a); and |a|^2 < 3. */
static inline bool pen_cylinder_side_outward(const struct pen_cylinder_side *s,
                                             const struct pen_ray *ray)
{
    struct pen_vec3 f = pen_sub(ray->o, s->q), d = ray->d, a = s->a;
    double outward = pen_dot(d, f) * pen_dot(a, a) - pen_dot(d, a) * pen_dot(f, a);
    return outward > 0x1p-40 * (pen_norm1(f) * pen_norm1(d));
}

/* Whether p is strictly inside the infinite side. */
bool pen_cylinder_side_contains(const struct pen_cylinder_side *s, struct pen_vec3 p);

/* The unit normal of the side at p. If p is on the axis, which has no normal, some unit vector
 * across the axis. */
struct pen_vec3 pen_cylinder_side_normal(const struct pen_cylinder_side *s, struct pen_vec3 p);

/* The point of the side nearest p. */
struct pen_vec3 pen_cylinder_side_project(const struct pen_cylinder_side *s, struct pen_vec3 p);

#endif
