/* SPDX-License-Identifier: MIT */
/* Rays, intersections, and the origin surface of a ray: the terms of every primitive's file.
 *
 * An intersection is a point where a ray passes through a surface. The intersections of one ray are
 * ordered by (t, primitive number, part): at equal t the primitive that comes first in the document
 * comes first. t is a pure function of (ray, origin surface, primitive), so no tree, thread or SIMD
 * width can change which intersection is nearest.
 *
 * What a ray meets near its origin is decided by identity and geometry, never by an epsilon in
 * scene units: the self-intersection rule, src/geom/README.md. */
#ifndef PEN_GEOM_RAY_H
#define PEN_GEOM_RAY_H

#include <stdbool.h>
#include <stdint.h>

#include "math/exact.h"
#include "math/vec3.h"

#define PEN_NO_PRIM UINT32_MAX

/* 2^-53, the unit roundoff of binary64. */
#define PEN_U 0x1p-53

/* Coordinates of vertices and of rays' origins are 0 or at least PEN_LEAST, components of d are 0
 * or at least PEN_LEAST_DIRECTION of its largest. So coordinates across a ray are multiples of
 * 2^-535: no part of a product of two of them vanishes, and differences of products have their
 * sign. */
#define PEN_LEAST 0x1p-300
#define PEN_LEAST_DIRECTION 0x1p-130

/* The t of an intersection at the ray's origin that counts: positive, and before all others. */
#define PEN_FIRST_T 0x1p-1074

/* Layers of the surface that a ray starts on, which coincide with it, are met at multiples of
 * PEN_FIRST_T that tell their order. None is as large as this; all other intersections are larger.
 */
#define PEN_LAST_LAYER_T 0x1p-1044

/* An intersection with a quadric at tp - h is refined where it is nearer the origin than this share
 * of the half chord h: the subtraction would lose more than three bits. Of tied rays all are. */
#define PEN_NEAR 0.125

/* Both intersections are refined where the ray grazes a quadric, so that the discriminant is less
 * than this share of the squared radius: it keeps too few digits. */
#define PEN_GRAZING 0x1p-5

/* Where a ray passes the border of a flat primitive within rounding, no farther from its origin
 * than this many rounding bounds, the self-intersection rule decides whether it meets the
 * primitive. Farther away that would matter only to light that arrives at less than 2^-23 to the
 * surface, which brings it no more than that share of its strength. */
#define PEN_NEARBY 0x1p23

/* A direction q from a point p of a surface grazes the surface where |n.q| is at most this share of
 * |q|: no shadow ray is as low as that. It is chosen so that whatever might let such a ray out of a
 * closed room is near enough for the self-intersection rule. Say that p is off its surface by b,
 * and the border of the next wall off its place by c. A ray of sine s has risen by s x at distance
 * x, so it can pass on the wrong side of that border only where s x <= b + c, hence x <= (b + c) /
 * s. That is nearby if s >= 1 / PEN_NEARBY; the factor 2 covers the rounding of s itself. */
#define PEN_HORIZON_SINE (2 / PEN_NEARBY)

enum pen_part {
    PEN_PART_SIDE =
        0, /* the only part of sphere, infinite cylinder and flat kinds; the side of the others */
    PEN_PART_BASE = 1, /* the cap of a cylinder or cone at `base` */
    PEN_PART_TOP = 2   /* the other cap */
};

/* Sets of parts. */
enum {
    PEN_ON_SIDE = 1 << PEN_PART_SIDE,
    PEN_ON_BASE = 1 << PEN_PART_BASE,
    PEN_ON_TOP = 1 << PEN_PART_TOP
};

/* A ray, with the values that primitive tests need once per ray: the shear that maps it to the z
 * axis (Woop, Benthin, Wald, JCGT 2(1), 2013, section 3.2) and 1/d.d. d has any length; t is in
 * units of d. */
struct pen_ray {
    struct pen_vec3 o, d;
    double inv_dd;                          /* 1 / d.d */
    double sx, sy, sz;                      /* shear: d[kx]/d[kz], d[ky]/d[kz], 1/d[kz] */
    struct pen_vec3 permuted_o, permuted_d; /* pen_permuted of o and d */
    double near;                            /* PEN_NEAR; INFINITY if tied */
    int kx, ky, kz; /* axes permuted cyclically, so that kz is d's largest component */
};

/* Whether d's components are equal in size, so that no order of the axes is the ray's own. */
static inline bool pen_ray_tied(const struct pen_ray *ray)
{
    return ray->near > PEN_NEAR;
}

/* v with its axes in the ray's order. All sums over axes that decide t are taken of such vectors,
 * so that t has the same bits in a scene whose axes are permuted cyclically. A tied ray has no
 * order of its own: its t is refined, so that no order makes a difference of more than the last
 * bits. */
static inline struct pen_vec3 pen_permuted(const struct pen_ray *ray, const struct pen_vec3 *v)
{
    const double *c = (const double *)v;
    return pen_vec3(c[ray->kx], c[ray->ky], c[ray->kz]);
}

/* v with components smaller than `least` replaced by zeros of the same sign. */
static inline struct pen_vec3 pen_without_less(struct pen_vec3 v, double least)
{
    return pen_vec3(fabs(v.x) < least ? copysign(0, v.x) : v.x,
                    fabs(v.y) < least ? copysign(0, v.y) : v.y,
                    fabs(v.z) < least ? copysign(0, v.z) : v.z);
}

/* Makes a ray. Components of o below PEN_LEAST, and of d below PEN_LEAST_DIRECTION of its largest,
 * are taken as 0. Fails (returns false, *ray undefined) if o or d is not finite, or if the largest
 * component of d lies outside 2^-400 ... 2^400 (zero is): squares must stay in range. */
bool pen_ray_make(struct pen_ray *ray, struct pen_vec3 o, struct pen_vec3 d);

/* A bound of the distance between o + d and the point that a ray is aimed at. d = point - o is
 * rounded, so a far origin counts as much as a far point. */
static inline double pen_ray_end_bound(struct pen_vec3 o, struct pen_vec3 d)
{
    return 16 * PEN_U * (pen_norm1(o) + pen_norm1(d));
}

/* The rounding error of diff = a - b, exactly (Knuth). */
static inline double pen_difference_error(double a, double b, double diff)
{
    double part = diff - a;
    return (a - (diff - part)) - (b + part);
}

/* The same for vectors. */
static inline struct pen_vec3 pen_difference_error3(struct pen_vec3 a, struct pen_vec3 b,
                                                    struct pen_vec3 diff)
{
    return pen_vec3(pen_difference_error(a.x, b.x, diff.x), pen_difference_error(a.y, b.y, diff.y),
                    pen_difference_error(a.z, b.z, diff.z));
}

/* a + t d, each component rounded once. */
static inline struct pen_vec3 pen_along_once(struct pen_vec3 a, struct pen_vec3 d, double t)
{
    return pen_vec3(fma(t, d.x, a.x), fma(t, d.y, a.y), fma(t, d.z, a.z));
}

/* The surface that a ray starts on. prim is PEN_NO_PRIM for rays that start in free space. */
struct pen_origin_surface {
    uint32_t prim;
    uint8_t part;
    bool through;           /* the path passed through the surface: it arrived on the other side */
    struct pen_vec3 toward; /* from the origin back to where the arriving ray started; if that ray
                               arrived at PEN_FIRST_T or at a layer, to where the one before it
                               started */
    struct pen_vec3 before; /* from the origin back to where an earlier ray started; or zero */
    double bound;           /* distance by which the origin may miss its surface: pen_origin_at */
    double toward_bound, before_bound; /* the same for the starts of these two rays */
};

extern const struct pen_origin_surface pen_origin_none;

struct pen_hit {
    double t;
    uint32_t prim;
    uint8_t part;
};

/* Whether hit a comes before hit b on the ray. */
static inline bool pen_hit_before(struct pen_hit a, struct pen_hit b)
{
    if (a.t != b.t)
        return a.t < b.t;
    if (a.prim != b.prim)
        return a.prim < b.prim;
    return a.part < b.part;
}

/* Room for the intersections of one ray with one primitive of any kind. */
enum { PEN_MOST_INTERSECTIONS = 4 };

/* All intersections of one ray with one primitive: t ascending, any sign. */
struct pen_intersections {
    int count;
    double t[PEN_MOST_INTERSECTIONS];
    uint8_t part[PEN_MOST_INTERSECTIONS];
};

#endif
