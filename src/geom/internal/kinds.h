/* SPDX-License-Identifier: MIT */
/* Functions that the kinds of primitives share. */
#ifndef PEN_GEOM_INTERNAL_KINDS_H
#define PEN_GEOM_INTERNAL_KINDS_H

#include "geom/kind.h"

/* pen_sphere_functions and so on, each in the file of its kind. */
#define KIND(NAME, name, ...) extern const struct pen_kind_functions pen_##name##_functions;
PEN_KINDS(KIND)
#undef KIND

static inline void pen_intersections_add(struct pen_intersections *out, double t, uint8_t part)
{
    out->t[out->count] = t;
    out->part[out->count] = part;
    out->count++;
}

/* Adds an end of the interval inside a primitive that has these `parts`. Adds nothing if the end is
 * at a missing cap. */
static inline void pen_intersections_add_end(struct pen_intersections *out, unsigned parts,
                                             double t, uint8_t part)
{
    if (parts >> part & 1)
        pen_intersections_add(out, t, part);
}

/* The two intersections with the only part of a quadric. */
static inline void pen_intersections_pair(struct pen_intersections *out, double lo, double hi)
{
    pen_intersections_add(out, lo, PEN_PART_SIDE);
    pen_intersections_add(out, hi, PEN_PART_SIDE);
}

/* The intersections of a ray that leaves the only part of a quadric: the other end of the chord. */
static inline void pen_intersections_own(struct pen_intersections *out, double chord)
{
    if (chord > 0)
        pen_intersections_add(out, chord, PEN_PART_SIDE);
}

/* The intersections of a quadric that contains the origin: t = 0, and the other end of the chord.
 */
static inline void pen_intersections_chord(struct pen_intersections *out, double chord)
{
    out->count = 0;
    if (chord != 0)
        pen_intersections_pair(out, chord < 0 ? chord : 0, chord < 0 ? 0 : chord);
}

/* A lower bound of how far the farthest of the points lies along unit vector n beyond p. The dot
 * product is known to some u of the distance. The result excludes that rounding, so that a
 * neighbour in the same plane does not rise above 0. */
static inline double pen_farthest(const struct pen_vec3 *v, uint32_t count, struct pen_vec3 n,
                                  struct pen_vec3 p)
{
    double far = -INFINITY;
    for (uint32_t i = 0; i < count; i++) {
        struct pen_vec3 f = pen_sub(v[i], p);
        double d = pen_dot(n, f) - 4 * PEN_U * pen_norm1(f);
        far = far > d ? far : d;
    }
    return far;
}

#endif
