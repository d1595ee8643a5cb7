/* SPDX-License-Identifier: MIT */
/* One run of a benchmark: what it measures, and whether it is spoiled. */
#ifndef PEN_STUDY_INTERNAL_BENCH_RUN_H
#define PEN_STUDY_INTERNAL_BENCH_RUN_H

#include "study/bench.h"
#include "study/internal/pictures.h"

/* The input and the results of a run. The caller sets the members before `times`, and
 * stats.tests_counted if tests are to be counted. pen_bench_run_once sets the others. */
struct pen_bench_run {
    const struct pen_bench *bench;
    const struct pen_settings *settings;
    struct pen_bench_pictures *pictures; /* the pixels go to its targets */
    int row;                             /* for bench->dawdle */
    double *tile_ms; /* gets the times of tiles, view after view; NULL: not kept */
    struct pen_bench_times times;
    struct pen_render_stats stats; /* summed over all views */
    struct pen_accel_stats accel;
};

/* Freezes the scene and renders its views. Repeats both if they take less than a millisecond.
 * Fails: as pen_scene_freeze and pen_render_run. */
bool pen_bench_run_once(struct pen_bench_run *run, struct pen_status *st);

#endif
