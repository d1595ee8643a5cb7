/* SPDX-License-Identifier: MIT */
/* The round side of infinite cylinders and cylinders: what only their own files use. */
#ifndef PEN_GEOM_INTERNAL_CYLINDER_SIDE_H
#define PEN_GEOM_INTERNAL_CYLINDER_SIDE_H

#include "geom/infinite_cylinder.h"

/* Fails: returns false as pen_infinite_cylinder_make. */
bool pen_cylinder_side_make(struct pen_cylinder_side *s, struct pen_vec3 origin,
                            struct pen_vec3 axis, double r);

/* How far a cylinder with this side reaches along unit vector n beyond point p: one of height h
 * from q, a point of the axis, or, with h = INFINITY, an infinite one; that is without end where
 * the axis is not across n, as far as the rounding of both can tell. */
double pen_cylinder_side_reach(const struct pen_cylinder_side *s, struct pen_vec3 q, double h,
                               struct pen_vec3 n, struct pen_vec3 p);

#endif
