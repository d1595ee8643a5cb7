/* SPDX-License-Identifier: MIT */
/* Renders the pixels of a scene with given settings. The threads of a pool take tiles, and share
 * the last ones. Every pixel is a pure function of its position, so the result has the same bits
 * for any number of threads and any tile size. */
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

/* The number of tiles of an image. They are numbered row by row from the top left; those at the
 * right and bottom edges may be smaller. */
int pen_tile_count(int width, int height, int tile);
struct pen_rect pen_tile_rect(int width, int height, int tile, int index);

/* A round of an adaptive render. */
struct pen_round {
    int level; /* pen_adaptive_select; 0 for the pilot */
    int tiles; /* finished tiles, from the first on; not all if the deadline ended the round, or in
                  the current round */
    uint64_t pixels;         /* selected to be refined */
    double error, low, high; /* of the picture after it, estimated */
};
enum { PEN_ROUNDS_MAX = 64 };

struct pen_adaptive_stats {
    double target;
    bool met;
    bool timed; /* the render had a deadline */
    bool ended; /* no round follows */
    int rounds; /* number of decided rounds; 0 after a render: it was not adaptive */
    /* The entry after the decided rounds is the current round. */
    struct pen_round round[PEN_ROUNDS_MAX];
    uint64_t capped; /* pixels that max_samples excluded from refinement */
    double unproven; /* of the last decision: see struct pen_decision */
    struct pen_sample_spread samples;
};

struct pen_render_stats {
    double render_ms; /* from the start of the first tile to the end of the last */
    double cpu_ms;    /* processor time of the render threads, including rows_done */
    double thread_ms; /* from the call to each thread's return, summed over the threads; exceeds
                         cpu_ms if they waited for a processor or for each other */
    int64_t done_ns;  /* pen_clock_ns() at the end of the last tile */
    int threads;      /* threads that took part: at most the number of blocks of pixels */
    int float_resets; /* threads whose floating-point state was not the default; expected 0 */
    struct pen_ray_counts rays;
    bool tests_counted; /* as requested by the task */
    /* Of all rays; divided by the sum of `rays`, these are the tests per ray. */
    struct pen_test_counts tests;
    uint32_t tile_count;
    double *tile_ms; /* tile_count values: the time of each tile, summed over the threads that
                        shared it; NULL if the task does not request it, or failed. Owns: the caller
                        frees it with free(). */
    const char *kernel;
    unsigned effects;
    struct pen_adaptive_stats adaptive;
};

/* Reports that the upper `rows` rows of the image are finished. */
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
    /* Called from a render thread each time more rows are finished, with increasing numbers, the
     * last time with all rows. One call at a time, while the other threads continue to render. The
     * task must have all tiles of the image. May be NULL. */
    pen_render_rows_fn *rows_done;
    void *rows_user;
    /* Called for each pixel, before the block of pixels that contains it, from the render thread
     * with number `thread`, from 0 on; may be NULL. It lets a caller follow the progress, and must
     * not affect the picture. */
    void (*pixel_begins)(void *user, int thread, int x, int y);
    void *pixel_user;
    bool pixel_by_pixel; /* renders no blocks: pixel_begins is called just before its pixel */
    /* With a target error: renders only the next round of this state, for the pixels that it wants.
     * NULL: all rounds, which needs all tiles. Then tile_done and rows_done are called after the
     * last round, and round_done after each, from the calling thread. */
    struct pen_adaptive *adaptive;
    void (*round_done)(void *user, const struct pen_round *round); /* may be NULL */
    /* Called before each tile but the first, from a render thread, one call at a time; may be NULL.
     * When it returns true, no more tiles are begun, and those begun are finished. Then
     * stats->tile_count is their number. If all rounds are rendered, `paused` is called. */
    bool (*pause)(void *user);
    /* Called from the calling thread between two rounds, and after `pause` has stopped a round; may
     * be NULL. It gets all data rendered so far, which it may save (render/adaptive_state.h).
     * Returns whether to continue. */
    bool (*paused)(void *user, const struct pen_adaptive *adaptive,
                   const struct pen_render_stats *stats);
    void *pause_user; /* of both */
    /* The statistics that an earlier render passed to `paused` with the state `adaptive`; NULL: the
     * state is new. */
    const struct pen_render_stats *earlier;
    /* The time of pen_clock_ns by which rounds end, except the first, which is always complete; 0:
     * they end when the target is met. With a deadline, the picture depends on the machine and its
     * load. */
    int64_t deadline_ns;
    /* Repeats these rounds, recorded by an earlier render, instead of deciding on new ones. The
     * picture gets the same bytes. */
    const struct pen_adaptive_stats *repeat;
    bool keep_tile_ms;
    /* Count box and primitive tests, see pen_trace_count_ops_get. The film stays the same. The
     * counts do not depend on the number of threads, the tile size or the instruction set. Counting
     * takes time: measure times in another run. */
    bool count_tests;
};

/* Renders a task, and returns when its tiles are done.
 * Threads: one task at a time per pool; the calling thread only waits.
 * Fails: PEN_CANCELLED (pixels of tiles for which tile_done was called are valid, and *stats covers
 * the work done), PEN_NO_MEMORY, PEN_INTERNAL (the image does not have these tiles). */
bool pen_render_run(struct pen_thread_pool *pool, const struct pen_render_task *task,
                    struct pen_render_stats *stats, struct pen_status *st);

/* Renders all rounds of a view with a target error, as pen_render_run. It starts from a state that
 * is new or saved by an earlier render, and leaves the last state to the caller.
 * Fails: as pen_render_run; PEN_CONFLICT: the rounds to repeat are not of this scene and these
 * settings; PEN_UNAVAILABLE: `paused` has ended it. */
bool pen_render_rounds(struct pen_thread_pool *pool, const struct pen_render_task *task,
                       struct pen_adaptive *adaptive, struct pen_render_stats *stats,
                       struct pen_status *st);

/* The approximate share of its rays that a render with a target error has traced, from 0 to 0.99; 0
 * in the first round. After a round it follows from the error, which falls about as n^-(5/8) with n
 * rays. In a round it follows from the finished tiles, as if the round added half as many rays
 * again. */
double pen_adaptive_share(const struct pen_adaptive_stats *adaptive, int tiles);

/* Renders one pixel on the calling thread, for inspection. rgb has the doubles before the film
 * rounds them; *rays counts its rays.
 * Fails: PEN_NO_MEMORY. */
bool pen_render_pixel(const struct pen_scene *scene, int view, const struct pen_settings *settings,
                      int x, int y, double rgb[3], struct pen_ray_counts *rays,
                      struct pen_status *st);

/* The same with a target error: renders again all samples of the pixel that a state has. */
bool pen_render_refined_pixel(const struct pen_scene *scene, int view,
                              const struct pen_adaptive *adaptive, int x, int y, double rgb[3],
                              struct pen_ray_counts *rays, struct pen_status *st);

/* Whether small or bright things may be unseen. If so, writes a warning with the number of pixels.
 */
bool pen_unproven_warning(const struct pen_adaptive_stats *adaptive, char *text, size_t bytes);

/* Whether samples were dropped. If so, writes a warning with their number, the effect on their
 * pixels and a remedy. */
bool pen_dropped_warning(const struct pen_ray_counts *rays, char *text, size_t bytes);

#endif
