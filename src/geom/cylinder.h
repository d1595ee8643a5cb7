/* SPDX-License-Identifier: MIT */
/* Cylinders with two ends, capped or open. A capped cylinder is convex: the part of a ray inside is
 * the overlap of two t-intervals, of the infinite side and of the slab between the caps. So entry
 * and exit always pair up. Outward is away from the axis on the side and along the axis on the
 * caps.
 *
 * An open cylinder extends beyond its ends by `rim`, a few roundings. A neighbour that ends at the
 * rim has coordinates of its own; without `rim` the rounding of both would leave a crack. A capped
 * cylinder is extended only for lines that run along a cap, and only at the end that owns such
 * lines (pen_cylinder_holds). */
#ifndef PEN_GEOM_CYLINDER_H
#define PEN_GEOM_CYLINDER_H

#include "geom/infinite_cylinder.h"
#include "geom/plane.h"

struct pen_cylinder {
    struct pen_cylinder_side round; /* q is the middle of the base */
    double top;                     /* height times |a|: the caps are at (p - q).a = 0 and = top */
    double slab_base, slab_top, slab_top_low; /* the same with the rim; the side is between them */
    double h;                                 /* height */
    double rim;                               /* 0 with caps */
    double joint;   /* with caps: the extension for lines along a cap, times |a|; else 0 */
    double edge_on; /* a line is parallel to the caps if |d.a| <= edge_on times d's largest
                       component */
    bool caps;
};

/* Makes a cylinder.
 * Fails: returns false if an argument is not finite, the axis is zero, or r or h is outside 2^-400
 * ... 2^400. */
bool pen_cylinder_make(struct pen_cylinder *c, struct pen_vec3 base, struct pen_vec3 axis, double r,
                       double h, bool caps);

/* Sets how far the ends are extended: by the rounding of the cylinder's own numbers and of its
 * neighbours'. That is 8u of |base|_1 + r + h, and 8u of the coordinates before they were moved to
 * the local frame; `rounding` is 1u of these coordinates. */
void pen_cylinder_set_rim(struct pen_cylinder *c, double rounding);

/* A t-interval of the ray's line inside a primitive, and the part of the surface at each end. */
struct pen_interval {
    double lo, hi;
    uint8_t lo_part, hi_part;
};

/* d.a: 0 if the ray is parallel to the caps, > 0 if it goes from the base towards the top. */
static inline double pen_cylinder_along(const struct pen_cylinder *c, const struct pen_ray *ray)
{
    return pen_dot_guarded(ray->permuted_d, pen_permuted(ray, &c->round.a));
}

/* The largest distance by which the cylinder is extended beyond its ends, for any line. */
static inline double pen_cylinder_reaches_out(const struct pen_cylinder *c)
{
    return c->rim + c->joint / c->round.length;
}

/* Upper limit of `edge_on`: a line with a larger |d.a| / d's largest component is never parallel to
 * the caps. It covers a few roundings of d and a. */
#define PEN_EDGE_ON (32 * PEN_U)

/* Whether the ray's line is parallel to the caps within the rounding of its direction. da is
 * pen_cylinder_along. */
static inline bool pen_cylinder_edge_on(const struct pen_cylinder *c, const struct pen_ray *ray,
                                        double da)
{
    return fabs(da) <= c->edge_on * fabs(ray->permuted_d.z);
}

/* Whether a line that is parallel to the caps passes between them. For a line in a cap's plane the
 * half-open rule of flat primitives (geom/triangle.h) decides. The line is judged as if it were
 * moved by an infinitesimal to the right, as seen in ray space, or up where the cap's edge is
 * level. So of two cylinders with a common cap, exactly one owns the lines in its plane. The end
 * that owns them is extended by `joint`, so that no line passes between caps that rounding has
 * separated. */
bool pen_cylinder_holds(const struct pen_cylinder *c, const struct pen_ray *ray);

/* The t-interval inside the slab between the caps; false if the ray is parallel to them and
 * outside. */
static inline bool pen_cylinder_slab(const struct pen_cylinder *c, const struct pen_ray *ray,
                                     struct pen_interval *in)
{
    struct pen_vec3 f = pen_sub(ray->permuted_o, pen_permuted(ray, &c->round.q));
    double da = pen_cylinder_along(c, ray), fa = pen_dot(f, pen_permuted(ray, &c->round.a));
    if (pen_cylinder_edge_on(c, ray, da)) {
        *in = (struct pen_interval){-INFINITY, INFINITY, PEN_PART_BASE, PEN_PART_TOP};
        return pen_cylinder_holds(c, ray);
    }
    double inv = 1.0 / da, base = (c->slab_base - fa) * inv, top = (c->slab_top - fa) * inv;
    if (da > 0)
        *in = (struct pen_interval){base, top, PEN_PART_BASE, PEN_PART_TOP};
    else
        *in = (struct pen_interval){top, base, PEN_PART_TOP, PEN_PART_BASE};
    return true;
}

/* Clips the slab's t-interval to that of the side: the later entry and the earlier exit remain.
 * Where they are equal, the cap wins. Returns false if nothing is left. */
static inline bool pen_interval_clip(struct pen_interval *in, const double side[2])
{
    if (side[0] > in->lo) {
        in->lo = side[0];
        in->lo_part = PEN_PART_SIDE;
    }
    if (side[1] < in->hi) {
        in->hi = side[1];
        in->hi_part = PEN_PART_SIDE;
    }
    return in->lo < in->hi;
}

/* Whether pen_cylinder_slab must be refined: the ray is tied, starts near a cap's plane or is
 * nearly parallel to it. In the last two cases the slab loses more than two bits. */
static inline bool pen_cylinder_slab_loses(const struct pen_cylinder *c, const struct pen_ray *ray)
{
    struct pen_vec3 q = pen_permuted(ray, &c->round.q), a = pen_permuted(ray, &c->round.a);
    struct pen_vec3 f = pen_sub(ray->permuted_o, q), d = ray->permuted_d;
    double da = pen_dot(d, a), fa = pen_dot(f, a), rest = fabs(c->slab_top - fa);
    double size = fabs(f.x * a.x) + fabs(f.y * a.y) + fabs(f.z * a.z);
    double least = rest < fabs(fa) ? rest : fabs(fa);
    return pen_ray_tied(ray) || 4 * least < size || 4 * rest < c->slab_top ||
           4 * fabs(da) < fabs(d.x * a.x) + fabs(d.y * a.y) + fabs(d.z * a.z);
}

/* Replaces the interval by that of the slab in double-double. Does nothing if the ray is parallel
 * to the caps. */
void pen_cylinder_slab_refine(const struct pen_cylinder *c, const struct pen_ray *ray,
                              struct pen_interval *in);

/* As pen_cylinder_slab, for a ray whose origin lies on the parts `on`: an end at the origin gets t
 * = 0 exactly. Also returns false if the ray runs along a cap that it starts on. */
bool pen_cylinder_slab_from(const struct pen_cylinder *c, const struct pen_ray *ray, unsigned on,
                            struct pen_interval *in);

/* Finds the first t > 0 among the ends of the side's interval at which the ray is within `bound` of
 * the height of an open end. Returns false if there is none, or if the cylinder has caps. */
static inline bool pen_cylinder_passes_rim(const struct pen_cylinder *c, const struct pen_ray *ray,
                                           const double side[2], double bound, double *t)
{
    double da = pen_cylinder_along(c, ray), b = (bound + c->rim) * c->round.length;
    double fa = pen_dot2(pen_sub(ray->o, c->round.q), c->round.a);
    for (int i = 0; i < 2 && !c->caps; i++) {
        double along = fa + side[i] * da;
        *t = side[i];
        if (*t > 0 && (fabs(along) <= b || fabs(along - c->top) <= b))
            return true;
    }
    return false;
}

/* The t-interval of the ray's line inside the cylinder; false if there is none. Ends at the caps of
 * an open cylinder are no intersections; the caller drops them. */
static inline bool pen_cylinder_interval(const struct pen_cylinder *c, const struct pen_ray *ray,
                                         struct pen_interval *in)
{
    double side[2];
    bool parallel;
    if (!pen_cylinder_slab(c, ray, in))
        return false;
    if (!pen_cylinder_side_roots(&c->round, ray, side, &parallel)) {
        if (!parallel || !pen_cylinder_side_contains(&c->round, ray->o))
            return false;
        side[0] = -INFINITY;
        side[1] = INFINITY;
    }
    if (!pen_interval_clip(in, side))
        return false;
    if (!pen_cylinder_slab_loses(c, ray))
        return true;
    pen_cylinder_slab_refine(c, ray, in);
    return pen_interval_clip(in, side);
}

/* The parts that p lies on, up to `bound` and the primitive's own rounding. An open end, at the
 * rim, counts as a part only for points of the side, because an open end has no surface. */
static inline unsigned pen_cylinder_touches(const struct pen_cylinder *c, struct pen_vec3 p,
                                            double bound)
{
    double b = bound + 8 * PEN_U * (c->round.r + c->h), length = c->round.length;
    double fa = pen_dot(pen_sub(p, c->round.q), c->round.a);
    struct pen_vec3 n = pen_cylinder_side_across(&c->round, p);
    double off = pen_dot(n, n) - c->round.rr, side = 2 * c->round.r * b * (length * length);
    double above_base = fa - c->slab_base, below_top = c->slab_top - fa;
    if (!(-b * length <= above_base && -b * length <= below_top && off <= side))
        return 0;
    unsigned on = fabs(off) <= side ? PEN_ON_SIDE : 0;
    if (on == 0 && !c->caps)
        return 0;
    if (above_base <= b * length)
        on |= PEN_ON_BASE;
    if (below_top <= b * length)
        on |= PEN_ON_TOP;
    return on;
}

struct pen_vec3 pen_cylinder_normal(const struct pen_cylinder *c, uint8_t part, struct pen_vec3 p);

/* The point nearest p on the part's surface, continued without end. */
struct pen_vec3 pen_cylinder_project(const struct pen_cylinder *c, uint8_t part, struct pen_vec3 p);

#endif
