/* SPDX-License-Identifier: MIT */
/* A kernel's working memory: the stack of pending paths, the last occluder of each light, the
 * layers of the current path. One per thread, made once per task, so that rendering a pixel
 * allocates nothing. */
#ifndef PEN_SHADE_INTERNAL_SCRATCH_H
#define PEN_SHADE_INTERNAL_SCRATCH_H

#include "math/sample.h"
#include "shade/internal/corners.h"
#include "shade/internal/layers.h"
#include "shade/kernel.h"

enum {
    FX_BLUR = PEN_FX_GLOSSY | PEN_FX_FROSTED,
    FX_SAMPLED = PEN_FX_SOFT_SHADOWS | FX_BLUR, /* their samples need a key */
    FX_SECONDARY = PEN_FX_MIRROR | PEN_FX_TRANSMISSION | PEN_FX_REFRACTION /* paths go on */
};

/* A ray to be traced, and the weight of its radiance in the pixel. */
struct path {
    struct pen_ray ray;
    struct pen_origin_surface origin;
    struct pen_hit after; /* only intersections after this one count */
    struct pen_vec3 weight;
    int depth;     /* surfaces shaded before it hits the next one */
    uint32_t node; /* number of the surface it hits next in the tree of paths: pen_sample_node */
    double share;  /* with blur: of the pixel sample, 1 unless it is one of several blurred rays */
};

/* The blurred rays that an entry of the stack stands for: blur.h. */
struct blurred {
    uint32_t next, left;  /* the number of the next one; of those to come */
    double spread;        /* 1 - cos of the cone's half-angle; 0: one ray, not blurred */
    struct pen_vec3 side; /* unit; the rays are on this side of the surface, */
    double least;         /* by more than this sine */
    bool reflected;
    struct pen_sample_key key;
};

/* The solids that a path is in: media.h. */
struct media {
    uint32_t count;
    uint32_t solid[]; /* ascending */
};

struct pen_kernel_scratch {
    struct pen_shadow shadow;
    struct pen_disk_packet packet;
    uint32_t *last_occluder;         /* by light */
    struct path *waiting;            /* the stack: see kernel_body.h */
    struct blurred *blurred;         /* by entry of the stack; NULL without blur */
    size_t depth;                    /* entries of the stack */
    int surfaces_max;                /* of a pixel sample: pen_tree_surfaces_max */
    int surfaces_left;               /* of these, how many may still be shaded */
    struct layers layers;            /* of the path that is traced */
    struct corner corner;            /* of the pixel sample */
    struct pen_block_scratch *block; /* block_body.h; in block_memory */
    void *block_memory;
    struct pen_sample_key key; /* of the samples on lights; `light` is set for each light */
    uint32_t ray;              /* of a replicate, whose points come after those of earlier ones */
    uint32_t *media;           /* with refraction, the media of paths: media_at */
    size_t media_stride;
    unsigned met; /* of PEN_FX_MAY_BE_LEFT_OUT, what pixel samples have met */
    bool several; /* the path is at an interface of several surfaces: pen_solids_coincide */
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
