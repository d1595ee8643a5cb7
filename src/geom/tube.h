/* SPDX-License-Identifier: MIT */
/* Infinite tubes: cylinders without ends. Outward is away from the axis. Everything happens in
 * the plane across the axis, reached by cross products with differences of products, so neither
 * thin tubes nor rays nearly along the axis lose digits. */
#ifndef PEN_GEOM_TUBE_H
#define PEN_GEOM_TUBE_H

#include "geom/ray.h"
#include "math/box.h"

/* The round side that tubes and capped cylinders share. */
struct pen_round {
    struct pen_vec3 q; /* a point of the axis */
    struct pen_vec3
        a; /* along the axis: as given, times a power of two, largest part in [1/2, 1) */
    double r;
    double rr, rr_low; /* (r |a|)^2, to twice the precision */
    double length;     /* |a| */
};

struct pen_tube {
    struct pen_round round; /* q is the point given, which is exact */
    struct pen_vec3 near;   /* the point of the axis nearest the origin, rounded */
};

/* Fails: returns false if an argument is not finite, the axis is zero, or r is not in
 * 2^-400 ... 2^400. */
bool pen_tube_make(struct pen_tube *tube, struct pen_vec3 origin, struct pen_vec3 axis, double r);

/* (p - q) x a: across the axis, turned by a right angle, times |a|. p - q is taken exactly, so
 * the distance from q along the axis does not matter. */
static inline struct pen_vec3 pen_axis_across(struct pen_vec3 p, struct pen_vec3 q,
                                              struct pen_vec3 a)
{
    struct pen_vec3 f = pen_sub(p, q), low = pen_lost3(p, q, f);
    struct pen_vec3 rest =
        pen_vec3(low.y * a.z - low.z * a.y, low.z * a.x - low.x * a.z, low.x * a.y - low.y * a.x);
    return pen_add(pen_cross(f, a), rest);
}

static inline struct pen_vec3 pen_round_across(const struct pen_round *s, struct pen_vec3 p)
{
    return pen_axis_across(p, s->q, s->a);
}

/* As pen_sphere_refine. */
void pen_round_refine(const struct pen_round *s, const struct pen_ray *ray, double t[2]);

/* The two crossings of the ray's line with the endless side, t[0] < t[1]; false if there are
 * none. Tangents and parallels are misses; *parallel tells them apart. As for spheres, in the
 * plane across the axis. */
static inline bool pen_round_roots(const struct pen_round *s, const struct pen_ray *ray,
                                   double t[2], bool *parallel)
{
    struct pen_vec3 q = pen_turned(ray, &s->q), a = pen_turned(ray, &s->a);
    struct pen_vec3 m = pen_cross(ray->turned_d, a);
    struct pen_vec3 n = pen_axis_across(ray->turned_o, q, a);
    double mm = pen_dot(m, m), inv = 1.0 / mm;
    double tp = -pen_dot(m, n) * inv;
    struct pen_vec3 l = pen_along_once(n, m, tp);
    double rest = -pen_dot(l, m) * inv;
    double disc = (s->rr - pen_dot(l, l)) + s->rr_low;
    double h = sqrt(disc * inv); /* NaN for a miss */
    t[0] = tp + (rest - h);
    t[1] = tp + (rest + h);
    if (fabs(fabs(tp) - h) < PEN_NEAR * h || fabs(disc) < PEN_GRAZING * s->rr)
        pen_round_refine(s, ray, t);
    *parallel = mm == 0;
    return t[0] < t[1];
}

/* Whether p is on the endless side, up to `bound` (which includes the body's own rounding). */
static inline bool pen_round_touches(const struct pen_round *s, struct pen_vec3 p, double bound)
{
    struct pen_vec3 n = pen_round_across(s, p);
    return fabs(pen_dot(n, n) - s->rr) <= 2 * s->r * bound * (s->length * s->length);
}

/* The tube's own rounding. */
static inline double pen_tube_rounding(const struct pen_tube *tube)
{
    return 8 * PEN_U * (tube->round.r + pen_norm1(tube->near));
}

/* The other crossing of a ray whose origin is on the side by identity; 0 if parallel. */
double pen_round_chord(const struct pen_round *s, const struct pen_ray *ray);

/* Whether pen_round_chord is certainly not positive, for less than it costs. Its sign is that of
 * -(d x a).(f x a) = (d.a)(f.a) - (d.f)(a.a), by Lagrange, and |a|^2 < 3. */
static inline bool pen_round_outward(const struct pen_round *s, const struct pen_ray *ray)
{
    struct pen_vec3 f = pen_sub(ray->o, s->q), d = ray->d, a = s->a;
    double outward = pen_dot(d, f) * pen_dot(a, a) - pen_dot(d, a) * pen_dot(f, a);
    return outward > 0x1p-40 * (pen_norm1(f) * pen_norm1(d));
}

/* Whether p is inside the endless side, off its surface. */
bool pen_round_holds(const struct pen_round *s, struct pen_vec3 p);

/* Unit normal of the side at p. On the axis, where there is none, some unit vector across it. */
struct pen_vec3 pen_round_normal(const struct pen_round *s, struct pen_vec3 p);

/* The point of the side nearest p. */
struct pen_vec3 pen_round_project(const struct pen_round *s, struct pen_vec3 p);

#endif
