/* SPDX-License-Identifier: MIT */
/* Making the round side of infinite cylinders and cylinders. */
#ifndef PEN_GEOM_INTERNAL_CYLINDER_SIDE_H
#define PEN_GEOM_INTERNAL_CYLINDER_SIDE_H

#include "geom/infinite_cylinder.h"

/* Fails: returns false as pen_infinite_cylinder_make. */
bool pen_cylinder_side_make(struct pen_cylinder_side *s, struct pen_vec3 origin,
                            struct pen_vec3 axis, double r);

#endif
