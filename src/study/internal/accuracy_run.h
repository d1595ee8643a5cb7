/* SPDX-License-Identifier: MIT */
/* The state that the steps of an accuracy study share, and the functions for one run. */
#ifndef PEN_STUDY_INTERNAL_ACCURACY_RUN_H
#define PEN_STUDY_INTERNAL_ACCURACY_RUN_H

#include "study/accuracy.h"
#include "study/internal/making.h"

/* The greatest factor between the samples of the reference and those of the longest row. */
enum { PEN_ACCURACY_FACTOR_MAX = 128 };

/* A study in progress. */
struct pen_accuracy_state {
    struct pen_making making;
    const struct pen_accuracy_task *task;
    struct pen_accuracy *out;
    struct pen_scene *scene;
    size_t values;          /* number of values of a picture: 3 * width * height */
    float *target;          /* buffer of one picture, for renders that are not kept */
    struct pen_run_use use; /* of the last render */
    /* Progress of the reference. `halves` is the number of its finished renders, 0 to 2. `tiles` is
     * the number of finished tiles of the next one. The first render goes to the reference's rgb,
     * and the second to `target`. When both are finished, the reference's rgb becomes their mean.
     */
    int halves, tiles;
    uint64_t half_hash[2]; /* hashes of these pictures, once they have tiles */
    int pass;  /* the current pass; 0: the first pass, or the reference is not finished */
    int place; /* rows that the current pass has visited */
};

extern const struct pen_kept_shape pen_accuracy_shape;

/* The time until the budget ends; below 0 after its end.
 * Units: ms. */
double pen_accuracy_left_ms(const struct pen_accuracy_state *state);

/* Renders tiles of the view. The caller sets settings, tiles and rgb of the task. Sets state->use.
 * Fails: PEN_CANCELLED, PEN_NO_MEMORY. */
bool pen_accuracy_render(struct pen_accuracy_state *state, struct pen_render_task *render,
                         struct pen_render_stats *stats, struct pen_status *st);

/* pen_film_hash of a picture. */
uint64_t pen_accuracy_hash(const struct pen_accuracy_state *state, const float *rgb);

/* Forecasts all rows, and chooses the rows that fit the budget.
 * Fails: as pen_forecast_make. */
bool pen_accuracy_plan(struct pen_accuracy_state *state, struct pen_status *st);

/* Sets the errors of a run from its picture.
 * Fails: PEN_NO_MEMORY. */
bool pen_accuracy_measure(const struct pen_accuracy_state *state, const float *rgb,
                          struct pen_accuracy_run *run, struct pen_status *st);

/* Makes the reference, or finishes one that an earlier process began. Sets the errors of the first
 * runs of all rows.
 * Fails: PEN_CANCELLED, PEN_UNAVAILABLE, PEN_NO_MEMORY. */
bool pen_accuracy_make_reference(struct pen_accuracy_state *state, struct pen_status *st);

/* Adds "ROW: WHY" to the list of what was left out.
 * Fails: PEN_NO_MEMORY. */
bool pen_accuracy_leave_out(struct pen_accuracy_state *state, int row, const char *why,
                            struct pen_status *st);

/* Adds a sentence to the list of what was left out.
 * Owns: takes the reference to `text`.
 * Fails: PEN_NO_MEMORY. */
bool pen_accuracy_left_out(struct pen_accuracy *accuracy, json_t *text, struct pen_status *st);

#endif
