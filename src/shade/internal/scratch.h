/* SPDX-License-Identifier: MIT */
/* A kernel's working memory: the stack of pending paths, the last occluder of each light, the
 * layers of the current path. There is one per thread, made once per task, so rendering a pixel
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
    FX_SECONDARY = PEN_FX_MIRROR | PEN_FX_TRANSMISSION | PEN_FX_REFRACTION /* paths continue */
};

/* A ray to be traced, and the weight of its radiance in the pixel. */
struct path {
    struct pen_ray ray;
    struct pen_origin_surface origin;
    struct pen_hit after; /* only intersections after this one count */
    struct pen_vec3 weight;
    int depth;     /* number of surfaces shaded before the next hit */
    uint32_t node; /* number of the next surface in the tree of paths: pen_sample_node */
    double share; /* with blur: the share of the pixel sample; 1, or less for one of several blurred
                     rays */
};

/* The blurred rays of one entry of the stack: blur.h. */
struct blurred {
    uint32_t next, left;  /* number of the next ray; number of rays left */
    double spread;        /* 1 - cos of the cone's half-angle; 0: one ray, not blurred */
    struct pen_vec3 side; /* unit; the rays are on this side of the surface */
    double least;         /* the least sine between these rays and the surface */
    bool reflected;
    struct pen_sample_key key;
};

/* The solids that contain a path: media.h. */
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
    int surfaces_left;               /* the number of surfaces that may still be shaded */
    struct layers layers;            /* of the current path */
    struct corner corner;            /* of the pixel sample */
    struct pen_block_scratch *block; /* block_body.h; in block_memory */
    void *block_memory;
    struct pen_sample_key key; /* of the samples on lights; `light` is set for each light */
    uint32_t ray;              /* of a replicate; its points come after those of earlier rays */
    uint32_t *media;           /* with refraction, the media of paths: media_at */
    size_t media_stride;
    unsigned met; /* bits of PEN_FX_MAY_BE_LEFT_OUT that pixel samples have met */
    bool several; /* the path is at an interface of several surfaces: pen_solids_coincide */
};

/* Begins layers at a hit of a ray that is outside layers: replaces it by the first hit of its
 * class. */
void pen_layers_begin(const struct pen_kernel_input *input, struct layers *layers,
                      const struct path *path, struct pen_hit *hit);

/* Whether that hit has layers. */
bool pen_layers_met(const struct pen_kernel_input *input, const struct path *path,
                    struct pen_hit hit);

/* The next hit after that of pen_layers_begin; false if there is none. */
bool pen_layers_next(const struct pen_kernel_input *input, struct layers *layers,
                     const struct path *path, struct pen_hit *hit);

#endif
