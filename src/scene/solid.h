/* SPDX-License-Identifier: MIT */
/* Solids: what has an inside with an index of refraction. A solid is a closed round primitive, or
 * triangles and polygons of one material that are joined at bit-equal edges to a closed surface.
 * Flat primitives that do not close are a solid of their own kind: a ray enters it where it comes
 * from their outward side, and leaves it from the other.
 *
 * Solids are numbered by their volumes, the largest first; of those that are equal but for
 * rounding, the later in the document has the larger number. So the index at a point is that of the
 * containing solid with the largest number. */
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
    uint32_t count;             /* 0: nothing refracts */
    const struct pen_solid *at; /* by number */
    const uint32_t *prim;       /* primitives, solid by solid, each in document order */
    const uint32_t *of_prim;    /* by primitive number: its solid, or PEN_NO_SOLID */
    const uint8_t *turned;      /* by primitive number: its outward side is inside the solid */
};

/* Whether a solid contains p: a line from p leaves it more often than it enters it. One whose faces
 * do not close contains p if they are seen in all directions from p, from within, but for 1e-6 of
 * them: at T-junctions faces only just fail to meet. Of points on the surface, rounding decides. */
bool pen_solid_contains(const struct pen_prims *prims, const struct pen_solids *solids,
                        uint32_t solid, struct pen_vec3 p);

#endif
