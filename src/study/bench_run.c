/* SPDX-License-Identifier: MIT */
/* Makes one run and times it. Nothing but freezing and rendering happens while it is timed. A clock
 * and the start of threads disturb what is shorter than a millisecond, so that is repeated: the
 * first time says how often. Each is judged by itself.
 *
 * A run is spoiled if others had a part of the processors that it could have used:
 *
 * - its threads waited: their processor time is less than 95 % of the time from their call to their
 *   return, and that by 0.5 ms for each, within which threads wake up and are moved. A thread that
 *   finds no more work returns, so neither a tree that one thread builds nor a picture of few
 * blocks counts as waiting. Of more threads than there are processors, those that have one count.
 * - a hypervisor gave more than 5 % of all processors to others, and a clock tick besides, since
 *   the kernel counts in ticks.
 *
 * 5 %: while nothing else ran, runs of 2 to 55 ms on 2 cores had 0.98 to 0.999 of their time, and
 * beside a busy loop 0.50 (README.md of this room). What is taken from a run lengthens it by about
 * the same share, so a run that is not spoiled was disturbed by 5 % at most. */
#include "study/internal/bench_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "study/host.h"

static const double least_used = 0.95, most_stolen = 0.05;
static const double wake_ms = 0.5, tick_ms = 10;
static const double least_ms = 1; /* of the time that one measurement takes */
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
                                       .cancel = bench->cancel,
                                       .pixel_begins = bench->pixel_begins,
                                       .pixel_user = bench->pixel_user,
                                       .keep_tile_ms = run->tile_ms != NULL,
                                       .count_tests = run->stats.tests_counted};
        if (!pen_render_run(bench->pool, &task, &stats, st))
            return false;
        if (stats.tile_ms)
            memcpy(run->tile_ms + run->stats.tile_count, stats.tile_ms,
                   stats.tile_count * sizeof *stats.tile_ms);
        free(stats.tile_ms);
        add_stats(&run->stats, &stats);
    }
    return true;
}

/* The calling thread's clocks. */
struct moment {
    int64_t wall_ns, cpu_ns;
};

static struct moment now(void)
{
    return (struct moment){.wall_ns = pen_clock_ns(), .cpu_ns = pen_clock_thread_ns()};
}

/* Fills the times from the render's, and from the beginning and the end of the build. */
static void fill_times(struct pen_bench_run *run, struct moment begun, struct moment built)
{
    const struct pen_render_stats *s = &run->stats;
    struct pen_bench_times *t = &run->times;
    const int processors = pen_cpu_count();
    const double share = s->threads > processors ? (double)processors / s->threads : 1;
    t->build_ms = (double)(built.wall_ns - begun.wall_ns) * 1e-6;
    t->render_ms = s->render_ms;
    t->cpu_ms = s->cpu_ms;
    const double cpu_ms = s->cpu_ms + (double)(built.cpu_ns - begun.cpu_ns) * 1e-6;
    const double could_ms = s->thread_ms * share + t->build_ms;
    t->used = could_ms > 0 && cpu_ms < could_ms ? cpu_ms / could_ms : 1;
    t->spoiled = t->used < least_used && could_ms - cpu_ms > wake_ms * (s->threads + 1);
}

static void judge_steal(struct pen_bench_times *times, double before_ms, double after_ms,
                        double wall_ms)
{
    times->steal_ms = before_ms < 0 || after_ms < before_ms ? -1 : after_ms - before_ms;
    if (times->steal_ms - tick_ms > most_stolen * wall_ms * pen_host_processors())
        times->spoiled = true;
}

/* Freezes and renders, and fills the times of that. */
static bool run_one(struct pen_bench_run *run, struct pen_status *st)
{
    const struct pen_bench *bench = run->bench;
    const struct moment begun = now();
    struct pen_scene *scene = pen_scene_freeze(
        bench->desc, (enum pen_accelerator)run->settings->accelerator, bench->scene_cap_bytes, st);
    if (scene && bench->dawdle)
        bench->dawdle(bench->user, run->row);
    const struct moment built = now();
    if (!scene)
        return false;
    run->accel = *pen_accel_get_stats(scene->accel);
    run->stats = (struct pen_render_stats){.tests_counted = run->stats.tests_counted};
    const bool ok = render_views(run, scene, st);
    fill_times(run, begun, built);
    pen_scene_free(scene);
    return ok;
}

/* How often a run is made that takes so long, at least once. */
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
    sum->spoiled = sum->spoiled || one->spoiled;
}

bool pen_bench_run_once(struct pen_bench_run *run, struct pen_status *st)
{
    struct pen_bench_times sum = {0};
    const double steal_ms = pen_host_steal_ms();
    const int64_t begun_ns = pen_clock_ns();
    int count = 1, made = 0;
    for (; made < count; made++) {
        if (!run_one(run, st))
            return false;
        if (made == 0 && !run->stats.tests_counted)
            count = count_for(&run->times);
        add_times(&sum, &run->times);
    }
    const double wall_ms = (double)(pen_clock_ns() - begun_ns) * 1e-6;
    run->times = (struct pen_bench_times){.in_a_row = count,
                                          .build_ms = sum.build_ms / count,
                                          .render_ms = sum.render_ms / count,
                                          .cpu_ms = sum.cpu_ms / count,
                                          .used = sum.used / count,
                                          .spoiled = sum.spoiled};
    judge_steal(&run->times, steal_ms, pen_host_steal_ms(), wall_ms);
    return true;
}
