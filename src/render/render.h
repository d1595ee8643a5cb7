/* SPDX-License-Identifier: MIT */
/* Renders the pixels of a scene under given settings. The threads of a pool take tiles, and in the
 * end share the last ones. Every pixel is a pure function of its position, so the result has the
 * same bits for any number of threads and any tile size. */
#ifndef PEN_RENDER_RENDER_H
#define PEN_RENDER_RENDER_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "base/thread_pool.h"
#include "math/rect.h"
#include "render/adaptive.h"
#include "scene/scene.h"
#include "shade/kernel.h"

/* The tiles of an image, numbered row by row from the top left. Tiles at the right and bottom edges
 * may be smaller. */
int pen_tile_count(int width, int height, int tile);
struct pen_rect pen_tile_rect(int width, int height, int tile, int index);

/* A round of an adaptive render. */
struct pen_round {
    int level;               /* pen_adaptive_select; 0 for the pilot */
    int tiles;               /* finished, from the first on: all but in a round that time ended, or
                              * that goes on */
    uint64_t pixels;         /* selected to be refined */
    double error, low, high; /* of the picture after it, estimated */
};
enum { PEN_ROUNDS_MAX = 64 };

struct pen_adaptive_stats {
    double target;
    bool met;
    bool timed; /* the render had a deadline */
    bool ended; /* no round follows */
    int rounds; /* that are decided; 0 after a render: it was not adaptive */
    struct pen_round round[PEN_ROUNDS_MAX]; /* between rounds and in them, the next is the one that
                                             * goes on */
    uint64_t capped;                        /* pixels that max_samples kept from being refined */
    double unproven;                        /* of the last decision: see struct pen_decision */
    struct pen_sample_spread samples;
};

struct pen_render_stats {
    double render_ms; /* from the start of the first tile to the end of the last */
    double cpu_ms;    /* processor time of the render threads, also of rows_done */
    double thread_ms; /* from the call to each thread's return, added up over the threads: more than
                       * cpu_ms where they waited, for a processor or for each other */
    int64_t done_ns;  /* pen_clock_ns() at the end of the last tile */
    int threads;      /* threads that took part: no more than there were blocks of pixels */
    int float_resets; /* of these, how many had a floating-point state that was not the default;
                       * expected 0 */
    struct pen_ray_counts rays;
    bool tests_counted; /* as the task requests */
    struct pen_test_counts
        tests; /* of all rays; the tests per ray are this over the sum of `rays` */
    uint32_t tile_count;
    double *tile_ms; /* tile_count values, the time that threads spent on each tile, added up if
                      * several shared it; NULL if the task does not request it, or failed.
                      * Owns: the caller frees it with free(). */
    const char *kernel;
    unsigned effects;
    struct pen_adaptive_stats adaptive;
};

/* Notes that the upper `rows` rows of the image are finished. */
typedef void pen_render_rows_fn(void *user, int rows);

/* One call renders some tiles of one view. */
struct pen_render_task {
    const struct pen_scene *scene;
    int view;
    const struct pen_settings *settings;
    int first_tile, tile_count; /* tile_count -1: all tiles from first_tile on */
    float *rgb;                 /* the whole image, width * height * 3, row 0 at the top */
    const atomic_bool *cancel;  /* polled before each block of pixels; may be NULL */
    /* Called after each tile from a render thread, one call at a time; may be NULL. */
    void (*tile_done)(void *user, struct pen_rect rect);
    void *user;
    /* Called from a render thread each time that more rows are finished, with larger numbers each
     * time and the last time with all rows; one call at a time, while the other threads render on.
     * The task must have all tiles of the image. May be NULL. */
    pen_render_rows_fn *rows_done;
    void *rows_user;
    /* Called for each pixel, before the block of pixels that it is in, from the render thread with
     * the number `thread`, from 0 on; may be NULL. It lets a caller follow the progress, and must
     * not affect the picture. */
    void (*pixel_begins)(void *user, int thread, int x, int y);
    void *pixel_user;
    bool pixel_by_pixel; /* render no blocks: pixel_begins is called just before its pixel */
    /* With a target error: renders the next round of this state only, where it wants pixels. NULL:
     * all rounds, which needs all tiles; tile_done and rows_done are called after the last, and
     * round_done after each, from the calling thread. */
    struct pen_adaptive *adaptive;
    void (*round_done)(void *user, const struct pen_round *round); /* may be NULL */
    /* Asked before each tile but the first, from a render thread, one call at a time; may be NULL.
     * When it returns true no more tiles are begun, and those that are begun are finished. Then
     * stats->tile_count tells how many these are; of all rounds, `paused` is called. */
    bool (*pause)(void *user);
    /* Called between two rounds, and where `pause` has stopped one, from the calling thread, with
     * what has been rendered so far, which it may keep (render/adaptive_state.h); may be NULL.
     * Returns whether to go on. */
    bool (*paused)(void *user, const struct pen_adaptive *adaptive,
                   const struct pen_render_stats *stats);
    void *pause_user; /* of both */
    /* What an earlier render has told `paused` of the state `adaptive`; NULL: that is new. */
    const struct pen_render_stats *earlier;
    /* Rounds end by this time of pen_clock_ns, but for the first, which is always whole; 0: they
     * end when the target is met. What is rendered by then depends on the machine and its load. */
    int64_t deadline_ns;
    /* Renders these rounds instead of deciding on new ones: what an earlier render has noted of
     * itself. The picture gets the same bytes. */
    const struct pen_adaptive_stats *repeat;
    bool keep_tile_ms;
    /* Count box and primitive tests, see pen_trace_count_ops_get. The film stays the same, and the
     * counts do not depend on the number of threads, the tile size or the instruction set. Counting
     * takes time: measure times in another run. */
    bool count_tests;
};

/* Renders a task, and returns when its tiles are done. Threads: one task at a time per pool; the
 * calling thread only waits. Fails: PEN_CANCELLED (the pixels of tiles that tile_done was called
 * for are valid, and *stats covers the work done), PEN_NO_MEMORY, PEN_INTERNAL (the image does not
 * have these tiles). */
bool pen_render_run(struct pen_thread_pool *pool, const struct pen_render_task *task,
                    struct pen_render_stats *stats, struct pen_status *st);

/* Renders all rounds of a view with a target error, from a state that is new or one that an earlier
 * render has kept, and leaves the last state to the caller; as pen_render_run, which does the same
 * without a state. Fails: PEN_CONFLICT: the rounds to be repeated are not of this scene and these
 * settings; PEN_UNAVAILABLE: `paused` has ended it. */
bool pen_render_rounds(struct pen_thread_pool *pool, const struct pen_render_task *task,
                       struct pen_adaptive *adaptive, struct pen_render_stats *stats,
                       struct pen_status *st);

/* Roughly the share of its rays that a render with a target error has traced, from 0 to 0.99: told
 * by the error after a round, which falls about as n^-(5/8) with n rays, and in a round by the
 * tiles that are done, as if it made half as many rays again. 0 in the first round. */
double pen_adaptive_share(const struct pen_adaptive_stats *adaptive, int tiles);

/* Renders one pixel on the calling thread, to inspect it. rgb has the doubles that the film is
 * rounded from; *rays counts its rays. Fails: PEN_NO_MEMORY. */
bool pen_render_pixel(const struct pen_scene *scene, int view, const struct pen_settings *settings,
                      int x, int y, double rgb[3], struct pen_ray_counts *rays,
                      struct pen_status *st);

/* The same with a target error: renders all samples again that a state has of the pixel. */
bool pen_render_refined_pixel(const struct pen_scene *scene, int view,
                              const struct pen_adaptive *adaptive, int x, int y, double rgb[3],
                              struct pen_ray_counts *rays, struct pen_status *st);

/* Whether small or bright things may be unseen; then writes a warning that says in how many pixels.
 */
bool pen_unproven_warning(const struct pen_adaptive_stats *adaptive, char *text, size_t bytes);

/* Whether samples were dropped; then writes a warning that says how many, what became of their
 * pixels and what to do. */
bool pen_dropped_warning(const struct pen_ray_counts *rays, char *text, size_t bytes);

#endif
