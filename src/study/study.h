/* SPDX-License-Identifier: MIT */
/* The interface that all kinds of studies share: their input, their saved state, and the metrics of
 * pictures.
 *
 * The caller may save a study between two runs. Another process can then resume the study. The
 * saved state is one JSON document, which has the raw rows of the report, and pictures.
 *
 * Pictures are saved, because to render them again costs too much. The reference is the most
 * expensive render of an accuracy study. A study that is often interrupted would not advance if it
 * first had to repeat a pass. A picture is saved uncompressed, since noise does not compress. The
 * caller writes a picture again only if its hash has changed, which is rare. The size check of a
 * study limits the pixels of all pictures together (pen_accuracy_check, pen_bill_check).
 *
 * A study is resumed only on the same host and with the same build. So no report mixes times of two
 * hosts or builds. */
#ifndef PEN_STUDY_STUDY_H
#define PEN_STUDY_STUDY_H

#include <jansson.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "render/render.h"

/* A picture of a study. */
struct pen_study_picture {
    const float *rgb; /* NULL: no picture, or not rendered yet */
    uint64_t hash;    /* pen_film_hash */
};

enum { PEN_STUDY_PICTURES_MAX = 66 };

/* The state of an unfinished study, for the caller to save. Everything is borrowed for the time of
 * the call. */
struct pen_unfinished {
    int done; /* finished runs */
    const void *study;
    /* Makes the document.
     * Owns: the caller json_decref()s.
     * Fails: NULL when out of memory. */
    json_t *(*state)(const void *study);
    int width, height; /* of each picture */
    int picture_count; /* used places of picture[] */
    struct pen_study_picture picture[PEN_STUDY_PICTURES_MAX];
};

/* Called after each run, and between the parts of a long render that is not timed. May save the
 * study. If it returns false, the study ends with PEN_UNAVAILABLE. */
typedef bool pen_between_fn(void *user, const struct pen_unfinished *unfinished);

/* What an earlier process has kept. */
struct pen_kept_study {
    const json_t *state; /* NULL: no state */
    /* Reads the picture that was saved from picture[place]. Returns false if no picture of this
     * size and hash is saved. */
    bool (*picture)(void *user, int place, uint64_t hash, int width, int height, float *rgb);
    void *user;
};

/* The input of every study. Everything is borrowed. */
struct pen_study_frame {
    const struct pen_scene_desc *desc;
    size_t scene_cap_bytes; /* the limit for pen_scene_freeze; 0: none */
    struct pen_thread_pool *pool;
    /* Polled between runs and before each block of pixels. May be NULL. */
    const atomic_bool *cancel;
    /* Called before the first run and after each run. May be NULL. */
    void (*progress)(void *user, int done, int total);
    pen_between_fn *between; /* may be NULL */
    void *user;              /* for both functions */
    /* The state that an earlier process saved. It is ignored if it is damaged, or if study, host or
     * build differ. A process that resumes a study discards the time of its first run. May be NULL.
     */
    const struct pen_kept_study *kept;
    /* As in pen_render_task. May be NULL. */
    void (*pixel_begins)(void *user, int thread, int x, int y);
    void *pixel_user;
};

/* The metrics of the error of a picture. film/metrics.h, ssim.h and flip.h define them. */
enum pen_metric {
    PEN_METRIC_RMSE,
    PEN_METRIC_RELATIVE_MSE,
    PEN_METRIC_PSNR,
    PEN_METRIC_SSIM,
    PEN_METRIC_FLIP, /* the mean over all pixels */
    PEN_METRIC_MAX_ERROR,
    PEN_METRIC_COUNT
};
extern const char *const pen_metrics[PEN_METRIC_COUNT + 1]; /* ends with NULL */

/* Whether larger values of a metric are better: PSNR and SSIM. */
bool pen_metric_rises(enum pen_metric metric);

/* A picture and its reference, of the same settings. */
struct pen_study_pair {
    const struct pen_settings *settings;
    const float *rgb, *reference;
};

/* Compares a picture with its reference by all metrics.
 * Shape: map gets the FLIP error of each pixel, unless it is NULL.
 * Fails: PEN_NO_MEMORY. */
bool pen_study_measure(const struct pen_study_pair *pair, double error[PEN_METRIC_COUNT],
                       float *map, struct pen_status *st);

#endif
