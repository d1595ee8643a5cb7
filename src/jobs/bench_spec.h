/* SPDX-License-Identifier: MIT */
/* The spec of a benchmark, from a job or a command line: the checked members `matrix`, `baseline`,
 * `repeats`, `warmup`, `interval`, `budget_seconds`, `least_effect` and `order_seed`, and the rows
 * that the matrix makes.
 *
 * `repeats` gives the number of runs of each row. Or it follows from `interval` and
 * `budget_seconds`; if only one of them is there, the other has its default. Both ways together are
 * an error.
 *
 * The rows are the Cartesian product of the matrix's lists, in the order of the document: the last
 * key changes fastest. Without a matrix there is one row, the settings as they are. */
#ifndef PEN_JOBS_BENCH_SPEC_H
#define PEN_JOBS_BENCH_SPEC_H

#include "io/scene_json.h"
#include "study/bench.h"

enum {
    PEN_BENCH_ROWS_MAX = 256,
    PEN_BENCH_REPEATS_MAX = 100,
    PEN_BENCH_WARMUP_MAX = 10,
    PEN_BENCH_BUDGET_MAX_S = 86400
};

struct pen_bench_spec {
    json_t *matrix; /* {} if there is none */
    int repeats, warmup;
    double interval; /* 0: `repeats` gives the number of runs */
    double budget_s, least_effect;
    int order_seed; /* from the clock if the spec has none */
    int baseline;   /* a row; by default the first */
    int row_count;
    struct pen_bench_row *rows;
};

/* Reads the member `repeats`; its default is 3.
 * Fails: errors->count grows. */
bool pen_repeats_read(const json_t *members, int *repeats, struct pen_errors *errors);

/* Reads these members of an object, which may have others. In each row the matrix's values override
 * `base`. All errors are collected, each with its place, such as /matrix/accelerator/2.
 * Owns: release *spec, after success and after failure.
 * Fails: errors->count grows. */
bool pen_bench_spec_read(const json_t *members, const struct pen_settings *base,
                         struct pen_bench_spec *spec, struct pen_errors *errors);
void pen_bench_spec_release(struct pen_bench_spec *spec);

/* Checks the limits of a benchmark. Each run is checked by pen_limits_check. The rays of all runs
 * together, without those of forking paths, are checked too, and the size of the pictures that are
 * kept for comparison.
 * Fails: PEN_TOO_LARGE, at /matrix. */
bool pen_bench_spec_check(const struct pen_bench_spec *spec, const struct pen_limits *limits,
                          const struct pen_scene_desc *desc, int views, struct pen_status *st);

/* Makes a benchmark from a spec: its rows, and how they are run.
 * Owns: the rows stay the spec's. */
struct pen_bench pen_bench_of_spec(const struct pen_bench_spec *spec);

/* Adds the members that make the same spec again, with all defaults and without the matrix. The
 * object must have none of them. Takes the reference to the object and returns it.
 * Fails: NULL when out of memory. */
json_t *pen_bench_spec_members(const struct pen_bench_spec *spec, json_t *object);

/* Makes the first members of the report: kind, scene, views, matrix, and the settings that all rows
 * share.
 * Owns: the caller.
 * Fails: NULL when out of memory. */
json_t *pen_bench_spec_head(const struct pen_bench_spec *spec, const struct pen_bench *bench,
                            const struct pen_settings *base);

#endif
