/* SPDX-License-Identifier: MIT */
/* Layers: pictures of what is known of each pixel beside its colour. */
#ifndef PEN_RENDER_LAYERS_H
#define PEN_RENDER_LAYERS_H

#include <stdatomic.h>

#include "base/thread_pool.h"
#include "render/adaptive.h"
#include "scene/scene.h"

/* The names are those of the API. */
enum pen_layer {
    PEN_LAYER_BEAUTY,
    PEN_LAYER_COST,    /* the time or the tests that the pixel took: enum pen_cost */
    PEN_LAYER_SAMPLES, /* camera rays */
    PEN_LAYER_DEPTH,   /* distance of the first surface from the eye, scene units; 0 for none */
    PEN_LAYER_NORMAL,  /* its normal n, towards the viewer, as (n + 1) / 2; 0 for none */
    PEN_LAYER_ALBEDO,  /* its kd; 0 for none */
    PEN_LAYER_COUNT
};
const char *pen_layer_name(enum pen_layer layer);

/* The layer of that name; PEN_LAYER_COUNT if there is none. */
enum pen_layer pen_layer_find(const char *name);

/* The names of layers and of costs, in their order; NULL ends each. */
extern const char *const pen_layer_names[PEN_LAYER_COUNT + 1];

enum pen_cost {
    PEN_COST_TIME, /* nanoseconds: measured for each block of 8 x 8 pixels, and shared among them by
                    * their tests. No two renders give the same. */
    PEN_COST_TESTS /* box and primitive tests: the same in every render */
};

struct pen_layer_task {
    const struct pen_scene *scene;
    int view;
    const struct pen_settings *settings;
    enum pen_layer layer; /* not the beauty: pen_render_run */
    enum pen_cost cost;
    float *rgb; /* the image from a row on, width * 3 values for each, from the top down; layers of
                   one number have it three times */
    int first_row;             /* of the image, the first one in rgb */
    const atomic_bool *cancel; /* polled before each block of pixels; may be NULL */
    /* With a target error: the state after the last round. NULL: samples and cost, which depend on
     * it, render all rounds first, for which rgb has the whole image. */
    const struct pen_adaptive *adaptive;
};

extern const char *const pen_cost_names[];

/* Makes a layer. Depth, normal and albedo are those of the pinhole's ray through the middle of the
 * pixel. Threads: as pen_render_run. Fails: PEN_NO_MEMORY, PEN_CANCELLED. Cost: depth, normal and
 * albedo one ray a pixel; tests a render that counts, ray by ray, which takes up to ten times as
 * long as one that does not; time both. */
bool pen_layer_render(struct pen_thread_pool *pool, const struct pen_layer_task *task,
                      struct pen_status *st);

/* Tiles of a layer's view, as pen_tile_rect numbers them. */
struct pen_layer_tiles {
    int first;
    int count; /* out: how many are done, from the first on */
    /* Asked before each tile but the first, from a render thread, one call at a time; may be NULL.
     * When it returns true no more tiles are begun, and those that are begun are finished. */
    bool (*pause)(void *user);
    void *pause_user;
};

/* Makes these tiles of a layer; the other pixels stay as they are. Else as pen_layer_render. */
bool pen_layer_render_tiles(struct pen_thread_pool *pool, const struct pen_layer_task *task,
                            struct pen_layer_tiles *tiles, struct pen_status *st);

/* About how many times as long as the picture's pixels those of the layer take: 2 to 16 for `cost`,
 * in most scenes 3 to 4; little for the others, which count as 0. */
double pen_layer_work(enum pen_layer layer, enum pen_cost cost);

/* Makes a layer of numbers one that can be looked at, in place: samples grey up to the largest
 * number; depth grey, the nearest white, twice as far half as bright; cost a heat map from black at
 * 0 over red and yellow to white at the largest, by the fourth root. Their colours are encoded
 * already. Normal and albedo stay as they are. Returns what white stands for; 0 if the layer stays
 * as it is. */
double pen_layer_show(enum pen_layer layer, float *rgb, size_t pixels);

#endif
