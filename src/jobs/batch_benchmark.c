/* SPDX-License-Identifier: MIT */
/* A benchmark in the worker. It is one batch: when a worker dies, its times are lost and the next
 * worker measures again, so no report mixes the times of two workers. Progress is stored between
 * runs, never during one. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "io/stats_json.h"
#include "jobs/bench_spec.h"
#include "jobs/internal/batch.h"
#include "jobs/internal/scene_cache.h"
#include "jobs/internal/stats.h"
#include "study/report.h"

enum { PROGRESS_MS = 250 }; /* the shortest time between two reports of progress */

struct benchmark {
    struct pen_batch_context *context;
    const struct pen_claim *claim;
    struct pen_arena *arena; /* of desc */
    struct pen_scene_desc desc;
    struct pen_bench_spec spec;
    struct pen_bench bench;
    struct pen_bench_result result;
    int *views;
    double parse_ms;
    int64_t progress_ns; /* when progress was last stored */
};

/* Stores the progress. A failure is ignored: the next report may succeed, and the heartbeat notices
 * a lost lease. */
static void store_progress(void *user, int done, int total)
{
    struct benchmark *benchmark = user;
    struct pen_status ignored;
    int64_t now_ns = pen_clock_ns();
    if (done > 0 && done < total &&
        now_ns - benchmark->progress_ns < (int64_t)PROGRESS_MS * 1000000)
        return;
    benchmark->progress_ns = now_ns;
    pen_store_progress(benchmark->context->store, benchmark->claim, done, &ignored);
    if (pen_store_checkpoint_due(benchmark->context->store)) /* no run is timed at this moment */
        pen_store_checkpoint(benchmark->context->store, &ignored);
}

static bool read_scene(struct benchmark *benchmark, struct pen_status *st)
{
    int64_t begun_ns = pen_clock_ns();
    benchmark->arena = pen_arena_new(pen_scene_cache_cap(benchmark->context->scenes));
    if (!benchmark->arena)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a scene");
    bool ok = pen_scene_describe(benchmark->context->store, benchmark->claim->job_id,
                                 benchmark->arena, &benchmark->desc, st);
    benchmark->parse_ms = (double)(pen_clock_ns() - begun_ns) * 1e-6;
    return ok;
}

static bool find_views(struct benchmark *benchmark, struct pen_status *st)
{
    const struct pen_stored_request *request = &benchmark->context->request;
    benchmark->views = calloc((size_t)request->view_count, sizeof *benchmark->views);
    if (!benchmark->views)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for %d views", request->view_count);
    for (int i = 0; i < request->view_count; i++) {
        const char *name = pen_stored_request_view(request, i);
        uint32_t view = 0;
        while (view < benchmark->desc.view_count &&
               (!name || strcmp(benchmark->desc.views[view].name, name) != 0))
            view++;
        if (view == benchmark->desc.view_count)
            return pen_fail(st, PEN_INTERNAL, "the scene has no view %d", i);
        benchmark->views[i] = (int)view;
    }
    return true;
}

static bool read_spec(struct benchmark *benchmark, struct pen_status *st)
{
    const struct pen_stored_request *request = &benchmark->context->request;
    struct pen_errors errors = {0};
    if (!pen_bench_spec_read(request->json, &request->settings, &benchmark->spec, &errors)) {
        *st = errors.item[0];
        return false;
    }
    benchmark->bench = pen_bench_of_spec(&benchmark->spec);
    benchmark->bench.desc = &benchmark->desc;
    benchmark->bench.views = benchmark->views;
    benchmark->bench.view_count = request->view_count;
    benchmark->bench.scene_cap_bytes = pen_scene_cache_cap(benchmark->context->scenes);
    benchmark->bench.pool = benchmark->context->pool;
    benchmark->bench.cancel = pen_heartbeat_cancel_flag(benchmark->context->heart);
    benchmark->bench.progress = store_progress;
    benchmark->bench.user = benchmark;
    return true;
}

static bool run(struct benchmark *benchmark, struct pen_status *st)
{
    struct pen_batch_context *context = benchmark->context;
    benchmark->bench.pixel_begins = pen_batch_pixel_hook(context);
    benchmark->bench.pixel_user = context;
    return pen_batch_hook_done(context, pen_bench_run(&benchmark->bench, &benchmark->result, st),
                               st);
}

static bool write_report(struct benchmark *benchmark, struct pen_batch_output *output,
                         struct pen_status *st)
{
    json_t *report =
        pen_bench_report_new(&benchmark->bench, &benchmark->result,
                             pen_bench_spec_head(&benchmark->spec, &benchmark->bench,
                                                 &benchmark->context->request.settings));
    bool ok = report ? pen_bench_report_write(report, "json", &output->artefact, st)
                     : pen_fail(st, PEN_NO_MEMORY, "no memory for a report");
    json_decref(report);
    output->result.layer = PEN_REPORT_LAYER;
    output->result.format = PEN_REPORT_FORMAT;
    output->result.artefact = output->artefact.data;
    output->result.artefact_bytes = output->artefact.bytes;
    return ok;
}

/* The job's statistics are those of the baseline row's last counted run. */
static bool write_stats(struct benchmark *benchmark, struct pen_batch_output *output,
                        struct pen_status *st)
{
    const struct pen_bench_row_result *row = &benchmark->result.rows[benchmark->spec.baseline];
    struct pen_stats_input in = {.parse_ms = benchmark->parse_ms,
                                 .build_ms = row->runs[benchmark->spec.repeats - 1].build_ms,
                                 .render = &row->stats,
                                 .accel = &row->accel};
    json_t *json = pen_stats_json(&in);
    if (json)
        json = pen_json_with(json, "tile_ms",
                             pen_tile_times(row->stats.tile_ms, row->stats.tile_count));
    return pen_batch_write_stats(benchmark->context, json, output, st);
}

bool pen_batch_benchmark(struct pen_batch_context *context, const struct pen_claim *claim,
                         struct pen_batch_output *output, struct pen_status *st)
{
    struct benchmark benchmark = {.context = context, .claim = claim};
    bool ok = read_scene(&benchmark, st) && find_views(&benchmark, st) &&
              read_spec(&benchmark, st) && run(&benchmark, st) &&
              write_report(&benchmark, output, st) && write_stats(&benchmark, output, st);
    pen_bench_result_release(&benchmark.bench, &benchmark.result);
    pen_bench_spec_release(&benchmark.spec);
    free(benchmark.views);
    pen_arena_free(benchmark.arena);
    return ok;
}
