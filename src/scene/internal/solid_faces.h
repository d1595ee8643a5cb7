/* SPDX-License-Identifier: MIT */
/* Joins refracting triangles and polygons to solids. */
#ifndef PEN_SCENE_INTERNAL_SOLID_FACES_H
#define PEN_SCENE_INTERNAL_SOLID_FACES_H

#include <stdbool.h>
#include <stdint.h>

#include "geom/prims.h"

/* A triangle or polygon. The caller sets the first three members. Faces that are left out of the
 * scene come after all others. */
struct solid_face {
    struct pen_outline line;
    uint32_t prim;     /* PEN_NO_PRIM: left out of the scene */
    uint32_t material; /* equal numbers: one material */
    uint32_t solid;    /* the number of the solid's first face */
    bool closed;       /* the solid is closed; if not, its faces have the sides of the document */
    bool turned;       /* the face's outward side is inside the solid */
    /* During the joining: */
    bool wall;                   /* another face has the same vertices */
    uint32_t patch_up, group_up; /* parents in two forests */
    bool turned_up;              /* turned against the parent in the patch */
    bool open;                   /* for a root: of the patch, then of the group */
    int32_t balance;             /* for a root, along one edge */
};

/* Joins faces.
 * Fails: returns false when out of memory.
 * Cost: O(n log n) in the edges. */
bool pen_solid_faces_join(struct solid_face *face, uint32_t count);

#endif
