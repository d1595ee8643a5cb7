/* SPDX-License-Identifier: MIT */
/* What a kernel needs besides its input: paths that wait for their turn, and what blocked each
 * light last time. One per thread, made once per task; no pixel allocates. */
#ifndef PEN_SHADE_INTERNAL_SCRATCH_H
#define PEN_SHADE_INTERNAL_SCRATCH_H

#include "math/sample.h"
#include "shade/kernel.h"

/* A ray on its way, and what its light is worth in the pixel. */
struct path {
    struct pen_ray ray;
    struct pen_origin_surface origin;
    struct pen_hit after; /* intersections up to this one are behind it */
    struct pen_vec3 weight;
    int depth;     /* surfaces shaded before it hits the next one */
    uint32_t node; /* of the surface it hits next: pen_sample_node */
};

struct pen_kernel_scratch {
    struct pen_shadow shadow;
    struct pen_shadow_packet packet;
    uint32_t *last_occluder;   /* by light */
    struct path *waiting;      /* max_depth of them are enough: see the kernel */
    struct pen_sample_key key; /* of the samples on lights, but for `light` */
};

#endif
