/* SPDX-License-Identifier: MIT */
/* The accuracy study: the time that accuracy costs, on one scene.
 *
 * A row is one combination of settings. Every row is rendered with several seeds, and each picture
 * is compared with a reference. The report relates time to error. It shows the rows on the Pareto
 * front, how fast the error falls with the number of samples, and the cheapest row that meets a
 * target.
 *
 * The study has these steps, within a time budget:
 *
 * 1. A forecast of the time of every row. Rows that do not fit the budget are left out, the most
 *    expensive first.
 * 2. The first pass: each row once, with one seed, in a random order.
 * 3. The reference: the mean of two renders, with several times the samples of the longest row and
 *    with seeds that no row has. Half of the difference of the two renders is the estimated error.
 *    They are independent, so the variance of their mean is a quarter of the variance of their
 *    difference. If the error is above a fifth of the best row's error, the reference is made again
 *    with more samples.
 * 4. Passes with further seeds, each in its own random order. Runs that do not fit the budget are
 *    left out. If a pass does not fit as a whole, the rows of the Pareto front run first.
 *
 * A spoiled run (run_time.h) is repeated at most twice. It is not repeated if it would take more
 * than a quarter of the remaining time. If it stays spoiled, its error counts and its time does
 * not. If over half of the runs are spoiled, no row is recommended.
 *
 * A row is unresolved if its error is less than twice the error of the reference. Then the
 * reference is too inexact to show the row's error. The error of the reference covers sampling
 * alone. max_depth and min_contribution cut off the paths of the reference, as in every picture. */
#ifndef PEN_STUDY_ACCURACY_H
#define PEN_STUDY_ACCURACY_H

#include <jansson.h>

#include "base/buf.h"
#include "io/scene_json.h"
#include "study/run_time.h"
#include "study/study.h"

/* A combination of settings. */
struct pen_accuracy_row {
    struct pen_settings settings;
    /* The row's values of the settings in which rows differ: a `render` object with the same keys
     * in every row. */
    const json_t *varied;
};

/* One picture of a row. */
struct pen_accuracy_run {
    struct pen_run_time time;
    double error[PEN_METRIC_COUNT];
};

/* The results of one row. */
struct pen_accuracy_row_result {
    bool wanted; /* the row is not left out */
    int runs;    /* finished runs; 0: the row was left out */
    int next;    /* in the i-th element: the row that runs i-th in the current pass */
    struct pen_accuracy_run *run;
    double expected_ms; /* of one run, from the forecast */
    struct pen_ray_counts rays;
    int threads;           /* number of threads that worked on the first run */
    uint64_t picture_hash; /* pen_film_hash of rgb */
    float *rgb;            /* the picture of the first run */
};

/* The reference of a study. */
struct pen_accuracy_reference {
    struct pen_settings settings;
    int factor;   /* samples as a multiple of the longest row's, unless task->reference sets them */
    double error; /* estimated RMSE */
    double render_ms; /* of both renders together */
    float *rgb;
};

/* The expected time of the whole study.
 * Units: ms. */
struct pen_accuracy_forecast {
    double expected_ms, low_ms, high_ms;
};

/* The input of a study. Everything is borrowed. */
struct pen_accuracy_task {
    struct pen_study_frame frame;
    const struct pen_settings *settings;
    int view;
    const struct pen_accuracy_row *rows;
    int row_count;
    const json_t *reference; /* a `render` object with settings of the reference; NULL: none */
    enum pen_metric metric;  /* the metric of `target` */
    double target;
    int seeds; /* runs of each row, each with its own seed; at least 1 */
    double budget_ms;
    struct pen_limits limits;
    /* Called once after step 1, with frame.user. May be NULL. */
    void (*forecast)(void *user, const struct pen_accuracy_forecast *forecast);
    /* The expected time of rendering the reference between two calls of frame.between. 0: 5 s. */
    double at_once_ms;
};

enum { PEN_ACCURACY_ROWS_MAX = 64, PEN_ACCURACY_SEEDS_MAX = 64 };
_Static_assert((int)PEN_ACCURACY_SEEDS_MAX <= (int)PEN_RUN_TIMES_MAX, "a time for each run");

/* The time that the forecast assumes for the reference, in runs of the most expensive row. */
enum { PEN_ACCURACY_REFERENCE_RUNS = 16 };

/* The results of a study. */
struct pen_accuracy {
    const struct pen_accuracy_task *task;
    struct pen_accuracy_row_result *row;
    struct pen_accuracy_reference reference;
    struct pen_accuracy_forecast forecast;
    double spent_ms;
    /* Summed over all renders: the time of their threads, and the part of it in which the threads
     * had a processor. */
    double thread_ms, had_ms;
    int64_t began_ms; /* wall clock */
    /* Median time of a fixed computation, by which hosts are compared (calibration.h). */
    double calibration_ms;
    json_t *left_out; /* an array of sentences */
    float *cost;      /* the layer `cost` of row cost_row as colours; NULL: left out */
    int cost_row;     /* the recommended row, or the first row that has run */
    double cost_most; /* the time that white stands for, in ns */
    int stats_row;    /* the first row that is not left out; `stats` is of its last render */
    struct pen_render_stats stats;
    struct pen_accel_stats accel;
    double build_ms;
};

/* The number of runs of a study: of the rows, two for the reference, and one for the cost layer.
 * Repeats of the reference do not count. */
int pen_accuracy_runs(const struct pen_accuracy_task *task);

/* Checks each row by pen_limits_check, and the total size of the pictures.
 * Fails: PEN_TOO_LARGE, at the place `at`; as pen_limits_check. */
bool pen_accuracy_check(const struct pen_accuracy_task *task, const char *at,
                        struct pen_status *st);

/* Makes the study.
 * Owns: release *out, after success and after failure.
 * Fails: PEN_NO_MEMORY, PEN_CANCELLED, PEN_UNAVAILABLE (frame.between returned false); as
 * pen_scene_freeze.
 * Threads: one study per pool, and nothing else on that pool. */
bool pen_accuracy_make(const struct pen_accuracy_task *task, struct pen_accuracy *out,
                       struct pen_status *st);
void pen_accuracy_release(struct pen_accuracy *accuracy);

/* Makes the report as JSON (api/openapi.yaml, schema AccuracyReport). `scene` is the scene's name.
 * Owns: the caller json_decref()s.
 * Fails: NULL when out of memory. */
json_t *pen_accuracy_json(const struct pen_accuracy *accuracy, const char *scene);

/* Appends the pictures of the report's page: the reference, the picture and error map of each row,
 * and the time of each pixel. `report` is the result of pen_accuracy_json.
 * Fails: PEN_NO_MEMORY. */
bool pen_accuracy_figures(const struct pen_accuracy *accuracy, const json_t *report,
                          struct pen_buf *out, struct pen_status *st);

#endif
