/* SPDX-License-Identifier: MIT */
/* The cost of a render, forecast from a sparse pre-render. */
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
    struct pen_estimate time_ms; /* by the clock, if every thread has its own processor */
    double used;                 /* share of time that a thread of the pre-render had a processor */
    double memory_bytes;         /* of scene, film and threads */
    int pixels;                  /* of the pre-render; fewer if it reached its deadline */
    double spent_ms;             /* time of the pre-render */
    const char *kernel;
    unsigned effects;
    /* By primitive number: whether it is the first surface of a pixel of the pre-render, on the
     * pinhole's ray through the pixel's middle. */
    atomic_bool *seen;
};

/* The least number of cells, and the most pixels that a quick forecast renders. */
enum { PEN_FORECAST_CELLS = 4096, PEN_FORECAST_QUICK_PIXELS = PEN_FORECAST_CELLS + 96 * 64 };

/* A forecast to make. Everything is borrowed. */
struct pen_forecast_task {
    const struct pen_scene *scene;
    int view;
    const struct pen_settings *settings;
    bool quick; /* PEN_FORECAST_CELLS cells at most, for any image size */
    /* The end of the pre-render, by pen_clock_ns; 0: when it is done. It always takes some pixels.
     * Pixels that are left out, and samples that are left out of pixels with very many, widen the
     * intervals. */
    int64_t deadline_ns;
    /* As in pen_render_task; may be NULL. */
    const atomic_bool *cancel;
    void (*pixel_begins)(void *user, int thread, int x, int y);
    void *pixel_user;
};

/* Makes a forecast. It renders one pixel in each of max(1 %, 4096) equal parts of the image and
 * counts its rays. Then it renders some blocks, to measure the time of a ray. Rays vary from part
 * to part as from pixel to pixel of neighbouring parts, which gives the intervals. The pixels are
 * the same at each call, unless it reaches its deadline.
 *
 * If a kind of ray is possible, but no rendered pixel has one, as with a small mirror, the upper
 * end of its interval is not 0. By the exact interval of a share (Clopper and Pearson; the "rule of
 * three"), 3.7 / n of the pixels can have one at every depth.
 * Owns: release *out after success.
 * Threads: as pen_render_run.
 * Fails: PEN_NO_MEMORY, PEN_CANCELLED. */
bool pen_forecast_make(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                       struct pen_forecast *out, struct pen_status *st);
void pen_forecast_release(struct pen_forecast *forecast);

#endif
