/* SPDX-License-Identifier: MIT */
/* Makes one run and times it. Only freezing and rendering happen while it is timed. The clock and
 * the start of threads disturb a time below a millisecond, so a shorter run is repeated. The first
 * time decides how often. Each repetition is checked for being spoiled. */
#include "study/internal/bench_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "study/run_time.h"

static const double least_ms = 1; /* shortest time of one measurement */
enum { IN_A_ROW_MAX = 1000 };

static void add_stats(struct pen_render_stats *sum, const struct pen_render_stats *view)
{
    sum->render_ms += view->render_ms;
    sum->cpu_ms += view->cpu_ms;
    sum->thread_ms += view->thread_ms;
    sum->threads = view->threads > sum->threads ? view->threads : sum->threads;
    pen_ray_counts_add(&sum->rays, &view->rays);
    sum->tests_counted = view->tests_counted;
    sum->tests.boxes += view->tests.boxes;
    sum->tests.primitives += view->tests.primitives;
    sum->tile_count += view->tile_count;
    sum->kernel = view->kernel;
    sum->effects |= view->effects;
}

static bool render_views(struct pen_bench_run *run, const struct pen_scene *scene,
                         struct pen_status *st)
{
    const struct pen_bench *bench = run->bench;
    for (int i = 0; i < bench->view_count; i++) {
        struct pen_render_stats stats;
        struct pen_render_task task = {.scene = scene,
                                       .view = bench->views[i],
                                       .settings = run->settings,
                                       .tile_count = -1,
                                       .rgb = pen_bench_pictures_target(run->pictures, i),
                                       .cancel = bench->frame.cancel,
                                       .pixel_begins = bench->frame.pixel_begins,
                                       .pixel_user = bench->frame.pixel_user,
                                       .keep_tile_ms = run->tile_ms != NULL,
                                       .count_tests = run->stats.tests_counted};
        if (!pen_render_run(bench->frame.pool, &task, &stats, st))
            return false;
        if (stats.tile_ms)
            memcpy(run->tile_ms + run->stats.tile_count, stats.tile_ms,
                   stats.tile_count * sizeof *stats.tile_ms);
        free(stats.tile_ms);
        add_stats(&run->stats, &stats);
    }
    return true;
}

/* Freezes and renders once, and sets the times. */
static bool run_one(struct pen_bench_run *run, struct pen_status *st)
{
    const struct pen_bench *bench = run->bench;
    const struct pen_run_watch watch = pen_run_begin();
    const int64_t cpu_ns = pen_clock_thread_ns();
    struct pen_scene *scene =
        pen_scene_freeze(bench->frame.desc, (enum pen_accelerator)run->settings->accelerator,
                         bench->frame.scene_cap_bytes, st);
    if (scene && bench->dawdle)
        bench->dawdle(bench->frame.user, run->row);
    const double build_ms = (double)(pen_clock_ns() - watch.begun_ns) * 1e-6,
                 build_cpu_ms = (double)(pen_clock_thread_ns() - cpu_ns) * 1e-6;
    if (!scene)
        return false;
    run->accel = *pen_accel_get_stats(scene->accel);
    run->stats = (struct pen_render_stats){.tests_counted = run->stats.tests_counted};
    const bool ok = render_views(run, scene, st);
    const struct pen_run_use use = pen_run_end(&watch, &run->stats, build_ms, build_cpu_ms);
    run->times = (struct pen_bench_times){.build_ms = build_ms,
                                          .render_ms = run->stats.render_ms,
                                          .cpu_ms = run->stats.cpu_ms,
                                          .used = use.used,
                                          .steal_ms = use.steal_ms,
                                          .spoiled = use.spoiled};
    pen_scene_free(scene);
    return ok;
}

/* How often a run of this length is made; at least once. */
static int count_for(const struct pen_bench_times *times)
{
    const double ms = times->build_ms + times->render_ms;
    if (!(ms < least_ms))
        return 1;
    return ms * IN_A_ROW_MAX > least_ms ? (int)ceil(least_ms / ms) : IN_A_ROW_MAX;
}

static void add_times(struct pen_bench_times *sum, const struct pen_bench_times *one)
{
    sum->build_ms += one->build_ms;
    sum->render_ms += one->render_ms;
    sum->cpu_ms += one->cpu_ms;
    sum->used += one->used;
    sum->steal_ms = one->steal_ms < 0 || sum->steal_ms < 0 ? -1 : sum->steal_ms + one->steal_ms;
    sum->spoiled = sum->spoiled || one->spoiled;
}

bool pen_bench_run_once(struct pen_bench_run *run, struct pen_status *st)
{
    struct pen_bench_times sum = {0};
    int count = 1;
    for (int made = 0; made < count; made++) {
        if (!run_one(run, st))
            return false;
        if (made == 0 && !run->stats.tests_counted)
            count = count_for(&run->times);
        add_times(&sum, &run->times);
    }
    run->times = (struct pen_bench_times){.in_a_row = count,
                                          .build_ms = sum.build_ms / count,
                                          .render_ms = sum.render_ms / count,
                                          .cpu_ms = sum.cpu_ms / count,
                                          .used = sum.used / count,
                                          .steal_ms = sum.steal_ms,
                                          .spoiled = sum.spoiled};
    return true;
}
