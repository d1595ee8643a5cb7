/* SPDX-License-Identifier: MIT */
/* The benchmark: one scene rendered under several settings, timed, and its pictures compared.
 *
 * Runs are interleaved: one of each row, then again one of each, so that a change of the machine's
 * load meets all rows alike. What is timed is the freezing of the scene, which builds the tree,
 * and the rendering of all views. The warm-up is not counted; box and primitive tests are counted
 * in runs of their own, after all others.
 *
 * Rows whose settings differ in accelerator, threads and tile alone show the same picture, bit for
 * bit; every run of every such row is held against the first, and a benchmark that finds a
 * difference fails. Pictures of other rows are compared with the first row of their size. */
#ifndef PEN_STUDY_BENCH_H
#define PEN_STUDY_BENCH_H

#include <jansson.h>
#include <stdatomic.h>

#include "render/render.h"

/* A combination of settings. */
struct pen_bench_row {
    struct pen_settings settings;
    const json_t *chosen; /* the settings that rows differ in, as a `render` object */
};

/* What one counted run took. */
struct pen_bench_lap {
    double build_ms, render_ms;
    double cpu_ms; /* of the render threads */
};

/* What one row came to. Units: ms. */
struct pen_bench_outcome {
    struct pen_bench_lap *laps;         /* `repeats` of them, in the order of the runs */
    double median_ms, min_ms, max_ms;   /* of build + render */
    double build_ms, render_ms, cpu_ms; /* medians of the parts */
    double speedup;                     /* the baseline's median over this row's */
    struct pen_render_stats stats; /* of the last counted run, all views together; tile_ms of the
                                    * baseline's alone */
    struct pen_accel_stats accel;
    int same_as;                 /* the first row that shows the same picture; may be itself */
    int compared_with;           /* the first row of the same size; may be itself */
    bool identical;              /* to that one, in every bit */
    double max_difference, rmse; /* from that one, of sRGB-encoded values in [0, 1] */
};

struct pen_bench_result {
    struct pen_bench_outcome *rows;
    double load_before, load_after; /* the system's, over a minute; below 0: not known */
    int64_t began_ms, ended_ms;     /* wall clock */
};

/* All that a benchmark needs to know; borrowed for the time of the run. */
struct pen_bench {
    const struct pen_scene_desc *desc;
    const int *views; /* numbers of views of desc */
    int view_count;
    const struct pen_bench_row *rows;
    int row_count, baseline;
    int repeats, warmup; /* at least 1; at least 0 */
    size_t scene_cap_bytes;
    struct pen_thread_pool *pool;
    const atomic_bool *cancel; /* polled between runs and before each pixel; may be NULL */
    /* Called between runs, first of all with done = 0; may be NULL. */
    void (*progress)(void *user, int done, int total);
    void *user;
    /* As in pen_render_task; may be NULL. */
    void (*pixel_begins)(void *user, int thread, int x, int y);
    void *pixel_user;
    /* For tests: may change a picture before it is looked at. May be NULL. */
    void (*tamper)(void *user, int row, int view, float *rgb);
};

/* Runs that a benchmark makes, all kinds together. */
int pen_bench_runs(const struct pen_bench *bench);

/* Pixels of the pictures that it keeps to compare others with. */
double pen_bench_kept_pixels(const struct pen_bench *bench);

/* Runs it. Owns: *result, in any case; release it. Fails: PEN_DIFFERENT (which rows, view, pixel,
 * channel and values), PEN_CANCELLED, PEN_NO_MEMORY; as pen_scene_freeze.
 * Threads: one benchmark per pool, and nothing else on it. */
bool pen_bench_run(const struct pen_bench *bench, struct pen_bench_result *result,
                   struct pen_status *st);
void pen_bench_result_release(const struct pen_bench *bench, struct pen_bench_result *result);

/* The report of a benchmark as JSON (api/openapi.yaml, schema Report). `head` has what the
 * benchmark does not know, such as the scene's name; its members come first. Takes the reference to
 * it. Fails: NULL when out of memory. */
json_t *pen_bench_report(const struct pen_bench *bench, const struct pen_bench_result *result,
                         json_t *head);

#endif
