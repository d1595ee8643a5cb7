/* SPDX-License-Identifier: MIT */
/* An explanation in the worker, because the api process traces no ray. Its forecast has a high
 * priority, may be of a scene that no job could have, and does not yield. So it ends after some
 * seconds, with what is known by then. A render that is asked for with it is treated like a job: it
 * fails if it takes longer than the operator allows, or is expected to. */
#include <stdlib.h>

#include "base/clock.h"
#include "jobs/internal/study.h"
#include "study/explain.h"

struct explain {
    struct pen_study study;
    struct pen_scene *scene;
    double build_ms;
    struct pen_forecast forecast;
    struct pen_film *film;
    struct pen_render_stats stats; /* of the render, if there is one */
};

static bool freeze(struct explain *e, struct pen_status *st)
{
    const struct pen_batch_context *context = e->study.context;
    const int64_t begun_ns = pen_clock_ns();
    e->scene = pen_scene_freeze(&e->study.desc,
                                (enum pen_accelerator)context->request.settings.accelerator,
                                context->options->scene_cap_bytes, st);
    e->build_ms = pen_ms_since(begun_ns);
    return e->scene != NULL;
}

static bool forecast(struct explain *e, struct pen_status *st)
{
    struct pen_batch_context *context = e->study.context;
    const struct pen_forecast_task task = {.scene = e->scene,
                                           .view = e->study.views[0],
                                           .settings = &context->request.settings,
                                           .deadline_ns = pen_batch_forecast_end(context),
                                           .cancel = pen_heartbeat_cancel_flag(context->heart),
                                           .pixel_begins = pen_batch_pixel_hook(context),
                                           .pixel_user = context};
    const bool ok = pen_forecast_make(context->pool, &task, &e->forecast, st);
    if (ok)
        pen_study_progress(&e->study, 1, (int)e->study.context->claim->pixels);
    return pen_batch_hook_done(context, ok, st);
}

static bool is_overdue(void *user)
{
    const struct explain *e = user;
    return pen_batch_is_overdue(e->study.context);
}

static bool goes_on(void *user, const struct pen_adaptive *adaptive,
                    const struct pen_render_stats *stats)
{
    (void)adaptive;
    (void)stats;
    return !is_overdue(user);
}

/* Fails if the render had no time for all tiles, or for the next round. */
static bool check_whole(const struct explain *e, bool ok, struct pen_status *st)
{
    const struct pen_batch_context *context = e->study.context;
    const struct pen_settings *s = &context->request.settings;
    const bool cut = ok ? (int)e->stats.tile_count < pen_tile_count(s->width, s->height, s->tile)
                        : st->code == PEN_UNAVAILABLE;
    return cut ? pen_batch_fail_overdue(context, st) : ok;
}

static bool render(struct explain *e, struct pen_status *st)
{
    struct pen_batch_context *context = e->study.context;
    const struct pen_settings *settings = &context->request.settings;
    if (!context->request.analyze)
        return true;
    if (!pen_batch_allowed(context, &e->forecast.time_ms, 1, st))
        return false;
    if (!(e->film = pen_film_new(settings->width, settings->height, st)))
        return false;
    const struct pen_render_task task = {.scene = e->scene,
                                         .view = e->study.views[0],
                                         .settings = settings,
                                         .tile_count = -1,
                                         .rgb = e->film->rgb,
                                         .cancel = pen_heartbeat_cancel_flag(context->heart),
                                         .pixel_begins = pen_batch_pixel_hook(context),
                                         .pixel_user = context,
                                         .pause = is_overdue,
                                         .paused = goes_on,
                                         .pause_user = e,
                                         .keep_tile_ms = true};
    const bool ok = pen_render_run(context->pool, &task, &e->stats, st);
    return pen_batch_hook_done(context, check_whole(e, ok, st), st);
}

/* The statistics are those of the render; empty without a render. */
static bool write(struct explain *e, struct pen_batch_output *output, struct pen_status *st)
{
    struct pen_batch_context *context = e->study.context;
    const bool rendered = e->film != NULL;
    const struct pen_explain_task task = {.desc = &e->study.desc,
                                          .settings = &context->request.settings,
                                          .view = e->study.views[0],
                                          .forecast = &e->forecast,
                                          .actual = rendered ? &e->stats : NULL};
    json_t *json = pen_explain_json(&task);
    char *text = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(15)) : NULL;
    const bool ok = text && pen_buf_puts(&output->artefact, text);
    free(text);
    json_decref(json);
    if (!ok)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for an explanation");
    pen_batch_set_artefact(output, PEN_REPORT_LAYER, PEN_REPORT_FORMAT);
    return rendered
               ? pen_study_write_stats(&e->study, &e->stats, pen_accel_get_stats(e->scene->accel),
                                       e->build_ms, output, st)
               : pen_batch_write_stats(context, json_object(), output, st);
}

bool pen_batch_explain(struct pen_batch_context *context, struct pen_batch_output *output,
                       struct pen_status *st)
{
    struct explain e = {.scene = NULL};
    const bool ok = pen_study_begin(&e.study, context, st) && freeze(&e, st) && forecast(&e, st) &&
                    render(&e, st) && write(&e, output, st);
    pen_forecast_release(&e.forecast);
    free(e.stats.tile_ms);
    pen_film_free(e.film);
    pen_scene_free(e.scene);
    pen_study_end(&e.study);
    return ok;
}
