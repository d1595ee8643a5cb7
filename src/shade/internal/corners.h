/* SPDX-License-Identifier: MIT */
/* Corners: a path that meets a flat face, and another one within rounding of where its ray starts,
 * brings no light there and is not mirrored (surface_hardly_left). The edge of two mirrors, or of
 * two faces of glass, would be seen as a dark line. Such a pixel sample is rendered again by the
 * pixel kernel with its camera ray moved a little aside: the value is what an eye there sees.
 * README.md, Corners, says how far. */
#ifndef PEN_SHADE_INTERNAL_CORNERS_H
#define PEN_SHADE_INTERNAL_CORNERS_H

#include "shade/kernel.h"

/* How often a camera ray is moved. If all its paths meet a corner, the sample is that of the ray
 * that is not moved. */
enum { CORNER_MOVES = 28 };

/* How near the hits of a path are in a corner, in rounding bounds. Several mirrors may have brought
 * a path there, with the rounding of each. */
#define CORNER_BOUNDS 0x1p12

struct corner {
    bool met;             /* the path has met a corner */
    int moves;            /* the number of the camera ray; 0, and CORNER_MOVES: not moved */
    struct pen_hit first; /* of the ray that is not moved */
    double bound;         /* of the point there */
};

/* Moves the camera ray. */
void pen_corner_move(const struct corner *corner, const struct pen_pinhole *pinhole,
                     struct pen_ray *ray);

#endif
