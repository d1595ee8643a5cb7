/* SPDX-License-Identifier: MIT */
/* Solids: bodies with an index of refraction inside. A solid is a closed round primitive, or a set
 * of triangles and polygons of one material that are joined at bit-equal edges to a closed surface.
 * Flat primitives that do not close are an open solid: a ray enters it from their outward side, and
 * leaves it from the other side.
 *
 * Solids are numbered by their volumes, the largest first. If volumes are equal up to rounding, the
 * later solid in the document has the larger number. The index at a point is that of the containing
 * solid with the largest number. */
#ifndef PEN_SCENE_SOLID_H
#define PEN_SCENE_SOLID_H

#include <stdbool.h>
#include <stdint.h>

#include "geom/prims.h"

#define PEN_NO_SOLID UINT32_MAX

struct pen_solid {
    double ior;
    struct pen_box box; /* local frame */
    bool closed;
    uint32_t first, count; /* its primitives: pen_solids.prim[first] to prim[first + count - 1] */
};

struct pen_solids {
    uint32_t count;             /* 0: no primitive refracts */
    const struct pen_solid *at; /* by number */
    const uint32_t *prim;       /* primitives, solid by solid, each in document order */
    const uint32_t *of_prim;    /* by primitive number: its solid, or PEN_NO_SOLID */
    const uint8_t *turned;      /* by primitive number: its outward side is inside the solid */
};

/* Whether a solid contains p: a line from p leaves it more often than it enters it. An open solid
 * contains p if its faces are seen from p, from inside, in all directions but a share of 1e-6,
 * because at T-junctions faces may just fail to meet. For points on the surface, rounding decides.
 */
bool pen_solid_contains(const struct pen_prims *prims, const struct pen_solids *solids,
                        uint32_t solid, struct pen_vec3 p);

#endif
