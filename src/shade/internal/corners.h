/* SPDX-License-Identifier: MIT */
/* Corners: a point of a flat face at which a path, within rounding, also meets another face. It
 * gets no light and reflects nothing (surface_hardly_left). So the edge of two mirrors, or of two
 * faces of glass, would be a dark line. The pixel kernel renders such a pixel sample again with its
 * camera ray moved slightly aside. The value is the picture from there. README.md, Corners, derives
 * the distance. */
#ifndef PEN_SHADE_INTERNAL_CORNERS_H
#define PEN_SHADE_INTERNAL_CORNERS_H

#include "shade/kernel.h"

/* After this number of moves, the camera ray is traced at its original place. */
enum { CORNER_MOVES = 28 };

/* Points of a path are in a corner if their distance is below this number of their bounds. Several
 * mirrors may come before the corner, each with its own rounding. */
#define CORNER_BOUNDS 0x1p12

struct corner {
    bool met;     /* the path has met a corner: the sample must be rendered again */
    int moves;    /* of the camera ray */
    double bound; /* of the first point of the original ray */
};

/* Moves the camera ray and clears `met`. Returns false if some surface is nearer than twice the
 * way, because the eye could then leave a room. */
bool pen_corner_move(struct corner *corner, const struct pen_kernel_input *input,
                     struct pen_ray *ray);

#endif
