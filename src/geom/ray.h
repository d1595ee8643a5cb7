/* SPDX-License-Identifier: MIT */
/* Rays, intersections, and the origin surface of a ray: the terms of every primitive's file.
 *
 * An intersection is a point where a ray passes through a surface. The intersections of one ray are
 * ordered by (t, primitive number, part): at equal t, the primitive that comes first in the
 * document comes first. t is a pure function of (ray, origin surface, primitive). So no tree,
 * thread or SIMD width can change which intersection is nearest.
 *
 * What a ray meets near its origin is decided by identity and geometry, never by an epsilon in
 * scene units: see the self-intersection rule in src/geom/SELF_INTERSECTION.md. */
#ifndef PEN_GEOM_RAY_H
#define PEN_GEOM_RAY_H

#include <stdbool.h>
#include <stdint.h>

#include "math/exact.h"
#include "math/vec3.h"

#define PEN_NO_PRIM UINT32_MAX

/* 2^-53, the unit roundoff of binary64. */
#define PEN_U 0x1p-53

/* Lower limits of numbers that are not 0: of coordinates of vertices and of rays' origins, and of
 * components of d as a share of its largest. With these limits, coordinates across a ray are
 * multiples of 2^-535. So no part of a product of two of them underflows, and the sign of a
 * difference of products is exact. */
#define PEN_LEAST 0x1p-300
#define PEN_LEAST_DIRECTION 0x1p-130

/* The t of an intersection at the ray's origin that counts: positive, and smaller than all others.
 */
#define PEN_FIRST_T 0x1p-1074

/* Upper limit of t for layers. A ray meets the layers of the surface that it starts on at multiples
 * of PEN_FIRST_T, which give their order. All of these are below the limit; all other intersections
 * are above it. */
#define PEN_LAST_LAYER_T 0x1p-1044

/* An intersection with a quadric at tp - h is refined if |tp| - h is less than this share of the
 * half chord h, because the subtraction would lose more than three bits. Intersections of tied rays
 * are always refined. */
#define PEN_NEAR 0.125

/* Both intersections are refined if the ray grazes a quadric: a discriminant below this share of
 * the squared radius keeps too few digits. */
#define PEN_GRAZING 0x1p-5

/* The range of the self-intersection rule, in rounding bounds from the ray's origin. If a ray
 * passes the border of a flat primitive within rounding in that range, the rule decides whether
 * they meet. Farther away, only light that arrives at less than 2^-23 to the surface is affected,
 * and it adds at most that share of its strength. */
#define PEN_NEARBY 0x1p23

/* A direction q from a point p of a surface grazes the surface if |n.q| is at most this share of
 * |q|. No shadow ray is as low as that. With this value, every gap through which such a ray might
 * leave a closed room is in the range of the self-intersection rule. Proof: let p be off its
 * surface by b, and the border of the next wall off its place by c. At distance x a ray of sine s
 * has risen by s x. So it can pass on the wrong side of that border only where s x <= b + c, hence
 * x <= (b + c) / s. That is nearby if s >= 1 / PEN_NEARBY; the factor 2 covers the rounding of s
 * itself. */
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

/* A ray, with the values that primitive tests need once per ray: 1/d.d, and the shear that maps it
 * to the z axis. d has any length; t is in units of d.
 * Source: Woop, Benthin, Wald, JCGT 2(1), 2013, section 3.2, for the shear. */
struct pen_ray {
    struct pen_vec3 o, d;
    double inv_dd;                          /* 1 / d.d */
    double sx, sy, sz;                      /* shear: d[kx]/d[kz], d[ky]/d[kz], 1/d[kz] */
    struct pen_vec3 permuted_o, permuted_d; /* pen_permuted of o and d */
    double near;                            /* PEN_NEAR; INFINITY if tied */
    int kx, ky, kz; /* axes permuted cyclically; kz is d's largest component */
};

/* Whether the ray is tied: d's components are equal in size, so no order of the axes is the ray's
 * own. */
static inline bool pen_ray_tied(const struct pen_ray *ray)
{
    return ray->near > PEN_NEAR;
}

/* v with its axes in the ray's order. All sums over axes that decide t use such vectors, so t has
 * the same bits in a scene whose axes are permuted cyclically. A tied ray has no order of its own.
 * Its t is refined, so that another order changes at most the last bits. */
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

/* Makes a ray. Components of o below PEN_LEAST become 0, as do those of d below PEN_LEAST_DIRECTION
 * of its largest.
 * Fails: returns false, and *ray is undefined, if o or d is not finite, or if the largest component
 * of d is outside 2^-400 ... 2^400 (also if it is zero). Squares must stay in range. */
bool pen_ray_make(struct pen_ray *ray, struct pen_vec3 o, struct pen_vec3 d);

/* A bound of the distance between o + d and the point that a ray is aimed at. d = point - o is
 * rounded, so a far origin counts as much as a far point. */
static inline double pen_ray_end_bound(struct pen_vec3 o, struct pen_vec3 d)
{
    return 16 * PEN_U * (pen_norm1(o) + pen_norm1(d));
}

/* The rounding error of diff = a - b, exactly.
 * Source: Knuth. */
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

/* The surface that a ray starts on. prim is PEN_NO_PRIM for a ray that starts in free space. */
struct pen_origin_surface {
    uint32_t prim;
    uint8_t part;
    bool through; /* the path passed through the surface: it arrived on the other side */
    /* From the origin back to the start of the arriving ray; if that ray arrived at PEN_FIRST_T
     * or at a layer, to the start of the ray before it. */
    struct pen_vec3 toward;
    struct pen_vec3 before; /* from the origin back to the start of an earlier ray; or zero */
    double bound; /* the distance by which the origin may miss its surface: pen_origin_at */
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

/* The most intersections of one ray with one primitive of any kind. */
enum { PEN_MOST_INTERSECTIONS = 4 };

/* All intersections of one ray with one primitive: t ascending, any sign. */
struct pen_intersections {
    int count;
    double t[PEN_MOST_INTERSECTIONS];
    uint8_t part[PEN_MOST_INTERSECTIONS];
};

#endif
