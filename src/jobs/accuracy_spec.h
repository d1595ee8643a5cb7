/* SPDX-License-Identifier: MIT */
/* The spec of an accuracy study, as a job or a command line gives it: the members `ladder`,
 * `product`, `reference`, `target`, `seeds` and `budget_seconds`, checked, and the rows that the
 * ladder makes.
 *
 * The ladder's keys are render settings, each with a list of values. The first row has the settings
 * as they are, unless they are a value of the only key. Each further row changes one key to one of
 * its values; with `product` the rows are all combinations of the values instead, the last key
 * changing fastest. Without a ladder it has each kind of samples that the scene calls for, and
 * samples_per_pixel. */
#ifndef PEN_JOBS_ACCURACY_SPEC_H
#define PEN_JOBS_ACCURACY_SPEC_H

#include "io/scene_json.h"
#include "study/accuracy.h"

enum { PEN_ACCURACY_BUDGET_MAX_S = 86400 };

struct pen_accuracy_spec {
    json_t *ladder;
    bool product;
    json_t *reference; /* NULL: none */
    enum pen_metric metric;
    double target;
    int seeds;
    double budget_s;
    int row_count;
    struct pen_accuracy_row *rows;
};

/* Reads the members of an object, which may have others. `desc` is the scene, for a study without a
 * ladder, or NULL if it has errors; `base` its settings, of which a target_error counts in the
 * ladder alone. All errors are collected, each with its place, such as /ladder/light_samples/2.
 * Owns: release *spec, after success and failure alike. Fails: errors->count grows. */
bool pen_accuracy_spec_read(const json_t *members, const struct pen_scene_desc *desc,
                            const struct pen_settings *base, struct pen_accuracy_spec *spec,
                            struct pen_errors *errors);
void pen_accuracy_spec_release(struct pen_accuracy_spec *spec);

/* Adds the members to an object, with all defaults filled in. Takes the reference to it. Fails:
 * NULL when out of memory. */
json_t *pen_accuracy_spec_members(const struct pen_accuracy_spec *spec, json_t *object);

/* A task with what a spec says. Owns: the rows stay the spec's. */
struct pen_accuracy_task pen_accuracy_of_spec(const struct pen_accuracy_spec *spec);

#endif
