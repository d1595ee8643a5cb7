/* SPDX-License-Identifier: MIT */
/* The round side of infinite cylinders and cylinders: functions for the files of these kinds. */
#ifndef PEN_GEOM_INTERNAL_CYLINDER_SIDE_H
#define PEN_GEOM_INTERNAL_CYLINDER_SIDE_H

#include "geom/infinite_cylinder.h"

/* Makes the side.
 * Fails: returns false in the cases of pen_infinite_cylinder_make. */
bool pen_cylinder_side_make(struct pen_cylinder_side *s, struct pen_vec3 origin,
                            struct pen_vec3 axis, double r);

/* How far a cylinder with this side extends along unit vector n beyond point p. It has height h
 * from q, a point of the axis. With h = INFINITY it is infinite; then the result is INFINITY,
 * unless the axis is across n within the rounding of both. */
double pen_cylinder_side_reach(const struct pen_cylinder_side *s, struct pen_vec3 q, double h,
                               struct pen_vec3 n, struct pen_vec3 p);

#endif
