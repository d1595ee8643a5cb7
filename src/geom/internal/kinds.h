/* SPDX-License-Identifier: MIT */
/* What the files of this room share about primitives of any kind. */
#ifndef PEN_GEOM_INTERNAL_KINDS_H
#define PEN_GEOM_INTERNAL_KINDS_H

#include "geom/prims.h"

/* All intersections of the ray's line with the primitive, as if the ray started in free space. */
void pen_prim_intersect_line(const struct pen_prims *prims, uint32_t prim,
                             const struct pen_ray *ray, struct pen_intersections *out);

/* Adds both ends of the inside of a cylinder, but for the open ends. */
void pen_interval_ends(const struct pen_cylinder *c, const struct pen_interval *in,
                       struct pen_intersections *out);

#endif
