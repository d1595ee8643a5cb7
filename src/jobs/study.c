/* SPDX-License-Identifier: MIT */
#include "jobs/internal/study.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "io/stats_json.h"
#include "jobs/internal/stats.h"

enum { PROGRESS_MS = 250 }; /* the shortest time between two reports of progress */

static bool read_scene(struct pen_study *study, struct pen_status *st)
{
    struct pen_batch_context *context = study->context;
    const int64_t begun_ns = pen_clock_ns();
    study->arena = pen_arena_new(pen_scene_cache_cap(context->scenes));
    if (!study->arena)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a scene");
    const bool ok =
        pen_scene_describe(context->store, study->claim->job_id, study->arena, &study->desc, st);
    study->parse_ms = (double)(pen_clock_ns() - begun_ns) * 1e-6;
    return ok;
}

static bool find_views(struct pen_study *study, struct pen_status *st)
{
    const struct pen_stored_request *request = &study->context->request;
    study->views = calloc((size_t)request->view_count, sizeof *study->views);
    if (!study->views)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for %d views", request->view_count);
    for (int i = 0; i < request->view_count; i++) {
        const char *name = pen_stored_request_view(request, i);
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

bool pen_study_begin(struct pen_study *study, struct pen_batch_context *context,
                     const struct pen_claim *claim, struct pen_status *st)
{
    *study = (struct pen_study){.context = context, .claim = claim};
    return read_scene(study, st) && find_views(study, st);
}

void pen_study_end(struct pen_study *study)
{
    free(study->views);
    pen_arena_free(study->arena);
}

void pen_study_progress(void *user, int done, int total)
{
    struct pen_study *study = user;
    struct pen_store *store = study->context->store;
    struct pen_status ignored;
    const int64_t now_ns = pen_clock_ns();
    if (done > 0 && done < total && now_ns - study->progress_ns < (int64_t)PROGRESS_MS * 1000000)
        return;
    study->progress_ns = now_ns;
    pen_store_progress(store, study->claim, done, &ignored);
    if (pen_store_checkpoint_due(store)) /* no run is timed at this moment */
        pen_store_checkpoint(store, &ignored);
}

void pen_study_set_report(struct pen_batch_output *output)
{
    output->result.layer = PEN_REPORT_LAYER;
    output->result.format = PEN_REPORT_FORMAT;
    output->result.artefact = output->artefact.data;
    output->result.artefact_bytes = output->artefact.bytes;
}

bool pen_study_write_stats(const struct pen_study *study, const struct pen_render_stats *render,
                           const struct pen_accel_stats *accel, double build_ms,
                           struct pen_batch_output *output, struct pen_status *st)
{
    const struct pen_stats_input in = {
        .parse_ms = study->parse_ms, .build_ms = build_ms, .render = render, .accel = accel};
    json_t *json = pen_stats_json(&in);
    if (json)
        json = pen_json_with(json, "tile_ms", pen_tile_times(render->tile_ms, render->tile_count));
    return pen_batch_write_stats(study->context, json, output, st);
}
