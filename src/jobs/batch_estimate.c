/* SPDX-License-Identifier: MIT */
/* The first estimate of a job's time. For a job with a budget it is the budget. For other jobs it
 * is made once, before the job's first batch:
 *   - A job gets a cost map of all its views if its bound of rays (batch_layout.c) means more than
 *     three seconds. The map takes 1/52 of the work.
 *   - A job with a target error, whose work depends on its noise, gets a forecast, unless the
 *     forecast would take more than a thirtieth of the pixels.
 *
 * A job that is expected to take longer than the operator allows fails. At first the lower end of
 * the estimate's interval decides. Later the sum of two times decides: the time that the job has
 * taken, and the time of the rest at the pace of rendering. The time before the first pixel (for
 * the scene and the estimate) does not count in the pace. An estimate is from all parts of a
 * picture; so if there is one, the pace counts only after a part that is not small. */
#include "jobs/internal/batch.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/log.h"
#include "jobs/internal/jobs.h"
#include "render/forecast.h"

enum { TELLING_S = 10 }; /* seconds after which the pace counts */

/* The number of rays that take three seconds on a slow machine. */
static const double LONG_RAYS = 18e6;

/* The share of a job's work from which on its pace counts more than its estimate. */
static const double TELLING_SHARE = 0.1;

static bool fail_expected(double seconds, const char *from, int max_seconds, struct pen_status *st)
{
    return pen_fail(st, PEN_TOO_LARGE,
                    "the job is expected to take %.0f s (%.3g hours), %s; this daemon allows %d s: "
                    "take fewer pixels, samples or lights, or ask its operator for more "
                    "(--max-seconds)",
                    seconds, seconds / 3600, from, max_seconds);
}

/* Returns true if the job can have a cost map. */
static bool is_long(const struct pen_batch_context *context)
{
    const struct pen_stored_request *request = &context->request;
    return !pen_settings_adaptive(&request->settings) && request->bound_rays > LONG_RAYS;
}

static bool is_first(const struct pen_batch_context *context)
{
    const struct pen_claim *claim = context->claim;
    return context->fresh && claim->attempt == 1 && claim->view == 0 && claim->first_tile == 0;
}

static bool wants_forecast(const struct pen_batch_context *context)
{
    const struct pen_settings *s = &context->request.settings;
    const double pixels = (double)context->request.view_count * s->width * s->height;
    return pen_settings_adaptive(s) && pixels > 30.0 * PEN_FORECAST_QUICK_PIXELS;
}

bool pen_batch_allowed(const struct pen_batch_context *context, const struct pen_estimate *time_ms,
                       double times, struct pen_status *st)
{
    const int most_s = context->options->max_seconds;
    return most_s == 0 || times * time_ms->low <= 1000.0 * most_s ||
           fail_expected(times * time_ms->expected / 1000, "from some of its pixels", most_s, st);
}

/* Makes the job's cost map. *time_ms is the time of all views. */
static bool make_map(struct pen_batch_context *context, const struct pen_forecast_task *task,
                     struct pen_estimate *time_ms, struct pen_status *st)
{
    const int views = context->request.view_count;
    int *view = malloc((size_t)views * sizeof *view);
    bool ok = view || pen_fail(st, PEN_NO_MEMORY, "no memory for %d views", views);
    for (int i = 0; ok && i < views; i++)
        ok = (view[i] = pen_batch_view(context, i, task->scene, st)) >= 0;
    ok = ok && pen_cost_map_make(context->pool, task, view, views, &context->work.map, st);
    *time_ms = context->work.map.time_ms;
    free(view);
    return ok;
}

/* Makes the forecast of one view. *time_ms is the time of all views, if they are alike. */
static bool make_forecast(struct pen_batch_context *context, const struct pen_forecast_task *task,
                          struct pen_estimate *time_ms, struct pen_status *st)
{
    const double views = context->request.view_count;
    struct pen_forecast forecast;
    if (!pen_forecast_make(context->pool, task, &forecast, st))
        return false;
    *time_ms = (struct pen_estimate){views * forecast.time_ms.expected,
                                     views * forecast.time_ms.low, views * forecast.time_ms.high};
    pen_forecast_release(&forecast);
    return true;
}

/* Stores the expected time and the map. A failure is ignored. */
static void store_estimate(struct pen_batch_context *context, double ms)
{
    struct pen_buf map = {0};
    struct pen_status ignored;
    const bool any = context->work.map.cell && pen_cost_map_save(&context->work.map, &map);
    context->work.expected_ms = ms;
    pen_store_estimate(context->store, context->claim, (int64_t)ceil(ms), any ? &map : NULL,
                       &ignored);
    pen_buf_release(&map);
}

/* Reads the map that another worker has made. Without a map, all pixels count the same. */
static void load_map(struct pen_batch_context *context)
{
    struct pen_buf map = {0};
    struct pen_status ignored;
    if (!context->work.map.cell && is_long(context) &&
        pen_store_cost_map(context->store, context->claim->job_id, &map, &ignored))
        pen_cost_map_load(map.data, map.bytes, &context->work.map);
    pen_buf_release(&map);
}

bool pen_batch_estimate(struct pen_batch_context *context, const struct pen_scene *scene, int view,
                        struct pen_status *st)
{
    const struct pen_forecast_task task = {.scene = scene,
                                           .view = view,
                                           .settings = &context->request.settings,
                                           .quick = true,
                                           .deadline_ns = pen_batch_forecast_end(context),
                                           .cancel = pen_heartbeat_cancel_flag(context->heart),
                                           .pixel_begins = pen_batch_pixel_hook(context),
                                           .pixel_user = context};
    const double budget_ms = 1000 * context->request.budget_s,
                 with_layers = 1 + pen_batch_layer_work(context);
    const bool first = is_first(context), has_map = is_long(context);
    struct pen_estimate time_ms;
    if (context->fresh && budget_ms > 0)
        store_estimate(context, budget_ms * with_layers);
    context->fresh = false;
    if (!first || budget_ms > 0 || !(has_map || wants_forecast(context))) {
        load_map(context);
        return true;
    }
    const bool made = has_map ? make_map(context, &task, &time_ms, st)
                              : make_forecast(context, &task, &time_ms, st);
    if (!pen_batch_hook_done(context, made, st))
        return false;
    const double all_ms = time_ms.expected * with_layers;
    const struct pen_log_about about = pen_claim_about(context->claim);
    pen_log_about(PEN_LOG_DEBUG, &about, "expected to take %.1f s", all_ms / 1000);
    if (!pen_batch_allowed(context, &time_ms, with_layers, st))
        return false;
    store_estimate(context, all_ms);
    return true;
}

/* Returns how long this part of the job's work takes at this worker's pace; 0 if the pace is not
 * known yet. */
static double seconds_for(const struct pen_batch_context *context, double work)
{
    const struct pen_batch_pace *pace = pen_batch_pace_of(context);
    return pace && pace->ms >= 1000.0 * TELLING_S && pace->work > 0
               ? work * pace->ms / 1000 / pace->work
               : 0;
}

bool pen_batch_expected(struct pen_batch_context *context, struct pen_status *st)
{
    const struct pen_claim *claim = context->claim;
    const double spent_s = (double)claim->job_spent_us * 1e-6,
                 most_s = context->options->max_seconds;
    struct pen_job_record job;
    struct pen_status ignored;
    if (context->options->max_seconds == 0 || claim->kind != PEN_BATCH_RENDER ||
        (spent_s < TELLING_S && spent_s <= most_s) || !pen_batch_context_load(context, &ignored) ||
        context->request.budget_s > 0 || /* which is bounded itself */
        !pen_store_job(context->store, claim->job_id, &job, &ignored))
        return true;
    const double share = (double)job.work / PEN_WORK_ALL;
    const bool told = !is_long(context) || share >= TELLING_SHARE;
    const double rest_s = told ? seconds_for(context, 1 - share) : 0;
    pen_job_record_release(&job);
    char from[80];
    snprintf(from, sizeof from, "of which %.3g %% are done after %.0f s", 100 * share, spent_s);
    return spent_s + rest_s <= most_s ||
           fail_expected(spent_s + rest_s, from, context->options->max_seconds, st);
}
