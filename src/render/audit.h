/* SPDX-License-Identifier: MIT */
/* Audits: how many pixels of a picture are wrong, told by some of them that are rendered again with
 * far more samples.
 *
 * A pixel is wrong if a channel, clamped to [0, 1] and encoded by the transfer function, is off by
 * more than a threshold from the converged value: that of the pixel's area with all sampled
 * effects, at the same max_depth and min_contribution. The value is estimated by
 * PEN_AUDIT_REPLICATES independent sequences of samples. A pixel is right if the 99.99 % interval
 * of their mean lies within the threshold around what the picture shows, wrong if it lies beyond,
 * else undecided.
 *
 * The pixels are drawn without replacement, by a seed that must depend on the whole picture: so
 * nothing could be done for them beforehand. If k of n are wrong or undecided, then with 95 %
 * confidence at most a share p of all pixels is wrong, where p is the largest share with which k or
 * fewer of n would be met with a probability of 5 % (Clopper and Pearson, Biometrika 26, 1934). */
#ifndef PEN_RENDER_AUDIT_H
#define PEN_RENDER_AUDIT_H

#include <stdatomic.h>
#include <stdint.h>

#include "base/status.h"
#include "base/thread_pool.h"
#include "math/rect.h"
#include "render/adaptive.h"
#include "scene/scene.h"

#define PEN_AUDIT_THRESHOLD 0.01 /* unless told otherwise */

enum {
    PEN_AUDIT_REPLICATES = 8,
    PEN_AUDIT_TIMES = 64,     /* as many samples as the picture's own, and */
    PEN_AUDIT_LEAST = 1024,   /* at least so many */
    PEN_AUDIT_FOREIGN = 4096, /* where it is not known how many these are */
    PEN_AUDIT_PIXELS = 600,   /* unless told otherwise: none wrong of them means 0.5 % */
    PEN_AUDIT_PIXELS_MAX = 1000000,
    PEN_AUDIT_CELLS_SIDE =
        16, /* cells of a row and of a column, which tell where pixels are wrong */
    PEN_AUDIT_CELLS = PEN_AUDIT_CELLS_SIDE * PEN_AUDIT_CELLS_SIDE,
    PEN_AUDIT_CLUSTERS = 5 /* the most that are told */
};

/* A part of the picture: how many of its audited pixels are wrong, and if some are, their bounds.
 */
struct pen_audit_cell {
    uint32_t wrong;
    int32_t left, top, right, bottom; /* of the first and last columns and rows that have some */
};

/* The pixels of an audit that were judged, in the order in which they are drawn. */
struct pen_audit_progress {
    uint64_t done, left; /* pixels */
    uint64_t wrong, undecided;
    struct pen_audit_cell cells[PEN_AUDIT_CELLS];
};

/* Everything is borrowed. */
struct pen_audit_task {
    const struct pen_scene *scene;
    int view;
    const struct pen_settings *settings;
    const float *rgb;                    /* the picture, of the size in the settings */
    const struct pen_adaptive *adaptive; /* of a picture with a target error; else NULL */
    int samples;                         /* to render again with, for each pixel; 0: as above */
    uint64_t pixels;                     /* to be drawn; all if there are no more */
    double threshold;
    uint64_t seed;
    const atomic_bool *cancel; /* polled before each pixel; may be NULL */
    /* Asked before each pixel but the first, from a render thread, one call at a time; may be NULL.
     * When it returns true no more pixels are begun. */
    bool (*pause)(void *user);
    void *pause_user;
};

/* Wrong pixels near each other: no further than the cells that have them touch. Only audited
 * pixels are known, so others in the rectangle, and beyond it, can be wrong as well. */
struct pen_audit_cluster {
    struct pen_rect rect;   /* the bounds of the wrong pixels */
    uint64_t wrong, pixels; /* in the rectangle: wrong ones, and audited ones */
};

struct pen_audit {
    uint64_t pixels, wrong, undecided;
    double threshold;
    double
        bound; /* the share p; of a picture that was audited whole, the share that is not right */
    uint64_t seed;
    int clusters; /* the largest ones, by the number of wrong pixels; undecided ones count in none
                   */
    struct pen_audit_cluster cluster[PEN_AUDIT_CLUSTERS];
};

/* Threads: as pen_render_run. Fails: PEN_NO_MEMORY, PEN_CANCELLED. */
bool pen_audit_run(struct pen_thread_pool *pool, const struct pen_audit_task *task,
                   struct pen_audit *audit, struct pen_status *st);

/* The same in parts: goes on after what is done, which is {0} at first, until nothing is left or
 * there is a pause. Only then, with nothing left, *audit is that of all pixels. */
bool pen_audit_continue(struct pen_thread_pool *pool, const struct pen_audit_task *task,
                        struct pen_audit_progress *progress, struct pen_audit *audit,
                        struct pen_status *st);

/* The largest share with which `wrong` or fewer of n pixels are met with a probability of 5 %. */
double pen_audit_bound(uint64_t wrong, uint64_t pixels);

#endif
