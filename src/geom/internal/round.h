/* SPDX-License-Identifier: MIT */
/* Making the round side of tubes and cylinders. */
#ifndef PEN_GEOM_INTERNAL_ROUND_H
#define PEN_GEOM_INTERNAL_ROUND_H

#include "geom/tube.h"

/* Fails: returns false as pen_tube_make. */
bool pen_round_make(struct pen_round *s, struct pen_vec3 origin, struct pen_vec3 axis, double r);

#endif
