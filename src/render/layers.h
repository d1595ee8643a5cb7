/* SPDX-License-Identifier: MIT */
/* Layers: pictures of other data of each pixel than its colour. */
#ifndef PEN_RENDER_LAYERS_H
#define PEN_RENDER_LAYERS_H

#include <stdatomic.h>

#include "base/thread_pool.h"
#include "render/adaptive.h"
#include "scene/scene.h"

/* The layers. The names are those of the API. */
enum pen_layer {
    PEN_LAYER_BEAUTY,
    PEN_LAYER_COST,    /* the time or the tests of the pixel: enum pen_cost */
    PEN_LAYER_SAMPLES, /* camera rays */
    PEN_LAYER_DEPTH,   /* distance of the first surface from the eye, scene units; 0: none */
    PEN_LAYER_NORMAL,  /* its normal n, towards the viewer, as (n + 1) / 2; 0: none */
    PEN_LAYER_ALBEDO,  /* its kd; 0: none */
    PEN_LAYER_COUNT
};
const char *pen_layer_name(enum pen_layer layer);

/* The layer with this name; PEN_LAYER_COUNT if there is none. */
enum pen_layer pen_layer_find(const char *name);

/* The names of layers and of costs, in order; each list ends with NULL. */
extern const char *const pen_layer_names[PEN_LAYER_COUNT + 1];

enum pen_cost {
    PEN_COST_TIME, /* nanoseconds, measured for each block of 8 x 8 pixels and divided among them by
                      their tests; they differ in every render */
    PEN_COST_TESTS /* box and primitive tests: the same in every render */
};

struct pen_layer_task {
    const struct pen_scene *scene;
    int view;
    const struct pen_settings *settings;
    enum pen_layer layer; /* not the beauty: pen_render_run */
    enum pen_cost cost;
    float *rgb;    /* the image from a row on, top down, width * 3 values per row; a layer of one
                      number has it three times */
    int first_row; /* of the image; the first row in rgb */
    const atomic_bool *cancel; /* polled before each block of pixels; may be NULL */
    /* With a target error: the state after the last round. NULL: layers samples and cost, which
     * depend on it, render all rounds first; then rgb has the whole image. */
    const struct pen_adaptive *adaptive;
};

extern const char *const pen_cost_names[];

/* Makes a layer. Depth, normal and albedo are those of the pinhole's ray through the middle of the
 * pixel.
 * Threads: as pen_render_run.
 * Fails: PEN_NO_MEMORY, PEN_CANCELLED.
 * Cost: depth, normal and albedo take one ray a pixel. Tests take a counting render, ray by ray, up
 * to ten times as long as a normal one. Time takes both renders. */
bool pen_layer_render(struct pen_thread_pool *pool, const struct pen_layer_task *task,
                      struct pen_status *st);

/* Tiles of a layer's view, numbered as by pen_tile_rect. */
struct pen_layer_tiles {
    int first;
    int count; /* out: number of finished tiles, from the first on */
    /* Called before each tile but the first, from a render thread, one call at a time; may be NULL.
     * When it returns true, no more tiles are begun, and those begun are finished. */
    bool (*pause)(void *user);
    void *pause_user;
};

/* Makes these tiles of a layer; the other pixels keep their values. Else as pen_layer_render. */
bool pen_layer_render_tiles(struct pen_thread_pool *pool, const struct pen_layer_task *task,
                            struct pen_layer_tiles *tiles, struct pen_status *st);

/* The approximate time of the layer's pixels over that of the picture's pixels: 2 to 16 for `cost`,
 * in most scenes 3 to 4. The other layers take little and count as 0. */
double pen_layer_work(enum pen_layer layer, enum pen_cost cost);

/* Makes a visible picture of a layer of numbers, in place. Samples: grey up to the largest number.
 * Depth: grey, white for the nearest point, half as bright at twice the depth. Cost: a heat map by
 * the fourth root, from black at 0 over red and yellow to white at the largest. These colours are
 * already encoded. Normal and albedo are not changed. Returns the number that white represents; 0
 * if the layer is not changed. */
double pen_layer_show(enum pen_layer layer, float *rgb, size_t pixels);

#endif
