/* SPDX-License-Identifier: MIT */
/* A study that is not finished, as its caller keeps it between two runs, so that another process
 * goes on where this one ended: a small state as JSON, and pictures.
 *
 * Pictures are kept, and not rendered again, for two reasons. The reference of an accuracy study is
 * the dearest of all, and a study that is interrupted again and again would come no further if it
 * first had to repeat a pass. Each is kept once, as it is: noise does not compress, and a picture
 * changes seldom or never, so the caller writes it only when its hash is another. Together they
 * have no more pixels than the check of a study's size allows (pen_accuracy_check, pen_bill_check).
 *
 * Only a process of the same host and build goes on, so no report mixes the times of two. */
#ifndef PEN_STUDY_UNFINISHED_H
#define PEN_STUDY_UNFINISHED_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

struct pen_study_picture {
    const float *rgb; /* NULL: there is none, or none yet */
    uint64_t hash;    /* pen_film_hash */
};

enum { PEN_STUDY_PICTURES_MAX = 66 };

/* What is to be kept. Everything is borrowed, for the time of the call. */
struct pen_unfinished {
    int done; /* runs */
    const void *study;
    /* The state. Owns: the caller json_decref()s. Fails: NULL when out of memory. */
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
    const json_t *state;
    /* Reads the picture at a place, as it was in picture[]. Returns false if there is none of this
     * size and hash. */
    bool (*picture)(void *user, int place, uint64_t hash, int width, int height, float *rgb);
    void *user;
};

#endif
