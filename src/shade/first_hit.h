/* SPDX-License-Identifier: MIT */
/* What a pixel shows first: for the layers depth, normal and albedo, and for what a view sees. */
#ifndef PEN_SHADE_FIRST_HIT_H
#define PEN_SHADE_FIRST_HIT_H

#include "shade/kernel.h"

struct pen_first_hit {
    uint32_t prim;          /* the primitive's number */
    double distance;        /* from the eye, scene units */
    struct pen_vec3 normal; /* unit, towards the viewer; world axes */
    struct pen_vec3 albedo; /* kd */
};

/* The first surface on the pinhole's ray through the middle of pixel (x, y), whatever the samples
 * and the lens are; of coincident ones the first in the document. False if there is none, or if its
 * point is not finite. Threads: any, each at a time. */
bool pen_first_hit(const struct pen_kernel_input *input, int x, int y, struct pen_first_hit *out);

#endif
