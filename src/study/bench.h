/* SPDX-License-Identifier: MIT */
/* The benchmark: one scene rendered under several settings, timed, and its pictures compared.
 *
 * A row is one combination of settings. A run freezes the scene, which builds its tree, and renders
 * all views, under the settings of one row; the run's time is the sum of both. If that is less than
 * a millisecond, the run does it again and again for a millisecond, and its time is the mean. A
 * pass visits every row once, in a random order of its own, so that neither a change of the
 * machine's load nor one that comes again and again meets one row more than others. Runs come in
 * this order:
 *
 * 1. `warmup` passes. Their times are thrown away.
 * 2. Passes whose times are kept: the repeats. The time of a row over that of the baseline in the
 *    same repeat is a pair. With an asked interval, repeats go on, and are looked at after 10, 20,
 *    40, ..., until the interval of every row's ratio is narrow enough or the budget ends; without,
 *    there are `repeats` of them, and one look. Where there may be 10 pairs, a pass also visits a
 *    twin of the baseline, the same settings again: their ratio tells what the host's noise alone
 *    does (an A/A run).
 * 3. One run for each set of rows that do the same work, to count box and primitive tests. Its time
 *    is thrown away, because counting takes time.
 *
 * verdict.h has the statistics, run_time.h which runs are spoiled; a pair is spoiled if one of its
 * runs is, and intervals leave spoiled pairs out of account.
 *
 * Rows whose settings differ in accelerator, threads and tile alone show the same picture, bit for
 * bit (in fast precision: rows that differ in threads and tile alone). Every run's pictures are
 * compared with the first ones of their kind, and a benchmark that finds a difference fails.
 * Pictures that may differ are measured against those of the first row of their size. */
#ifndef PEN_STUDY_BENCH_H
#define PEN_STUDY_BENCH_H

#include <jansson.h>

#include "study/study.h"
#include "study/verdict.h"

/* A combination of settings. */
struct pen_bench_row {
    struct pen_settings settings;
    const json_t *varied; /* the row's values of the settings that rows differ in: a `render` object
                           * with the same keys in every row */
};

/* The times of one run. Units: ms. */
struct pen_bench_times {
    int in_a_row;          /* the times are means of so many freezes and renders */
    double calibration_ms; /* of a fixed computation before the repeat; in the first row's runs */
    double build_ms, render_ms;
    double cpu_ms;   /* of the render threads */
    double used;     /* the processor time of build and render over what could have been used */
    double steal_ms; /* of all processors, given to others by a hypervisor; below 0: unknown */
    bool spoiled;
};

/* The results of one row. Units: ms. */
struct pen_bench_row_result {
    struct pen_bench_times *runs;       /* one for each repeat, in order of time */
    double median_ms, min_ms, max_ms;   /* of build + render */
    double build_ms, render_ms, cpu_ms; /* medians of the parts */
    double used;                        /* median */
    double speedup;                     /* the baseline's median divided by this row's */
    struct pen_confidence ratio;        /* of this row's time over the baseline's, by pairs */
    enum pen_verdict verdict;
    const char *reason; /* why it is undecided, for people; "" if it is not */
    int spoiled;        /* runs */
    /* Of the last repeat, all views together; with the tests counted in step 3. tile_ms is that of
     * the baseline alone, NULL in other rows. */
    struct pen_render_stats stats;
    struct pen_accel_stats accel;
    uint64_t picture_hash;       /* of the pictures of all views */
    int same_as;                 /* the first row that shows the same picture; may be itself */
    int compared_with;           /* the first row of the same size; may be itself */
    bool identical;              /* to the pictures of compared_with, in every bit */
    double max_difference, rmse; /* from them, of sRGB-encoded values in [0, 1] */
};

/* What ended the repeats. */
enum pen_bench_end { PEN_BENCH_END_REPEATS, PEN_BENCH_END_INTERVAL, PEN_BENCH_END_BUDGET };

struct pen_bench_result {
    struct pen_bench_row_result *rows;
    struct pen_bench_row_result
        twin; /* of the baseline: runs, ratio and verdict; runs NULL: none */
    struct pen_confidence calibration; /* of the times of a fixed computation */
    int repeats;                       /* made */
    int breaks;                        /* how often a process has gone on where another had ended */
    enum pen_bench_end end;
    double load_before, load_after; /* the system's load over a minute; below 0: unknown */
    int64_t began_ms, ended_ms;     /* wall clock */
};

/* What to run. Owns: nothing; everything is borrowed until the benchmark ends. */
struct pen_bench {
    struct pen_study_frame frame;
    const int *views; /* numbers of views of frame.desc */
    int view_count;
    const struct pen_bench_row *rows;
    int row_count;
    int baseline;        /* the row that speed-ups refer to */
    int repeats, warmup; /* at least 1, without meaning if an interval is asked; at least 0 */
    double interval;     /* how wide the interval of every row's ratio may be; 0: any */
    double budget_ms; /* with an interval: no run begins later, unless the first repeat lacks it */
    double least_effect; /* of verdicts */
    uint64_t order_seed; /* of the random orders */
    /* For tests: called with each picture before it is compared, and may change it. May be NULL. */
    void (*tamper)(void *user, int row, int view, float *rgb);
    /* For tests: called within the timed part of each run. May be NULL. */
    void (*dawdle)(void *user, int row);
};

/* The number of runs of a benchmark: warm-up, repeats and counting. With an interval, the largest
 * number that it may come to. */
int pen_bench_runs(const struct pen_bench *bench);

/* Whether each pass visits a twin of the baseline. */
bool pen_bench_has_twin(const struct pen_bench *bench);

/* The pixels of all reference pictures that a benchmark keeps. */
double pen_bench_reference_pixels(const struct pen_bench *bench);

/* Runs a benchmark. Owns: *result, in any case; release it. Fails: PEN_DIFFERENT (the message names
 * the rows, view, pixel, channel and values), PEN_CANCELLED, PEN_UNAVAILABLE (`between` has ended
 * it), PEN_NO_MEMORY; as pen_scene_freeze.
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
