/* SPDX-License-Identifier: MIT */
/* Coincident surfaces: whether two surfaces are layers at a point. */
#ifndef PEN_GEOM_INTERNAL_COINCIDENCE_H
#define PEN_GEOM_INTERNAL_COINCIDENCE_H

#include "geom/prims.h"

/* Two surfaces, parts of two primitives, at a common point p. hit.t is not used. */
struct pen_pair {
    const struct pen_prims *prims;
    struct pen_hit a, b;
    struct pen_vec3 p;
    double slack; /* the distance by which p may miss either surface */
};

/* Whether one of the two surfaces, up to rounding, lies in the other one continued without end: for
 * example sheets in one plane, or equal spheres. */
bool pen_coincide(const struct pen_pair *pair);

/* Whether surface b covers surface a near p. Neighbours that share an edge do not cover each other.
 */
bool pen_covers(const struct pen_pair *pair);

#endif
