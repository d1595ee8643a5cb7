/* SPDX-License-Identifier: MIT */
/* What the steps of an accuracy study share: its state, and one run. */
#ifndef PEN_STUDY_INTERNAL_ACCURACY_RUN_H
#define PEN_STUDY_INTERNAL_ACCURACY_RUN_H

#include "study/accuracy.h"

/* A study that is being made. */
struct pen_accuracy_state {
    const struct pen_accuracy_task *task;
    struct pen_accuracy *out;
    struct pen_scene *scene;
    size_t values; /* of a picture: 3 * width * height */
    float *target; /* to render into: so many values */
    int64_t begun_ns;
    int done, total; /* runs */
};

/* The time that is left of the budget, which may be below 0. Units: ms. */
double pen_accuracy_left_ms(const struct pen_accuracy_state *state);

/* Renders the view into rgb, and counts a run. *stats has no times of tiles unless they are asked
 * for. Fails: PEN_CANCELLED, PEN_NO_MEMORY. */
bool pen_accuracy_render(struct pen_accuracy_state *state, const struct pen_settings *settings,
                         float *rgb, bool tile_ms, struct pen_render_stats *stats,
                         struct pen_status *st);

/* Compares a picture with the reference by all metrics. Fails: PEN_NO_MEMORY. */
bool pen_accuracy_measure(const struct pen_accuracy_state *state, const float *rgb,
                          double error[PEN_METRIC_COUNT], struct pen_status *st);

/* Makes the reference, and sets the errors of all rows' first runs. Fails: PEN_CANCELLED,
 * PEN_NO_MEMORY. */
bool pen_accuracy_make_reference(struct pen_accuracy_state *state, struct pen_status *st);

/* Adds a sentence about what was left out. Takes the reference to `text`. Fails: PEN_NO_MEMORY. */
bool pen_accuracy_left_out(struct pen_accuracy *accuracy, json_t *text, struct pen_status *st);

#endif
