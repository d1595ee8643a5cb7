/* SPDX-License-Identifier: MIT */
/* Cutting a polygon into triangles. */
#ifndef PEN_GEOM_INTERNAL_TRIANGULATE_H
#define PEN_GEOM_INTERNAL_TRIANGULATE_H

#include <stdbool.h>
#include <stdint.h>

#include "math/vec3.h"

/* Cuts the polygon into count - 2 triangles, seen along its normal n; corner[i] are the vertices of
 * triangle i, in the polygon's order. They are the same triangles wherever the outline starts and
 * whichever way it runs. Where the outline is not simple, they may overlap, but each still is the
 * difference of two outlines: the windings of the triangles add up to that of the polygon, about
 * any line. Takes up to the square of `count` steps. Fails: returns false when out of memory. */
bool pen_triangulate(const struct pen_vec3 *v, uint32_t count, struct pen_vec3 n,
                     uint32_t (*corner)[3]);

#endif
