/* SPDX-License-Identifier: MIT */
/* Coincident surfaces: when two surfaces are layers of one another at a point. */
#ifndef PEN_GEOM_INTERNAL_COINCIDENCE_H
#define PEN_GEOM_INTERNAL_COINCIDENCE_H

#include "geom/prims.h"

/* Two surfaces, parts of two primitives, at a point p of both; hit.t is not used. */
struct pen_pair {
    const struct pen_prims *prims;
    struct pen_hit a, b;
    struct pen_vec3 p;
    double slack; /* by how much p may miss either */
};

/* Whether one of the two lies in the other, continued without end, up to rounding: sheets in one
 * plane, equal spheres. */
bool pen_coincide(const struct pen_pair *pair);

/* Whether b is there wherever a is, near p. Neighbours that share an edge do not cover each other.
 */
bool pen_covers(const struct pen_pair *pair);

#endif
