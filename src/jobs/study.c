/* SPDX-License-Identifier: MIT */
#include "jobs/internal/study.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "film/film.h"
#include "report/report.h"

enum { PROGRESS_MS = 250 };          /* the shortest time between two reports of progress */
enum { KEEP_MS = 250, ASK_MS = 50 }; /* shortest times between two states, two questions */

static size_t picture_bytes(int width, int height)
{
    return 3 * (size_t)width * (size_t)height * sizeof(float);
}

static bool read_scene(struct pen_study *study, struct pen_status *st)
{
    struct pen_batch_context *context = study->context;
    const int64_t begun_ns = pen_clock_ns();
    study->arena = pen_arena_new(context->options->scene_cap_bytes);
    if (!study->arena)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a scene");
    const bool ok = pen_scene_describe(context->store, study->context->claim->job_id, study->arena,
                                       &study->desc, st);
    study->parse_ms = pen_ms_since(begun_ns);
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
                     struct pen_status *st)
{
    *study =
        (struct pen_study){.context = context, .keeper = pen_keeper_make(context, KEEP_MS, ASK_MS)};
    return read_scene(study, st) && find_views(study, st);
}

void pen_study_end(struct pen_study *study)
{
    free(study->views);
    json_decref(study->kept_state);
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
    pen_heartbeat_pause(study->context->heart);
    struct pen_claim claim = *study->context->claim;
    claim.spent_us = pen_heartbeat_spent_us(study->context->heart);
    const double share = (double)done / total,
                 ms = (double)(claim.job_spent_us + claim.spent_us) / 1000;
    claim.estimate_ms =
        pen_work_estimate_ms(ms, share, pen_work_pace(share, ms, study->context->work.expected_ms));
    pen_store_keep(store, &claim, &(struct pen_kept){.done = done}, NULL, &ignored);
    pen_heartbeat_resume(study->context->heart);
}

struct part_name {
    char text[24];
};

static struct part_name name_of(int place)
{
    struct part_name name;
    snprintf(name.text, sizeof name.text, "picture-%d", place);
    return name;
}

/* Keeps a state with the pictures that the store does not have yet. NULL: there was no memory for
 * it. Returns true if the study goes on. */
static bool keep_state(struct pen_study *study, const struct pen_unfinished *u, const char *state,
                       int64_t begun_ns)
{
    struct pen_kept_part parts[PEN_STUDY_PICTURES_MAX];
    struct part_name names[PEN_STUDY_PICTURES_MAX];
    struct pen_kept kept = {
        .done = u->done, .data = state, .bytes = state ? strlen(state) : 0, .parts = parts};
    bool gives_way;
    for (int i = 0; i < u->picture_count; i++) {
        const struct pen_study_picture *picture = &u->picture[i];
        if (!picture->rgb || picture->hash == study->picture_hash[i])
            continue;
        names[i] = name_of(i);
        parts[kept.part_count++] =
            (struct pen_kept_part){.name = names[i].text,
                                   .data = picture->rgb,
                                   .bytes = picture_bytes(u->width, u->height)};
    }
    const bool ok = pen_keeper_keep(&study->keeper, state ? &kept : NULL, begun_ns, &gives_way);
    for (int i = 0; ok && i < u->picture_count; i++)
        if (u->picture[i].rgb)
            study->picture_hash[i] = u->picture[i].hash;
    return !gives_way;
}

/* Keeps the study, if that is due: pen_between_fn; `user` is the study. A failure is ignored. */
static bool keep(void *user, const struct pen_unfinished *unfinished)
{
    struct pen_study *study = user;
    if (!pen_keeper_is_due(&study->keeper))
        return true;
    const int64_t begun_ns = pen_clock_ns();
    json_t *json = unfinished->state(unfinished->study);
    char *text = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    const bool goes_on = keep_state(study, unfinished, text, begun_ns);
    free(text);
    json_decref(json);
    return goes_on;
}

static bool read_picture(void *user, int place, uint64_t hash, int width, int height, float *rgb)
{
    struct pen_study *study = user;
    struct pen_status ignored;
    struct pen_buf picture = {0};
    const struct pen_film film = {width, height, rgb};
    const bool there = pen_store_kept(study->context->store, study->context->claim,
                                      name_of(place).text, &picture, &ignored) &&
                       picture.bytes == picture_bytes(width, height);
    if (there)
        memcpy(rgb, picture.data, picture.bytes);
    pen_buf_release(&picture);
    if (!there || pen_film_hash(&film) != hash)
        return false;
    study->picture_hash[place] = hash;
    return true;
}

struct pen_study_frame pen_study_frame_of(struct pen_study *study, void *user)
{
    struct pen_batch_context *context = study->context;
    struct pen_buf text = {0};
    struct pen_status ignored;
    if (pen_store_kept(context->store, context->claim, PEN_KEPT_STATE, &text, &ignored))
        study->kept_state = json_loadb((const char *)text.data, text.bytes, 0, NULL);
    pen_buf_release(&text);
    study->kept =
        (struct pen_kept_study){.state = study->kept_state, .picture = read_picture, .user = study};
    return (struct pen_study_frame){.desc = &study->desc,
                                    .scene_cap_bytes = context->options->scene_cap_bytes,
                                    .pool = context->pool,
                                    .cancel = pen_heartbeat_cancel_flag(context->heart),
                                    .progress = pen_study_progress,
                                    .between = keep,
                                    .user = user,
                                    .kept = &study->kept,
                                    .pixel_begins = pen_batch_pixel_hook(context),
                                    .pixel_user = context};
}

bool pen_study_store_report(struct pen_study *study, const json_t *report,
                            const struct pen_buf *figures, struct pen_batch_output *output,
                            struct pen_status *st)
{
    struct pen_buf page = {0};
    const bool ok =
        pen_report_write(report, PEN_REPORT_FORMAT, NULL, &output->artefact, st) &&
        (!figures || (pen_report_write(report, "html", figures, &page, st) &&
                      pen_batch_store(study->context, PEN_REPORT_LAYER, "html", &page, st)));
    pen_buf_release(&page);
    pen_batch_set_artefact(output, PEN_REPORT_LAYER, PEN_REPORT_FORMAT);
    return ok;
}

bool pen_study_write_stats(const struct pen_study *study, const struct pen_render_stats *render,
                           const struct pen_accel_stats *accel, double build_ms,
                           struct pen_batch_output *output, struct pen_status *st)
{
    const struct pen_stats_input in = {
        .parse_ms = study->parse_ms, .build_ms = build_ms, .render = render, .accel = accel};
    return pen_batch_write_render_stats(study->context, &in, output, st);
}
