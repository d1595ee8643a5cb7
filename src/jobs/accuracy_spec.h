/* SPDX-License-Identifier: MIT */
/* The spec of an accuracy study, from a job or a command line: the checked members `ladder`,
 * `product`, `reference`, `target`, `seeds` and `budget_seconds`, and the rows that the ladder
 * makes.
 *
 * The ladder's keys are render settings, each with a list of values. The first row has the settings
 * as they are, unless the ladder has a single key whose values include them. Each further row
 * changes one key to one of its values. With `product` the rows are all combinations of the values
 * instead; the last key changes fastest. The default ladder has each kind of samples that the scene
 * calls for, and samples_per_pixel. */
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

/* Reads these members of an object, which may have others. `desc` is the scene, for a study without
 * a ladder; NULL if the scene has errors. `base` is its settings; their target_error counts only in
 * the ladder. All errors are collected, each with its place, such as /ladder/light_samples/2.
 * Owns: release *spec, after success and after failure.
 * Fails: errors->count grows. */
bool pen_accuracy_spec_read(const json_t *members, const struct pen_scene_desc *desc,
                            const struct pen_settings *base, struct pen_accuracy_spec *spec,
                            struct pen_errors *errors);
void pen_accuracy_spec_release(struct pen_accuracy_spec *spec);

/* Adds the members to an object, with all defaults filled in. Takes the reference to the object.
 * Fails: NULL when out of memory. */
json_t *pen_accuracy_spec_members(const struct pen_accuracy_spec *spec, json_t *object);

/* Makes a task from a spec.
 * Owns: the rows stay the spec's. */
struct pen_accuracy_task pen_accuracy_of_spec(const struct pen_accuracy_spec *spec);

#endif
