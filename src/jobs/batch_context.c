/* SPDX-License-Identifier: MIT */
/* The state that a worker keeps between batches, and the hook before each pixel. */
#include "jobs/internal/batch_context.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"

void pen_batch_output_release(struct pen_batch_output *output)
{
    pen_buf_release(&output->artefact);
    free(output->rgb);
    free(output->stats);
    *output = (struct pen_batch_output){0};
}

void pen_batch_set_artefact(struct pen_batch_output *output, const char *layer, const char *format)
{
    output->result.layer = layer;
    output->result.format = format;
    output->result.artefact = output->artefact.data;
    output->result.artefact_bytes = output->artefact.bytes;
}

bool pen_batch_context_load(struct pen_batch_context *context, struct pen_status *st)
{
    struct pen_job_record job;
    if (strcmp(context->job_id, context->claim->job_id) == 0)
        return true;
    context->job_id[0] = '\0';
    context->store_ms = 0;
    pen_stored_request_release(&context->request);
    if (!pen_store_job(context->store, context->claim->job_id, &job, st))
        return false;
    bool ok = pen_stored_request_read(job.request, &context->request, st);
    context->fresh = job.done_pixels == 0 && job.estimate_ms == 0;
    context->work.expected_ms = (double)job.estimate_ms;
    pen_cost_map_release(&context->work.map);
    context->work.map = (struct pen_cost_map){.views = context->request.view_count,
                                              .width = context->request.settings.width,
                                              .height = context->request.settings.height};
    pen_job_record_release(&job);
    if (ok)
        memcpy(context->job_id, context->claim->job_id, sizeof context->job_id);
    return ok;
}

void pen_batch_context_drop_caches(struct pen_batch_context *context)
{
    pen_scene_cache_empty(context->scenes);
    free(context->image);
    context->image = NULL;
    context->image_pixels = 0;
}

void pen_batch_context_release(struct pen_batch_context *context)
{
    pen_stored_request_release(&context->request);
    pen_cost_map_release(&context->work.map);
    free(context->image);
}

int pen_batch_view(const struct pen_batch_context *context, int view, const struct pen_scene *scene,
                   struct pen_status *st)
{
    const char *name = pen_stored_request_view(&context->request, view);
    const int found = name ? pen_scene_find_view(scene, name) : -1;
    if (found < 0)
        pen_fail(st, PEN_INTERNAL, "the scene has no view %d", view);
    return found;
}

const struct pen_scene *pen_batch_scene(struct pen_batch_context *context, int *view,
                                        struct pen_scene_times *times, struct pen_status *st)
{
    const struct pen_scene *scene =
        pen_scene_cache_get(context->scenes, context->store, context->claim,
                            (enum pen_accelerator)context->request.settings.accelerator, times, st);
    *view = scene ? pen_batch_view(context, context->claim->view, scene, st) : -1;
    return *view >= 0 ? scene : NULL;
}

/* 1.5 times the time of a planned batch. */
enum { SPLIT_MS = 3000 };

void pen_batch_bound(struct pen_batch_context *context, double share)
{
    const int64_t ms = context->options->batch_ms > 0 ? context->options->batch_ms : SPLIT_MS;
    context->split_ns = pen_clock_ns() + (int64_t)((double)ms * share * 1e6);
}

bool pen_batch_is_long(void *user)
{
    const struct pen_batch_context *context = user;
    return pen_clock_ns() >= context->split_ns;
}

/* Below the ten seconds that a client waits for an explanation (http/handle_jobs.c). */
enum { FORECAST_S = 8 };

int64_t pen_batch_forecast_end(const struct pen_batch_context *context)
{
    const int64_t most = context->options->max_seconds;
    return pen_clock_ns() + (most > 0 && most < FORECAST_S ? most : FORECAST_S) * 1000000000;
}

bool pen_batch_is_overdue(const struct pen_batch_context *context)
{
    const double spent_s = (double)context->claim->job_spent_us * 1e-6 +
                           (double)(pen_clock_ns() - context->begun_ns) * 1e-9;
    return context->options->max_seconds > 0 && spent_s > context->options->max_seconds &&
           context->request.budget_s == 0;
}

bool pen_batch_fail_overdue(const struct pen_batch_context *context, struct pen_status *st)
{
    return pen_fail(st, PEN_TOO_LARGE,
                    "the job is not done after the %d s that this daemon allows: take a larger "
                    "target_error, fewer pixels, samples or lights, or ask its operator for more "
                    "(--max-seconds)",
                    context->options->max_seconds);
}

bool pen_batch_store(struct pen_batch_context *context, const char *layer, const char *format,
                     const struct pen_buf *data, struct pen_status *st)
{
    pen_heartbeat_pause(context->heart);
    const bool ok = pen_store_artefact_put(context->store, context->claim, layer, format,
                                           data->data, data->bytes, st);
    pen_heartbeat_resume(context->heart);
    return ok;
}

static void begin_pixel(void *user, int thread, int x, int y)
{
    struct pen_batch_context *context = user;
    const struct pen_worker_fault *fault = context->options->fault;
    if (context->options->trace)
        pen_trace_pixel(context->options->trace, thread, x, y);
    if (context->faulty && !fault->pixel(fault->user, x, y)) {
        atomic_store_explicit(&context->exhausted, true, memory_order_relaxed);
        pen_heartbeat_cancel(context->heart);
    }
}

pen_batch_pixel_fn *pen_batch_pixel_hook(struct pen_batch_context *context)
{
    const struct pen_worker_fault *fault = context->options->fault;
    const char *name = json_string_value(json_object_get(context->request.json, "name"));
    atomic_store_explicit(&context->exhausted, false, memory_order_relaxed);
    context->faulty = fault && fault->wanted(fault->user, name);
    return context->faulty || context->options->trace ? begin_pixel : NULL;
}

bool pen_batch_hook_done(struct pen_batch_context *context, bool ok, struct pen_status *st)
{
    if (context->options->trace)
        pen_trace_idle(context->options->trace);
    if (!ok && atomic_load_explicit(&context->exhausted, memory_order_relaxed))
        return pen_fail(st, PEN_NO_MEMORY, "out of memory while rendering");
    return ok;
}
