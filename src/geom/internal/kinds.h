/* SPDX-License-Identifier: MIT */
/* What the files of this room share about primitives of any kind. */
#ifndef PEN_GEOM_INTERNAL_KINDS_H
#define PEN_GEOM_INTERNAL_KINDS_H

#include "geom/prims.h"

/* All crossings of the ray's line with the primitive, as if the ray started in free space. */
void pen_prim_cross_line(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                         struct pen_crossings *out);

/* Adds both ends of the inside of a cylinder, but for the open ends. */
void pen_inside_ends(const struct pen_cylinder *c, const struct pen_inside *in,
                     struct pen_crossings *out);

#endif
