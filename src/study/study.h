/* SPDX-License-Identifier: MIT */
/* What all studies have in common: what they are told, what they measure of pictures, and what is
 * kept of one that is not finished.
 *
 * Its caller keeps a study between two runs, so that another process goes on where this one ended.
 * What is kept is one document of JSON, the raw rows of the report, and pictures.
 *
 * Pictures are kept, and not rendered again, for two reasons. The reference of an accuracy study is
 * the dearest of all, and a study that is interrupted again and again would come no further if it
 * first had to repeat a pass. Each is kept once, as it is: noise does not compress, and a picture
 * changes seldom or never, so the caller writes it only when its hash is another. Together they
 * have no more pixels than the check of a study's size allows (pen_accuracy_check, pen_bill_check).
 *
 * Only a process of the same host and build goes on, so no report mixes the times of two. */
#ifndef PEN_STUDY_STUDY_H
#define PEN_STUDY_STUDY_H

#include <jansson.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "render/render.h"

struct pen_study_picture {
    const float *rgb; /* NULL: there is none, or none yet */
    uint64_t hash;    /* pen_film_hash */
};

enum { PEN_STUDY_PICTURES_MAX = 66 };

/* What is to be kept. Everything is borrowed, for the time of the call. */
struct pen_unfinished {
    int done; /* runs */
    const void *study;
    /* The document. Owns: the caller json_decref()s. Fails: NULL when out of memory. */
    json_t *(*state)(const void *study);
    int width, height; /* of all pictures */
    int picture_count; /* places in picture[] */
    struct pen_study_picture picture[PEN_STUDY_PICTURES_MAX];
};

/* Called after each run, and in long renders that are not timed: may keep the study. Returns
 * whether it goes on; else it ends with PEN_UNAVAILABLE. */
typedef bool pen_between_fn(void *user, const struct pen_unfinished *unfinished);

/* What an earlier process has kept. */
struct pen_kept_study {
    const json_t *state; /* NULL: nothing */
    /* Reads the picture at a place, as it was in picture[]. Returns false if there is none of this
     * size and hash. */
    bool (*picture)(void *user, int place, uint64_t hash, int width, int height, float *rgb);
    void *user;
};

/* What every study is told; everything is borrowed. */
struct pen_study_frame {
    const struct pen_scene_desc *desc;
    size_t scene_cap_bytes; /* as pen_scene_freeze; 0: none */
    struct pen_thread_pool *pool;
    /* Polled between runs and before each block of pixels; may be NULL. */
    const atomic_bool *cancel;
    /* Called between runs, with done = 0 before the first; may be NULL. */
    void (*progress)(void *user, int done, int total);
    pen_between_fn *between; /* may be NULL */
    void *user;              /* of both */
    /* What an earlier process has kept; it is not used if it is of another study, host or build, or
     * damaged. May be NULL. A process that goes on throws its first run away. */
    const struct pen_kept_study *kept;
    /* As in pen_render_task; may be NULL. */
    void (*pixel_begins)(void *user, int thread, int x, int y);
    void *pixel_user;
};

/* How far a picture is from another: see film/metrics.h, ssim.h, flip.h. */
enum pen_metric {
    PEN_METRIC_RMSE,
    PEN_METRIC_RELATIVE_MSE,
    PEN_METRIC_PSNR,
    PEN_METRIC_SSIM,
    PEN_METRIC_FLIP, /* the mean */
    PEN_METRIC_MAX_ERROR,
    PEN_METRIC_COUNT
};
extern const char *const pen_metrics[PEN_METRIC_COUNT + 1]; /* ends with NULL */

/* Whether more of it is better: PSNR and SSIM. */
bool pen_metric_rises(enum pen_metric metric);

/* A picture, and the one that it is compared with, of the same settings. */
struct pen_study_pair {
    const struct pen_settings *settings;
    const float *rgb, *reference;
};

/* Compares them by all metrics. Shape: map, unless it is NULL, gets FLIP's error of each pixel.
 * Fails: PEN_NO_MEMORY. */
bool pen_study_measure(const struct pen_study_pair *pair, double error[PEN_METRIC_COUNT],
                       float *map, struct pen_status *st);

#endif
