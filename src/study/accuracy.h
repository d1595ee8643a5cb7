/* SPDX-License-Identifier: MIT */
/* The accuracy study: what a picture's accuracy costs in time, on one scene.
 *
 * A row is one combination of settings. Every row is rendered with several seeds, and each picture
 * is compared with a reference, so that the report can set time against error: which rows are on
 * the Pareto front, how fast the error falls with the number of samples, and which row is the
 * cheapest that meets a target.
 *
 * The study goes in these steps, within its budget of time:
 *
 * 1. A forecast of every row's time. Rows that do not fit the budget are left out, the dearest
 *    first.
 * 2. A pass: every row once, with one seed, in a random order.
 * 3. The reference: two renders with several times the samples of the longest row and with seeds
 *    that no row has. Their mean is the reference, half of their difference its error: the two are
 *    independent, so the mean's variance is a quarter of that of their difference. If the error is
 *    more than a fifth of the best row's, the reference is made again with more samples.
 * 4. Passes with further seeds, each in a random order of its own. What does not fit the budget is
 *    left out; the rows of the Pareto front come first then.
 *
 * A run that is spoiled (run_time.h) is repeated, twice at most and if a repeat takes no more than
 * a quarter of the time that is left. If it stays spoiled, its error counts, and its time does not.
 * If over half of the runs are spoiled, no row is recommended.
 *
 * A row whose error is less than twice that of the reference is unresolved: the reference cannot
 * tell how far off it is. The error of the reference is that of sampling alone; a reference is cut
 * off by max_depth and min_contribution as every picture is. */
#ifndef PEN_STUDY_ACCURACY_H
#define PEN_STUDY_ACCURACY_H

#include <jansson.h>

#include "base/buf.h"
#include "io/scene_json.h"
#include "study/run_time.h"
#include "study/study.h"

struct pen_accuracy_row {
    struct pen_settings settings;
    const json_t *varied; /* the row's values of the settings that rows differ in: a `render` object
                           * with the same keys in every row */
};

/* One picture of a row. */
struct pen_accuracy_run {
    struct pen_run_time time;
    double error[PEN_METRIC_COUNT];
};

struct pen_accuracy_row_result {
    bool wanted; /* it is not left out */
    int runs;    /* made; 0: the row was left out */
    int next;    /* the row in this place of the pass that is being made */
    struct pen_accuracy_run *run;
    double expected_ms; /* of one run, as the forecast had it */
    struct pen_ray_counts rays;
    int threads;           /* that worked on the first run */
    uint64_t picture_hash; /* of the picture of the first run: pen_film_hash */
    float *rgb;            /* that picture */
};

struct pen_accuracy_reference {
    struct pen_settings settings;
    int factor;       /* its samples over those of the longest row, unless they are given */
    double error;     /* RMSE, estimated */
    double render_ms; /* of both renders */
    float *rgb;
};

/* What the whole study is expected to take. Units: ms. */
struct pen_accuracy_forecast {
    double expected_ms, low_ms, high_ms;
};

/* What to do; everything is borrowed. */
struct pen_accuracy_task {
    struct pen_study_frame frame;
    const struct pen_settings *settings;
    int view;
    const struct pen_accuracy_row *rows;
    int row_count;
    const json_t *reference; /* settings of the reference, a `render` object; NULL: none is given */
    enum pen_metric metric;  /* of the target */
    double target;
    int seeds; /* runs of each row; at least 1 */
    double budget_ms;
    struct pen_limits limits;
    /* Called once, after step 1, with frame.user; may be NULL. */
    void (*forecast)(void *user, const struct pen_accuracy_forecast *forecast);
    /* How long the reference is rendered between two calls of frame.between, as it is expected; 0:
     * 5 s. */
    double at_once_ms;
};

enum { PEN_ACCURACY_ROWS_MAX = 64, PEN_ACCURACY_SEEDS_MAX = 64 };
_Static_assert((int)PEN_ACCURACY_SEEDS_MAX <= (int)PEN_RUN_TIMES_MAX, "a time for each run");

/* As many runs of the dearest row the reference is expected to take. */
enum { PEN_ACCURACY_REFERENCE_RUNS = 16 };

struct pen_accuracy {
    const struct pen_accuracy_task *task;
    struct pen_accuracy_row_result *row;
    struct pen_accuracy_reference reference;
    struct pen_accuracy_forecast forecast;
    double spent_ms;
    double thread_ms, had_ms; /* of all renders: the time of their threads; in which these had
                               * processors */
    int64_t began_ms;         /* wall clock */
    double calibration_ms; /* the time of a fixed computation, by which hosts can be compared: the
                            * median of several */
    json_t *left_out;      /* sentences, as an array */
    float *cost;           /* the layer `cost` of a row, as colours; NULL: left out */
    int cost_row;          /* the recommended one, or else the first */
    double cost_most;      /* what its white stands for: nanoseconds */
    int stats_row;         /* the first row that is not left out; what its last render has told: */
    struct pen_render_stats stats;
    struct pen_accel_stats accel;
    double build_ms;
};

/* The number of runs of a study: those of the rows, two for the reference, and one for the cost. A
 * reference that is made again does not count. */
int pen_accuracy_runs(const struct pen_accuracy_task *task);

/* Checks each row by pen_limits_check, and the size of the pictures that are kept. Fails:
 * PEN_TOO_LARGE, at the place `at`. */
bool pen_accuracy_check(const struct pen_accuracy_task *task, const char *at,
                        struct pen_status *st);

/* Makes the study. Owns: release *out in any case. Fails: PEN_NO_MEMORY, PEN_CANCELLED,
 * PEN_UNAVAILABLE (`between` has ended it); as pen_scene_freeze. Threads: one study per pool, and
 * nothing else on that pool. */
bool pen_accuracy_make(const struct pen_accuracy_task *task, struct pen_accuracy *out,
                       struct pen_status *st);
void pen_accuracy_release(struct pen_accuracy *accuracy);

/* The report as JSON (api/openapi.yaml, schema AccuracyReport). `scene` is the scene's name. Fails:
 * NULL when out of memory. */
json_t *pen_accuracy_json(const struct pen_accuracy *accuracy, const char *scene);

/* Appends the pictures of the report's page: of the reference, of each row and its error map, and
 * of the time of pixels. `report` is what pen_accuracy_json made. Fails: PEN_NO_MEMORY. */
bool pen_accuracy_figures(const struct pen_accuracy *accuracy, const json_t *report,
                          struct pen_buf *out, struct pen_status *st);

#endif
