/* SPDX-License-Identifier: MIT */
/* What the steps of an accuracy study share: its state, and one run. */
#ifndef PEN_STUDY_INTERNAL_ACCURACY_RUN_H
#define PEN_STUDY_INTERNAL_ACCURACY_RUN_H

#include "study/accuracy.h"
#include "study/internal/making.h"

/* The most times the samples of the longest row that a reference may have. */
enum { PEN_ACCURACY_FACTOR_MAX = 128 };

/* A study that is being made. */
struct pen_accuracy_state {
    struct pen_making making;
    const struct pen_accuracy_task *task;
    struct pen_accuracy *out;
    struct pen_scene *scene;
    size_t values;          /* of a picture: 3 * width * height */
    float *target;          /* to render into: so many values */
    struct pen_run_use use; /* of the last render */
    /* Of the reference: its whole renders, 0 to 2, and the finished tiles of the one after these.
     * The first is rendered into the reference's rgb, the second into target; when it is whole, the
     * reference's rgb is the mean. */
    int halves, tiles;
    uint64_t half_hash[2]; /* of what these pictures have, once there are halves or tiles */
    int pass;  /* the further one that is being made; 0: the reference is not finished */
    int place; /* the rows that it has visited */
};

extern const struct pen_kept_shape pen_accuracy_shape;

/* The time that is left of the budget, which may be below 0. Units: ms. */
double pen_accuracy_left_ms(const struct pen_accuracy_state *state);

/* Renders tiles of the view: the task has settings, tiles and rgb. Sets state->use. Fails:
 * PEN_CANCELLED, PEN_NO_MEMORY. */
bool pen_accuracy_render(struct pen_accuracy_state *state, struct pen_render_task *render,
                         struct pen_render_stats *stats, struct pen_status *st);

/* pen_film_hash of a picture. */
uint64_t pen_accuracy_hash(const struct pen_accuracy_state *state, const float *rgb);

/* Forecasts all rows, and chooses those that fit the budget. Fails: as pen_forecast_make. */
bool pen_accuracy_plan(struct pen_accuracy_state *state, struct pen_status *st);

/* Sets the errors of a run, whose picture this is. Fails: PEN_NO_MEMORY. */
bool pen_accuracy_measure(const struct pen_accuracy_state *state, const float *rgb,
                          struct pen_accuracy_run *run, struct pen_status *st);

/* Makes the reference, or what an earlier process has left of it, and sets the errors of all rows'
 * first runs. Fails: PEN_CANCELLED, PEN_UNAVAILABLE, PEN_NO_MEMORY. */
bool pen_accuracy_make_reference(struct pen_accuracy_state *state, struct pen_status *st);

/* Adds "ROW: WHY" to what was left out. Fails: PEN_NO_MEMORY. */
bool pen_accuracy_leave_out(struct pen_accuracy_state *state, int row, const char *why,
                            struct pen_status *st);

/* Adds a sentence about what was left out. Takes the reference to `text`. Fails: PEN_NO_MEMORY. */
bool pen_accuracy_left_out(struct pen_accuracy *accuracy, json_t *text, struct pen_status *st);

#endif
