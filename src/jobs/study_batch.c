/* SPDX-License-Identifier: MIT */
/* A benchmark in the worker. It is one batch: times taken by a worker that died are lost with it,
 * and its successor measures anew, so that no report mixes the two. Between runs, and never within
 * one, it tells the store how far it is. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "jobs/benchmark.h"
#include "jobs/internal/batch.h"
#include "jobs/internal/scene_cache.h"
#include "jobs/internal/stats.h"
#include "study/report.h"

enum { TELL_MS = 250 }; /* at least, between two tellings */

struct study {
    struct pen_batch_room *room;
    const struct pen_claim *claim;
    struct pen_arena *arena; /* of desc */
    struct pen_scene_desc desc;
    struct pen_bench_spec order;
    struct pen_bench bench;
    struct pen_bench_result result;
    int *views;
    double parse_ms;
    int64_t told_ns;
};

/* That a telling fails is no reason to stop: the next one may do, and the heartbeat sees a lease
 * that is lost. */
static void tell(void *user, int done, int total)
{
    struct study *study = user;
    struct pen_status ignored;
    int64_t now_ns = pen_clock_ns();
    if (done > 0 && done < total && now_ns - study->told_ns < (int64_t)TELL_MS * 1000000)
        return;
    study->told_ns = now_ns;
    pen_store_progress(study->room->store, study->claim, done, &ignored);
    if (pen_store_checkpoint_due(study->room->store)) /* here it disturbs no run */
        pen_store_checkpoint(study->room->store, &ignored);
}

static bool read_scene(struct study *study, struct pen_status *st)
{
    int64_t begun_ns = pen_clock_ns();
    study->arena = pen_arena_new(pen_scene_cache_cap(study->room->scenes));
    if (!study->arena)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a scene");
    bool ok = pen_scene_describe(study->room->store, study->claim->job_id, study->arena,
                                 &study->desc, st);
    study->parse_ms = (double)(pen_clock_ns() - begun_ns) * 1e-6;
    return ok;
}

static bool find_views(struct study *study, struct pen_status *st)
{
    const struct pen_job_plan *plan = &study->room->plan;
    study->views = calloc((size_t)plan->view_count, sizeof *study->views);
    if (!study->views)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for %d views", plan->view_count);
    for (int i = 0; i < plan->view_count; i++) {
        const char *name = pen_job_plan_view(plan, i);
        uint32_t view = 0;
        while (view < study->desc.view_count &&
               (!name || strcmp(study->desc.views[view].name, name) != 0))
            view++;
        if (view == study->desc.view_count)
            return pen_fail(st, PEN_INTERNAL, "the scene has no view %d", i);
        study->views[i] = (int)view;
    }
    return true;
}

static bool read_order(struct study *study, struct pen_status *st)
{
    const struct pen_job_plan *plan = &study->room->plan;
    struct pen_errors errors = {0};
    if (!pen_bench_spec_read(plan->request, &plan->settings, &study->order, &errors)) {
        *st = errors.item[0];
        return false;
    }
    study->bench = pen_bench_of_spec(&study->order);
    study->bench.desc = &study->desc;
    study->bench.views = study->views;
    study->bench.view_count = plan->view_count;
    study->bench.scene_cap_bytes = pen_scene_cache_cap(study->room->scenes);
    study->bench.pool = study->room->pool;
    study->bench.cancel = pen_heartbeat_flag(study->room->heart);
    study->bench.progress = tell;
    study->bench.user = study;
    return true;
}

static bool run(struct study *study, struct pen_status *st)
{
    struct pen_batch_room *room = study->room;
    study->bench.pixel_begins = pen_batch_look_on(room);
    study->bench.pixel_user = room;
    return pen_batch_looked(room, pen_bench_run(&study->bench, &study->result, st), st);
}

static bool write_report(struct study *study, struct pen_batch_work *work, struct pen_status *st)
{
    json_t *report = pen_bench_report(
        &study->bench, &study->result,
        pen_bench_spec_head(&study->order, &study->bench, &study->room->plan.settings));
    bool ok = report ? pen_study_write(report, "json", &work->artefact, st)
                     : pen_fail(st, PEN_NO_MEMORY, "no memory for a report");
    json_decref(report);
    work->result.layer = PEN_REPORT_LAYER;
    work->result.format = PEN_REPORT_FORMAT;
    work->result.artefact = work->artefact.data;
    work->result.artefact_bytes = work->artefact.bytes;
    return ok;
}

/* The statistics of the row that speed-ups refer to: those of its last counted run. */
static bool write_stats(struct study *study, struct pen_batch_work *work, struct pen_status *st)
{
    const struct pen_bench_outcome *row = &study->result.rows[study->order.baseline];
    struct pen_stats_input in = {.parse_ms = study->parse_ms,
                                 .build_ms = row->laps[study->order.repeats - 1].build_ms,
                                 .render = &row->stats,
                                 .accel = &row->accel};
    json_t *json = pen_stats_json(&in);
    if (json)
        json = pen_json_with(json, "tile_ms",
                             pen_tile_times(row->stats.tile_ms, row->stats.tile_count));
    return pen_batch_write_stats(study->room, json, work, st);
}

bool pen_batch_study(struct pen_batch_room *room, const struct pen_claim *claim,
                     struct pen_batch_work *work, struct pen_status *st)
{
    struct study study = {.room = room, .claim = claim};
    bool ok = read_scene(&study, st) && find_views(&study, st) && read_order(&study, st) &&
              run(&study, st) && write_report(&study, work, st) && write_stats(&study, work, st);
    pen_bench_result_release(&study.bench, &study.result);
    pen_bench_spec_release(&study.order);
    free(study.views);
    pen_arena_free(study.arena);
    return ok;
}
