/* SPDX-License-Identifier: MIT */
/* Makes one run and times it. Nothing but freezing and rendering happens while it is timed. */
#include "study/internal/bench_run.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "study/run_time.h"

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

bool pen_bench_run_once(struct pen_bench_run *run, struct pen_status *st)
{
    const struct pen_bench *bench = run->bench;
    const struct pen_run_watch watch = pen_run_begin();
    const int64_t cpu_ns = pen_clock_thread_ns();
    struct pen_scene *scene = pen_scene_freeze(
        bench->desc, (enum pen_accelerator)run->settings->accelerator, bench->scene_cap_bytes, st);
    if (scene && bench->dawdle)
        bench->dawdle(bench->user, run->row);
    const double build_ms = (double)(pen_clock_ns() - watch.begun_ns) * 1e-6,
                 build_cpu_ms = (double)(pen_clock_thread_ns() - cpu_ns) * 1e-6;
    if (!scene)
        return false;
    run->accel = *pen_accel_get_stats(scene->accel);
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
