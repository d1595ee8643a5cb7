/* SPDX-License-Identifier: MIT */
/* Corners: a point of a flat face where a path also meets another one, within rounding. It brings
 * no light and is not mirrored (surface_hardly_left), so that the edge of two mirrors, or of two
 * faces of glass, would be a dark line. Such a pixel sample is rendered again by the pixel kernel
 * with its camera ray moved a little aside: the value is what an eye there sees. README.md,
 * Corners, derives how far. */
#ifndef PEN_SHADE_INTERNAL_CORNERS_H
#define PEN_SHADE_INTERNAL_CORNERS_H

#include "shade/kernel.h"

/* After as many moves the camera ray is traced where it was. */
enum { CORNER_MOVES = 28 };

/* Points of a path that are nearer than this to one another are in a corner, in bounds of the
 * points. Several mirrors may be before it, each with a rounding of its own. */
#define CORNER_BOUNDS 0x1p12

struct corner {
    bool met;     /* the path has met a corner: the sample is to be rendered again */
    int moves;    /* of the camera ray */
    double bound; /* of the first point of the ray that is not moved */
};

/* Moves the camera ray, which has met no corner then. False if some surface is nearer than twice
 * the way: the eye could leave a room. */
bool pen_corner_move(struct corner *corner, const struct pen_kernel_input *input,
                     struct pen_ray *ray);

#endif
