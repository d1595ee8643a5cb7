/* SPDX-License-Identifier: MIT */
/* The first estimate of what a job will take, from which its first eta_seconds come. It is made
 * once, before the job's first batch, where the bound of the job's rays means more than ten
 * seconds, which its batches tell (batch_layout.c). It is left out where it would cost more than a
 * thirtieth of the pixels, or more than ten seconds itself by that bound: then the first batches,
 * of a second each, tell soon enough. */
#include "jobs/internal/batch.h"

#include <math.h>

#include "base/log.h"
#include "jobs/internal/jobs.h"
#include "render/forecast.h"

enum { LONG_BATCHES = 10 }; /* of about a second each */

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

bool pen_batch_estimate(struct pen_batch_context *context, const struct pen_claim *claim,
                        const struct pen_scene *scene, struct pen_status *st)
{
    const struct pen_stored_request *request = &context->request;
    const char *name = pen_stored_request_view(request, claim->view);
    const struct pen_forecast_task task = {.scene = scene,
                                           .view = name ? pen_scene_find_view(scene, name) : -1,
                                           .settings = &request->settings,
                                           .quick = true,
                                           .cancel = pen_heartbeat_cancel_flag(context->heart),
                                           .pixel_begins = pen_batch_pixel_hook(context),
                                           .pixel_user = context};
    const bool wanted = is_wanted(context, claim) && task.view >= 0;
    struct pen_forecast forecast;
    struct pen_status ignored;
    context->fresh = false;
    if (!wanted)
        return true;
    if (!pen_batch_hook_done(context, pen_forecast_make(context->pool, &task, &forecast, st), st))
        return false;
    const double all_ms = forecast.time_ms.expected * request->view_count;
    const struct pen_log_about about = pen_claim_about(claim);
    pen_log_about(PEN_LOG_DEBUG, &about, "expected to take %.1f s", all_ms / 1000);
    pen_forecast_release(&forecast);
    pen_store_estimate(context->store, claim, (int64_t)ceil(all_ms), &ignored);
    return true;
}
