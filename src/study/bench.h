/* SPDX-License-Identifier: MIT */
/* The benchmark: renders one scene under several settings, measures times, and compares the
 * pictures.
 *
 * A row is one combination of settings. A run freezes the scene, which builds its tree, and renders
 * all views under the settings of one row. The time of a run is the sum of both. If that is below a
 * millisecond, the run repeats both until a millisecond is used, and its time is the mean. A pass
 * visits each row once, in its own random order. So neither a drift nor a periodic change of the
 * machine's load affects one row more than others. The order of the runs is:
 *
 * 1. `warmup` passes. Their times are discarded.
 * 2. The repeats: passes whose times count. A pair is the time of a row over the time of the
 *    baseline in the same repeat. If an interval is requested, the intervals are looked at after
 *    10, 20, 40, ... repeats. The repeats end when the interval of every row's ratio is narrow
 *    enough, or when the budget ends. Otherwise there are `repeats` of them, and one look. If there
 *    can be 10 pairs, each pass also visits a twin of the baseline, which has the same settings.
 *    The twin's ratio shows the effect of noise alone (an A/A test).
 * 3. One run for each set of rows that do the same work, to count box and primitive tests. Its time
 *    is discarded, because counting takes time.
 *
 * verdict.h describes the statistics. run_time.h defines which runs are spoiled. A pair is spoiled
 * if one of its runs is. Intervals are widened by their number of spoiled pairs.
 *
 * Rows that differ in accelerator, threads and tile alone must show the same picture, bit for bit.
 * In fast precision, this holds for threads and tile alone. The pictures of every run are compared
 * with the first pictures of their kind, and a difference fails the benchmark. Pictures that may
 * differ are measured against the first row of the same size. */
#ifndef PEN_STUDY_BENCH_H
#define PEN_STUDY_BENCH_H

#include <jansson.h>

#include "study/study.h"
#include "study/verdict.h"

/* A combination of settings. */
struct pen_bench_row {
    struct pen_settings settings;
    /* The row's values of the settings in which rows differ: a `render` object with the same keys
     * in every row. */
    const json_t *varied;
};

/* The times of one run.
 * Units: ms. */
struct pen_bench_times {
    int in_a_row;          /* number of freezes and renders of which the times are means */
    double calibration_ms; /* of a fixed computation before the repeat; only in the runs of row 0 */
    double build_ms, render_ms;
    double cpu_ms;   /* processor time of the render threads */
    double used;     /* processor time of build and render, divided by what could have been used */
    double steal_ms; /* steal time of all processors (pen_host_steal_ms); below 0: unknown */
    bool spoiled;
};

/* The results of one row.
 * Units: ms. */
struct pen_bench_row_result {
    struct pen_bench_times *runs;       /* one for each repeat, in chronological order */
    double median_ms, min_ms, max_ms;   /* of build + render */
    double build_ms, render_ms, cpu_ms; /* medians of the parts */
    double used;                        /* median */
    double speedup;                     /* the baseline's median divided by this row's */
    struct pen_confidence ratio;        /* of this row's time over the baseline's, from pairs */
    enum pen_verdict verdict;
    const char *reason; /* why the verdict is undecided, for readers; else "" */
    int spoiled;        /* runs */
    /* Of the last repeat, summed over all views, with the tests that step 3 counted. tile_ms is set
     * for the baseline alone; it is NULL in other rows. */
    struct pen_render_stats stats;
    struct pen_accel_stats accel;
    uint64_t picture_hash; /* of the pictures of all views */
    int same_as;           /* the first row that shows the same picture; may be the row itself */
    int compared_with;     /* the first row of the same size; may be the row itself */
    bool identical;        /* the pictures equal those of compared_with, bit for bit */
    double max_difference, rmse; /* against compared_with, of sRGB-encoded values in [0, 1] */
};

/* Why the repeats ended. */
enum pen_bench_end { PEN_BENCH_END_REPEATS, PEN_BENCH_END_INTERVAL, PEN_BENCH_END_BUDGET };

/* The results of a benchmark. */
struct pen_bench_result {
    struct pen_bench_row_result *rows;
    /* Of the baseline's twin; has runs, ratio and verdict. runs NULL: there is no twin. */
    struct pen_bench_row_result twin;
    struct pen_confidence calibration; /* of the times of a fixed computation */
    int repeats;                       /* number of whole repeats */
    int breaks;                        /* how often another process resumed the benchmark */
    enum pen_bench_end end;
    double load_before, load_after; /* the system's load average over a minute; below 0: unknown */
    int64_t began_ms, ended_ms;     /* wall clock */
};

/* The input of a benchmark.
 * Owns: nothing; everything is borrowed until the benchmark ends. */
struct pen_bench {
    struct pen_study_frame frame;
    const int *views; /* numbers of views of frame.desc */
    int view_count;
    const struct pen_bench_row *rows;
    int row_count;
    int baseline; /* the row that speed-ups refer to */
    /* repeats: at least 1; ignored if `interval` is set. warmup: at least 0. */
    int repeats, warmup;
    double interval; /* the greatest width of the interval of each row's ratio; 0: any */
    /* With `interval` set, no timed run starts later, except those of the first repeat. */
    double budget_ms;
    double least_effect; /* the least effect of verdicts, as a share */
    uint64_t order_seed; /* of the random orders */
    /* For tests: called with each picture before it is compared. May change the picture. May be
     * NULL. */
    void (*tamper)(void *user, int row, int view, float *rgb);
    /* For tests: called within the timed part of each run. May be NULL. */
    void (*dawdle)(void *user, int row);
};

/* The number of runs of a benchmark: warm-up, repeats and counting. If an interval is requested,
 * the largest possible number. */
int pen_bench_runs(const struct pen_bench *bench);

/* Whether each pass visits a twin of the baseline. */
bool pen_bench_has_twin(const struct pen_bench *bench);

/* The number of pixels of all reference pictures that a benchmark keeps. */
double pen_bench_reference_pixels(const struct pen_bench *bench);

/* Runs a benchmark.
 * Owns: release *result, after success and after failure.
 * Fails: PEN_DIFFERENT (the message names rows, view, pixel, channel and values), PEN_CANCELLED,
 * PEN_UNAVAILABLE (frame.between returned false), PEN_NO_MEMORY; as pen_scene_freeze.
 * Threads: one benchmark per pool, and nothing else on that pool. */
bool pen_bench_run(const struct pen_bench *bench, struct pen_bench_result *result,
                   struct pen_status *st);
void pen_bench_result_release(const struct pen_bench *bench, struct pen_bench_result *result);

/* Makes the report of a benchmark as JSON (api/openapi.yaml, schema Report). `head` has the members
 * that the benchmark does not know, such as the scene's name. They come first.
 * Owns: takes the reference to `head`; the caller json_decref()s the report.
 * Fails: NULL when out of memory. */
json_t *pen_bench_report_new(const struct pen_bench *bench, const struct pen_bench_result *result,
                             json_t *head);

#endif
