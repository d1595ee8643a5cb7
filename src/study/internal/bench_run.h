/* SPDX-License-Identifier: MIT */
/* One run of a benchmark: what it measures, and whether it is spoiled. */
#ifndef PEN_STUDY_INTERNAL_BENCH_RUN_H
#define PEN_STUDY_INTERNAL_BENCH_RUN_H

#include "study/bench.h"
#include "study/internal/pictures.h"

/* A run. The caller sets the first members, and stats.tests_counted to have tests counted;
 * pen_bench_run_once fills the rest. */
struct pen_bench_run {
    const struct pen_bench *bench;
    const struct pen_settings *settings;
    struct pen_bench_pictures *pictures; /* its targets get the pixels */
    int row;                             /* for bench->dawdle */
    double *tile_ms; /* gets the times of tiles, one view behind the other; NULL: not kept */
    struct pen_bench_times times;
    struct pen_render_stats stats; /* all views together */
    struct pen_accel_stats accel;
};

/* Freezes the scene and renders its views, several times if that takes less than a millisecond.
 * Fails: as pen_scene_freeze and pen_render_run. */
bool pen_bench_run_once(struct pen_bench_run *run, struct pen_status *st);

#endif
