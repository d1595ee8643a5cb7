/* SPDX-License-Identifier: MIT */
/* A kernel's working memory: the stack of pending paths, the last occluder of each light, the
 * layers of the current path. One per thread, made once per task, so that rendering a pixel
 * allocates nothing. */
#ifndef PEN_SHADE_INTERNAL_SCRATCH_H
#define PEN_SHADE_INTERNAL_SCRATCH_H

#include "math/sample.h"
#include "shade/internal/layers.h"
#include "shade/kernel.h"

/* A ray to be traced, and the weight of its radiance in the pixel. */
struct path {
    struct pen_ray ray;
    struct pen_origin_surface origin;
    struct pen_hit after; /* only intersections after this one count */
    struct pen_vec3 weight;
    int depth;     /* surfaces shaded before it hits the next one */
    uint32_t node; /* number of the surface it hits next in the tree of paths: pen_sample_node */
};

struct pen_kernel_scratch {
    struct pen_shadow shadow;
    struct pen_disk_packet packet;
    uint32_t *last_occluder;         /* by light */
    struct path *waiting;            /* the stack; max_depth entries: see kernel_body.h */
    int surfaces_max;                /* of a pixel sample: pen_tree_surfaces_max */
    int surfaces_left;               /* of these, how many may still be shaded */
    struct layers layers;            /* of the path that is traced */
    struct pen_block_scratch *block; /* block_body.h; in block_memory */
    void *block_memory;
    struct pen_sample_key key; /* of the samples on lights; `light` is set for each light */
};

/* A ray outside layers has met a hit that may have some: replaces it by the first of its class. */
void pen_layers_begin(const struct pen_kernel_input *input, struct layers *layers,
                      const struct path *path, struct pen_hit *hit);

/* Whether that hit has layers. */
bool pen_layers_met(const struct pen_kernel_input *input, const struct path *path,
                    struct pen_hit hit);

/* The next hit after that of pen_layers_begin; false if there is none. */
bool pen_layers_next(const struct pen_kernel_input *input, struct layers *layers,
                     const struct path *path, struct pen_hit *hit);

#endif
