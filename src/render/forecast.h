/* SPDX-License-Identifier: MIT */
/* What a render will take, from a sparse pre-render. */
#ifndef PEN_RENDER_FORECAST_H
#define PEN_RENDER_FORECAST_H

#include <stdatomic.h>

#include "base/thread_pool.h"
#include "scene/scene.h"

/* An estimate with its 95 % interval. */
struct pen_estimate {
    double expected, low, high;
};

struct pen_forecast {
    struct pen_estimate primary, shadow, reflection, transmission, total; /* rays */
    struct pen_estimate cpu_ms;  /* processor time of all threads */
    struct pen_estimate time_ms; /* by the clock, if every thread has a processor for itself */
    double used;                 /* the share of its time that a thread of the pre-render had one */
    double memory_bytes;         /* of scene, film and threads */
    int pixels;                  /* of the pre-render; fewer if its deadline has come */
    double spent_ms;             /* on it */
    const char *kernel;
    unsigned effects;
    /* By primitive number: whether it is the first surface of a pixel of the pre-render, seen by
     * the pinhole through the pixel's middle. */
    atomic_bool *seen;
};

/* The least number of cells, and the most pixels that a quick forecast renders. */
enum { PEN_FORECAST_CELLS = 4096, PEN_FORECAST_QUICK_PIXELS = PEN_FORECAST_CELLS + 96 * 64 };

/* What to forecast; everything is borrowed. */
struct pen_forecast_task {
    const struct pen_scene *scene;
    int view;
    const struct pen_settings *settings;
    bool quick; /* PEN_FORECAST_CELLS cells at most, however large the image is */
    /* When it is to end, by pen_clock_ns; 0: when it is done. It takes some pixels at least. Those
     * that are left, and samples that are left out of pixels that have very many, widen the
     * intervals. */
    int64_t deadline_ns;
    /* As in pen_render_task; may be NULL. */
    const atomic_bool *cancel;
    void (*pixel_begins)(void *user, int thread, int x, int y);
    void *pixel_user;
};

/* Where a kind of ray can be met, but no pixel that was rendered has met one, as with a small
 * mirror, the upper end of its interval is not 0: by the exact interval of a share (Clopper and
 * Pearson; the "rule of three"), 3.7 / n of the pixels can meet one at every depth.
 *
 * Renders one pixel in each of max(1 %, 4096) equal parts of the image, and counts its rays; then
 * some blocks, to measure the time of a ray. Rays vary from part to part as from pixel to pixel of
 * neighbouring parts, which gives the intervals; the pixels are the same at each call, unless the
 * deadline comes. Threads: as pen_render_run. Owns: release *out after success. Fails:
 * PEN_NO_MEMORY, PEN_CANCELLED. */
bool pen_forecast_make(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                       struct pen_forecast *out, struct pen_status *st);
void pen_forecast_release(struct pen_forecast *forecast);

#endif
