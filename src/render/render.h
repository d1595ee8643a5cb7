/* SPDX-License-Identifier: MIT */
/* Rendering: scene x settings -> pixels. A pool of threads draws tiles from a shared counter;
 * every pixel is a pure function of its position, so the result is the same bits for any number
 * of threads and any tile size. */
#ifndef PEN_RENDER_RENDER_H
#define PEN_RENDER_RENDER_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "base/thread_pool.h"
#include "scene/scene.h"
#include "shade/kernel.h"

struct pen_rect {
    int x, y, width, height; /* pixels */
};

/* The tiles of an image, row by row from the top left; the last ones of a row or column may be
 * smaller. */
int pen_tile_count(int width, int height, int tile);
struct pen_rect pen_tile_rect(int width, int height, int tile, int index);

struct pen_render_stats {
    double render_ms; /* first tile begun to last tile done */
    double cpu_ms;    /* of the render threads, over those tiles */
    int threads;      /* how many worked on it: no more than there were tiles */
    int float_resets; /* of those, whose floating-point state was not the default; expected 0 */
    struct pen_ray_counts rays;
    bool tests_counted;           /* if the task asked for it */
    struct pen_test_counts tests; /* of all rays; per ray is by the sum of `rays` */
    uint32_t tile_count;
    double *tile_ms; /* tile_count values; NULL if not asked for, or if the run failed.
                      * Owns: the caller frees it with free(). */
    const char *kernel;
    unsigned effects;
};

/* One call renders some tiles of one view. */
struct pen_render_task {
    const struct pen_scene *scene;
    int view;
    const struct pen_settings *settings;
    int first_tile, tile_count; /* tile_count -1: all from first_tile on */
    float *rgb;                 /* the whole image, width * height * 3, row 0 on top */
    const atomic_bool *cancel;  /* polled before each pixel; may be NULL */
    /* Called after each tile from a render thread, one call at a time; may be NULL. */
    void (*tile_done)(void *user, struct pen_rect rect);
    void *user;
    /* Called before each pixel, from the render thread of that number (from 0 on); may be NULL.
     * For whoever looks on from outside; what it does must not matter to the picture. */
    void (*pixel_begins)(void *user, int thread, int x, int y);
    void *pixel_user;
    bool keep_tile_ms;
    /* Counts box and primitive tests, see pen_trace_count_ops_get. The film is the same, the counts
     * are for any number of threads, tile size and instruction set, but the run takes longer: time
     * another one. */
    bool count_tests;
};

/* Renders; returns when the tiles are done. One task at a time per pool; the calling thread only
 * waits. Fails: PEN_CANCELLED (pixels of the tiles that tile_done was called for are valid, and
 * *stats covers what was done), PEN_NO_MEMORY, PEN_INTERNAL (tiles that the image does not have).
 */
bool pen_render_run(struct pen_thread_pool *pool, const struct pen_render_task *task,
                    struct pen_render_stats *stats, struct pen_status *st);

/* One pixel, for looking closely, on the calling thread: the values that the film is rounded
 * from. *rays counts its rays. Fails: PEN_NO_MEMORY. */
bool pen_render_pixel(const struct pen_scene *scene, int view, const struct pen_settings *settings,
                      int x, int y, double rgb[3], struct pen_ray_counts *rays,
                      struct pen_status *st);

#endif
