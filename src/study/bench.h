/* SPDX-License-Identifier: MIT */
/* The benchmark: one scene rendered under several settings, timed, and its pictures compared.
 *
 * A row is one combination of settings. A run freezes the scene, which builds its tree, and renders
 * all views, under the settings of one row; the run's time is the sum of both. Runs come in this
 * order:
 *
 * 1. `warmup` passes over all rows. Their times are thrown away.
 * 2. `repeats` passes over all rows. Their times are kept. As each pass visits every row, a change
 *    of the machine's load meets all rows alike.
 * 3. One run for each set of rows that do the same work, to count box and primitive tests. Its time
 *    is thrown away, because counting takes time.
 *
 * Rows whose settings differ in accelerator, threads and tile alone show the same picture, bit for
 * bit (in fast precision: rows that differ in threads and tile alone). Every run's pictures are
 * compared with the first ones of their kind, and a benchmark that finds a difference fails.
 * Pictures that may differ are measured against those of the first row of their size. */
#ifndef PEN_STUDY_BENCH_H
#define PEN_STUDY_BENCH_H

#include <jansson.h>
#include <stdatomic.h>

#include "render/render.h"

/* A combination of settings. */
struct pen_bench_row {
    struct pen_settings settings;
    const json_t *varied; /* the row's values of the settings that rows differ in: a `render` object
                           * with the same keys in every row */
};

/* The times of one run. */
struct pen_bench_times {
    double build_ms, render_ms;
    double cpu_ms; /* of the render threads */
};

/* The results of one row. Units: ms. */
struct pen_bench_row_result {
    struct pen_bench_times *runs;       /* one for each repeat, in order of time */
    double median_ms, min_ms, max_ms;   /* of build + render */
    double build_ms, render_ms, cpu_ms; /* medians of the parts */
    double speedup;                     /* the baseline's median divided by this row's */
    /* Of the last repeat, all views together; with the tests counted in step 3. tile_ms is that of
     * the baseline alone, NULL in other rows. */
    struct pen_render_stats stats;
    struct pen_accel_stats accel;
    int same_as;                 /* the first row that shows the same picture; may be itself */
    int compared_with;           /* the first row of the same size; may be itself */
    bool identical;              /* to the pictures of compared_with, in every bit */
    double max_difference, rmse; /* from them, of sRGB-encoded values in [0, 1] */
};

struct pen_bench_result {
    struct pen_bench_row_result *rows;
    double load_before, load_after; /* the system's load over a minute; below 0: unknown */
    int64_t began_ms, ended_ms;     /* wall clock */
};

/* What to run. Owns: nothing; everything is borrowed until the benchmark ends. */
struct pen_bench {
    const struct pen_scene_desc *desc;
    const int *views; /* numbers of views of desc */
    int view_count;
    const struct pen_bench_row *rows;
    int row_count;
    int baseline;        /* the row that speed-ups refer to */
    int repeats, warmup; /* at least 1; at least 0 */
    size_t scene_cap_bytes;
    struct pen_thread_pool *pool;
    const atomic_bool
        *cancel; /* polled between runs and before each block of pixels; may be NULL */
    /* Called between runs, with done = 0 before the first; may be NULL. */
    void (*progress)(void *user, int done, int total);
    void *user;
    /* As in pen_render_task; may be NULL. */
    void (*pixel_begins)(void *user, int thread, int x, int y);
    void *pixel_user;
    /* For tests: called with each picture before it is compared, and may change it. May be NULL. */
    void (*tamper)(void *user, int row, int view, float *rgb);
};

/* The number of runs of a benchmark: warm-up, repeats and counting. */
int pen_bench_runs(const struct pen_bench *bench);

/* The pixels of all reference pictures that a benchmark keeps. */
double pen_bench_reference_pixels(const struct pen_bench *bench);

/* Runs a benchmark. Owns: *result, in any case; release it. Fails: PEN_DIFFERENT (the message names
 * the rows, view, pixel, channel and values), PEN_CANCELLED, PEN_NO_MEMORY; as pen_scene_freeze.
 * Threads: one benchmark per pool, and nothing else on that pool. */
bool pen_bench_run(const struct pen_bench *bench, struct pen_bench_result *result,
                   struct pen_status *st);
void pen_bench_result_release(const struct pen_bench *bench, struct pen_bench_result *result);

/* The report of a benchmark as JSON (api/openapi.yaml, schema Report). `head` holds what the
 * benchmark does not know, such as the scene's name; its members come first. Takes the reference to
 * `head`. Fails: NULL when out of memory. */
json_t *pen_bench_report_new(const struct pen_bench *bench, const struct pen_bench_result *result,
                             json_t *head);

#endif
