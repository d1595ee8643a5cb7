/* SPDX-License-Identifier: MIT */
/* Rays, hits, and the rule for leaving a surface. The words of every primitive file.
 *
 * A crossing is a point where a ray passes through a surface. Crossings of one ray are ordered by
 * (t, primitive number, part); at equal t the primitive that comes first in the document comes
 * first. t is a pure function of (ray, what it leaves, primitive), so no tree, thread or SIMD
 * width can change which crossing is nearest.
 *
 * Leaving a surface is decided by identity, never by an epsilon in scene units:
 *  - a flat primitive is not crossed again by a ray that starts on it;
 *  - a quadric that the ray starts on has one root that is 0 exactly; it is dropped by identity,
 *    and the other root is kept if it is positive;
 *  - another primitive that contains the origin within the rounding bound of the origin's own
 *    computation is treated the same way at that point, when the ray leaves it on the side that
 *    the leave states (see pen_leave_ignores). */
#ifndef PEN_GEOM_RAY_H
#define PEN_GEOM_RAY_H

#include <stdbool.h>
#include <stdint.h>

#include "pen/math/exact.h"
#include "pen/math/vec3.h"

#define PEN_NO_PRIM UINT32_MAX

/* 2^-53, the unit roundoff of binary64. */
#define PEN_U 0x1p-53

enum pen_part {
    PEN_PART_SIDE = 0, /* the only part of sphere, tube and flat bodies; a cylinder's side */
    PEN_PART_BASE = 1, /* a cylinder's cap at `base` */
    PEN_PART_TOP = 2   /* the other cap */
};

/* A ray, with what the watertight polygon test needs once per ray (Woop, Benthin, Wald, JCGT
 * 2(1), 2013, section 3.2). d has any length but zero; t is in units of d. */
struct pen_ray {
    struct pen_vec3 o, d;
    int kx, ky, kz;    /* axes permuted so that kz is d's largest component */
    double sx, sy, sz; /* shear: d[kx]/d[kz], d[ky]/d[kz], 1/d[kz] */
};

/* Makes a ray. Fails (returns false) if o or d is not finite or d is zero. */
bool pen_ray_make(struct pen_ray *ray, struct pen_vec3 o, struct pen_vec3 d);

/* What a ray starts on. prim is PEN_NO_PRIM for rays that start in free space. */
struct pen_leave {
    uint32_t prim;
    uint8_t part;
    bool through;           /* it goes on at the other side of the surface than it arrived from */
    struct pen_vec3 toward; /* from the origin back to where the arriving ray came from */
    double bound;           /* distance by which the origin may miss its surface by rounding */
};

extern const struct pen_leave pen_leave_nothing;

struct pen_hit {
    double t;
    uint32_t prim;
    uint8_t part;
};

/* Whether crossing a is before crossing b. */
static inline bool pen_hit_before(struct pen_hit a, struct pen_hit b)
{
    if (a.t != b.t)
        return a.t < b.t;
    if (a.prim != b.prim)
        return a.prim < b.prim;
    return a.part < b.part;
}

/* All crossings of one ray with one primitive: at most two, t[0] < t[1] if two; any sign. */
struct pen_crossings {
    int count;
    double t[2];
    uint8_t part[2];
};

/* Whether a crossing at t of another primitive with unit normal n (either sign) is the origin
 * itself: within the bound of the primitive, and left on the side that the leave states.
 * Call only for prim != leave->prim and leave->prim != PEN_NO_PRIM. */
static inline bool pen_leave_ignores(const struct pen_leave *leave, const struct pen_ray *ray,
                                     double t, struct pen_vec3 n)
{
    double dn = pen_dot(ray->d, n);
    if (!(t * fabs(dn) <= leave->bound))
        return false;
    double wn = pen_dot(leave->toward, n);
    return leave->through ? dn * wn <= 0 : dn * wn >= 0;
}

#endif
