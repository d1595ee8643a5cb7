/* SPDX-License-Identifier: MIT */
/* Cutting of a polygon into triangles. */
#ifndef PEN_GEOM_TRIANGULATE_H
#define PEN_GEOM_TRIANGULATE_H

#include <stdbool.h>
#include <stdint.h>

#include "math/vec3.h"

/* Cuts the polygon into count - 2 triangles, seen along its normal n. corner[i] are the vertices of
 * triangle i, in the polygon's order. The triangles depend neither on the first vertex of the
 * outline nor on its direction. The triangles of an outline that is not simple may overlap. Still,
 * each of them is the difference of two outlines, so about any line their windings add up to that
 * of the polygon.
 * Cost: up to the square of `count` steps.
 * Fails: returns false when out of memory. */
bool pen_triangulate(const struct pen_vec3 *v, uint32_t count, struct pen_vec3 n,
                     uint32_t (*corner)[3]);

#endif
