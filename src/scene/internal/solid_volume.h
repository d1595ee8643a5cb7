/* SPDX-License-Identifier: MIT */
/* The volume of a solid in the document's units. It is the volume in the solid's own coordinates
 * times the determinant of its transforms. So copies of a solid have the same volume wherever
 * groups move them. */
#ifndef PEN_SCENE_INTERNAL_SOLID_VOLUME_H
#define PEN_SCENE_INTERNAL_SOLID_VOLUME_H

#include <stdbool.h>

#include "scene/internal/scene_prim.h"

/* The sums over the faces of a solid; zero at first. */
struct solid_volume {
    double round;                     /* of a round primitive, which is a solid alone */
    double own, moved;                /* of faces: in own coordinates, and in scene units */
    struct pen_vec3 from, moved_from; /* a vertex of the first face */
    struct pen_transform moved_by;    /* of the first face */
    bool begun, mixed;                /* mixed: faces differ in their transforms */
};

/* Adds a primitive. `turned`: its outward side is inside the solid. */
void pen_solid_volume_add(struct solid_volume *volume, const struct pen_scene_prim *prim,
                          bool turned);
double pen_solid_volume(const struct solid_volume *volume);

#endif
