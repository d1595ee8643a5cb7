/* SPDX-License-Identifier: MIT */
/* Interrupted studies, and what they keep, in memory. */
#ifndef TESTS_SUPPORT_UNFINISHED_H
#define TESTS_SUPPORT_UNFINISHED_H

#include "study/study.h"

/* Initialise with zeros. */
struct unfinished_bed {
    int runs_left; /* until the study is interrupted; 0: never */
    int calls;     /* of unfinished_keep */
    json_t *state;
    int width, height;
    float *picture[PEN_STUDY_PICTURES_MAX];
    struct pen_kept_study kept; /* what is kept, after the first time */
};

/* pen_between_fn; `user` is the bed. */
bool unfinished_keep(void *user, const struct pen_unfinished *unfinished);

void unfinished_release(struct unfinished_bed *bed);

/* Returns a copy of a state with another value, JSON, at a JSON pointer; the caller calls
 * json_decref(). */
json_t *unfinished_changed(const json_t *state, const char *pointer, const char *value);

#endif
