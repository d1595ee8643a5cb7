/* SPDX-License-Identifier: MIT */
/* The first estimate of what a job will take, from which its first eta_seconds come: its budget, if
 * it has one. Else it is made once, before the job's first batch, where the bound of the job's rays
 * means more than ten seconds, which its batches tell (batch_layout.c). It is left out where it
 * would cost more than a thirtieth of the pixels, or more than ten seconds itself by that bound:
 * then the first batches, of a second each, tell soon enough.
 *
 * A job that is expected to take longer than the operator allows fails: by this estimate if even
 * the lower end of its interval is above, and later by the time that it has taken and, for what is
 * left, the pace of rendering. What comes before the first pixel (the scene, and the estimate
 * itself) says nothing about the others. Where there is an estimate, which is from all parts of a
 * picture, the pace counts when that is of a part that is not small. */
#include "jobs/internal/batch.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "jobs/internal/jobs.h"
#include "render/forecast.h"

enum {
    LONG_BATCHES = 10, /* of about a second each */
    TELLING_S = 10     /* the time after which what a job has done tells how long the rest takes */
};

/* The share of a job's pixels that tells more than its estimate. */
static const double TELLING_SHARE = 0.1;

static bool fail_expected(double seconds, const char *from, int max_seconds, struct pen_status *st)
{
    return pen_fail(st, PEN_TOO_LARGE,
                    "the job is expected to take %.0f s (%.3g hours), %s; this daemon allows %d s: "
                    "take fewer pixels, samples or lights, or ask its operator for more "
                    "(--max-seconds)",
                    seconds, seconds / 3600, from, max_seconds);
}

static bool is_wanted(const struct pen_batch_context *context, const struct pen_claim *claim)
{
    const struct pen_settings *s = &context->request.settings;
    const double views = context->request.view_count, pixels = views * s->width * s->height,
                 batches = views * claim->view_batches, share = PEN_FORECAST_QUICK_PIXELS / pixels;
    const bool first = context->fresh && claim->attempt == 1 && claim->view == 0 &&
                       claim->first_tile == 0 && share < 1.0 / 30;
    if (pen_stored_request_budget(&context->request) > 0)
        return false;
    if (pen_settings_adaptive(s)) /* a view is one batch, however long */
        return first;
    return first && batches > LONG_BATCHES && share * batches < LONG_BATCHES;
}

bool pen_batch_allowed(const struct pen_batch_context *context, const struct pen_forecast *forecast,
                       double times, struct pen_status *st)
{
    const int most_s = context->max_seconds;
    return most_s == 0 || times * forecast->time_ms.low <= 1000.0 * most_s ||
           fail_expected(times * forecast->time_ms.expected / 1000, "from some of its pixels",
                         most_s, st);
}

bool pen_batch_estimate(struct pen_batch_context *context, const struct pen_claim *claim,
                        const struct pen_scene *scene, struct pen_status *st)
{
    const struct pen_stored_request *request = &context->request;
    struct pen_status ignored;
    const struct pen_forecast_task task = {.scene = scene,
                                           .view = pen_batch_view(context, claim, scene, &ignored),
                                           .settings = &request->settings,
                                           .quick = true,
                                           .deadline_ns = pen_batch_forecast_end(context),
                                           .cancel = pen_heartbeat_cancel_flag(context->heart),
                                           .pixel_begins = pen_batch_pixel_hook(context),
                                           .pixel_user = context};
    const bool wanted = is_wanted(context, claim) && task.view >= 0;
    const double budget_s = pen_stored_request_budget(request),
                 with_layers = 1 + pen_batch_layer_work(context);
    struct pen_forecast forecast;
    if (context->fresh && budget_s > 0)
        pen_store_estimate(context->store, claim, (int64_t)ceil(1000 * budget_s * with_layers),
                           &ignored);
    context->fresh = false;
    if (!wanted)
        return true;
    if (!pen_batch_hook_done(context, pen_forecast_make(context->pool, &task, &forecast, st), st))
        return false;
    const double all_ms = forecast.time_ms.expected * request->view_count * with_layers;
    const bool allowed =
        pen_batch_allowed(context, &forecast, request->view_count * with_layers, st);
    const struct pen_log_about about = pen_claim_about(claim);
    pen_log_about(PEN_LOG_DEBUG, &about, "expected to take %.1f s", all_ms / 1000);
    pen_forecast_release(&forecast);
    if (allowed)
        pen_store_estimate(context->store, claim, (int64_t)ceil(all_ms), &ignored);
    return allowed;
}

void pen_batch_paced(struct pen_batch_context *context, const struct pen_claim *claim,
                     int64_t pixels, double ms)
{
    struct pen_batch_pace *pace = NULL;
    for (int i = 0; i < PEN_BATCH_PACES && !pace; i++)
        if (strcmp(context->pace[i].job_id, claim->job_id) == 0)
            pace = &context->pace[i];
    if (!pace) {
        pace = &context->pace[context->pace_next];
        context->pace_next = (context->pace_next + 1) % PEN_BATCH_PACES;
        *pace = (struct pen_batch_pace){.ms = 0};
        memcpy(pace->job_id, claim->job_id, sizeof pace->job_id);
    }
    pace->pixels += pixels;
    pace->ms += ms;
}

/* How long so many pixels of the job take at this worker's pace; 0 as long as it is not known. */
static double seconds_for(const struct pen_batch_context *context, const struct pen_claim *claim,
                          int64_t pixels)
{
    for (int i = 0; i < PEN_BATCH_PACES; i++) {
        const struct pen_batch_pace *pace = &context->pace[i];
        if (strcmp(pace->job_id, claim->job_id) == 0 && pace->ms >= 1000.0 * TELLING_S)
            return (double)pixels * pace->ms / 1000 / (double)pace->pixels;
    }
    return 0;
}

bool pen_batch_expected(struct pen_batch_context *context, const struct pen_claim *claim,
                        struct pen_status *st)
{
    const double spent_s = (double)claim->job_spent_us * 1e-6, most_s = context->max_seconds;
    struct pen_job_record job;
    struct pen_status ignored;
    if (context->max_seconds == 0 || claim->kind != PEN_BATCH_RENDER ||
        (spent_s < TELLING_S && spent_s <= most_s) ||
        !pen_batch_context_load(context, claim, &ignored) ||
        pen_stored_request_budget(&context->request) > 0 || /* which is bounded itself */
        !pen_store_job(context->store, claim->job_id, &job, &ignored))
        return true;
    const double share = (double)job.done_pixels / (double)job.total_pixels;
    const bool told = job.estimate_ms == 0 || share >= TELLING_SHARE;
    const double rest_s =
        told ? seconds_for(context, claim, job.total_pixels - job.done_pixels) : 0;
    pen_job_record_release(&job);
    char from[80];
    snprintf(from, sizeof from, "of which %.3g %% are done after %.0f s", 100 * share, spent_s);
    return spent_s + rest_s <= most_s ||
           fail_expected(spent_s + rest_s, from, context->max_seconds, st);
}
