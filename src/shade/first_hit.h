/* SPDX-License-Identifier: MIT */
/* The first surface of a pixel, for the layers depth, normal and albedo, and for lists of what a
 * view sees. */
#ifndef PEN_SHADE_FIRST_HIT_H
#define PEN_SHADE_FIRST_HIT_H

#include "shade/kernel.h"

struct pen_first_hit {
    uint32_t prim;          /* the primitive's number */
    double distance;        /* from the eye, scene units */
    struct pen_vec3 normal; /* unit, towards the viewer; world axes */
    struct pen_vec3 albedo; /* kd */
};

/* The first surface on the pinhole's ray through the middle of pixel (x, y); samples and the lens
 * do not matter. Of coincident surfaces it is the first in the document. Returns false if there is
 * none, or if its point is not finite.
 * Threads: any number at the same time. */
bool pen_first_hit(const struct pen_kernel_input *input, int x, int y, struct pen_first_hit *out);

#endif
