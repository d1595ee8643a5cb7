/* SPDX-License-Identifier: MIT */
/* Audits: an estimate of how many pixels of a picture are wrong. Some of its pixels are rendered
 * again with many more samples.
 *
 * A pixel is wrong if a channel, clamped to [0, 1] and encoded by the transfer function, is off by
 * more than a threshold from the converged value. That is the value of the pixel's area with all
 * sampled effects, at the same max_depth and min_contribution. It is estimated by
 * PEN_AUDIT_REPLICATES independent sequences of samples. A pixel is right if the 99.99 % interval
 * of their mean is within the threshold around the picture's value, wrong if it is outside, else
 * undecided.
 *
 * The pixels are drawn without replacement, by a seed that must depend on the whole picture, so
 * that no renderer can prepare for them. If k of n pixels are wrong or undecided, then with 95 %
 * confidence at most a share p of all pixels is wrong. This p is the largest share for which k or
 * fewer of n have a probability of 5 % (Clopper and Pearson, Biometrika 26, 1934). */
#ifndef PEN_RENDER_AUDIT_H
#define PEN_RENDER_AUDIT_H

#include <stdatomic.h>
#include <stdint.h>

#include "base/status.h"
#include "base/thread_pool.h"
#include "math/rect.h"
#include "render/adaptive.h"
#include "scene/scene.h"

#define PEN_AUDIT_THRESHOLD 0.01 /* the default */

enum {
    PEN_AUDIT_REPLICATES = 8,
    PEN_AUDIT_TIMES = 64,     /* times the samples of the picture, and */
    PEN_AUDIT_LEAST = 1024,   /* at least this number */
    PEN_AUDIT_FOREIGN = 4096, /* if the picture's number of samples is unknown */
    PEN_AUDIT_PIXELS = 600,   /* the default; if none of them is wrong, the bound is 0.5 % */
    PEN_AUDIT_PIXELS_MAX = 1000000,
    PEN_AUDIT_CELLS_SIDE = 16, /* cells of a row and of a column, which locate wrong pixels */
    PEN_AUDIT_CELLS = PEN_AUDIT_CELLS_SIDE * PEN_AUDIT_CELLS_SIDE,
    PEN_AUDIT_CLUSTERS = 5 /* the most that an audit lists */
};

/* A part of the picture: the number of its audited pixels that are wrong, and their bounds if there
 * are any. */
struct pen_audit_cell {
    uint32_t wrong;
    int32_t left, top, right, bottom; /* first and last columns and rows with wrong pixels */
};

/* The judged pixels of an audit, in the order in which they are drawn. */
struct pen_audit_progress {
    uint64_t done, left; /* pixels */
    uint64_t wrong, undecided;
    struct pen_audit_cell cells[PEN_AUDIT_CELLS];
};

/* An audit to run. Everything is borrowed. */
struct pen_audit_task {
    const struct pen_scene *scene;
    int view;
    const struct pen_settings *settings;
    const float *rgb;                    /* the picture, of the size in the settings */
    const struct pen_adaptive *adaptive; /* of a picture with a target error; else NULL */
    int samples;                         /* samples for rendering each pixel again; 0: as above */
    uint64_t pixels;                     /* number to draw; all pixels if the picture has no more */
    double threshold;
    uint64_t seed;
    const atomic_bool *cancel; /* polled before each pixel; may be NULL */
    /* Called before each pixel but the first, from a render thread, one call at a time; may be
     * NULL. When it returns true, no more pixels are begun. */
    bool (*pause)(void *user);
    void *pause_user;
};

/* Wrong pixels near each other: their cells touch. Only audited pixels are known, so other pixels
 * inside and outside the rectangle can be wrong too. */
struct pen_audit_cluster {
    struct pen_rect rect;   /* the bounds of the wrong pixels */
    uint64_t wrong, pixels; /* wrong and audited pixels in the rectangle */
};

struct pen_audit {
    uint64_t pixels, wrong, undecided;
    double threshold;
    /* The share p; for a picture that was audited whole, the share that is not right. */
    double bound;
    uint64_t seed;
    int clusters; /* the largest ones, by number of wrong pixels; undecided pixels do not count */
    struct pen_audit_cluster cluster[PEN_AUDIT_CLUSTERS];
};

/* Runs an audit.
 * Threads: as pen_render_run.
 * Fails: PEN_NO_MEMORY, PEN_CANCELLED. */
bool pen_audit_run(struct pen_thread_pool *pool, const struct pen_audit_task *task,
                   struct pen_audit *audit, struct pen_status *st);

/* Runs an audit in parts: continues after *progress, which is {0} at first, until no pixel is left
 * or there is a pause. Only with no pixel left, *audit is that of all pixels. */
bool pen_audit_continue(struct pen_thread_pool *pool, const struct pen_audit_task *task,
                        struct pen_audit_progress *progress, struct pen_audit *audit,
                        struct pen_status *st);

/* The largest share for which `wrong` or fewer of n pixels have a probability of 5 %. */
double pen_audit_bound(uint64_t wrong, uint64_t pixels);

#endif
