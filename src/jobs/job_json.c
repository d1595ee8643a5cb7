/* SPDX-License-Identifier: MIT */
/* The job object of http-api.md. What a client asked for was written down at submit as the stored
 * request; here what has become of it is put around that. Everything is a function of the stored
 * job, so one revision always reads the same. */
#include <string.h>

#include "base/clock.h"
#include "jobs/internal/jobs.h"

static json_t *time_json(int64_t ms)
{
    char text[25];
    if (ms == 0)
        return json_null();
    pen_clock_format(ms, text);
    return json_string(text);
}

/* From the rate since the job began, at the time of its last change. */
static json_t *eta_json(const struct pen_job_record *job)
{
    int64_t left = job->total_pixels - job->done_pixels;
    if (job->state == PEN_JOB_SUCCEEDED)
        return json_integer(0);
    if (job->state != PEN_JOB_RUNNING || job->done_pixels == 0)
        return json_null();
    double seconds = (double)(job->updated_ms - job->started_ms) / 1000;
    return json_real(seconds * (double)left / (double)job->done_pixels);
}

static json_t *progress_json(const struct pen_job_record *job)
{
    double fraction =
        job->total_pixels > 0 ? (double)job->done_pixels / (double)job->total_pixels : 0;
    return json_pack("{s:I, s:I, s:f, s:o}", "done", (json_int_t)job->done_pixels, "total",
                     (json_int_t)job->total_pixels, "fraction", fraction, "eta_seconds",
                     eta_json(job));
}

static json_t *links_json(const struct pen_job_record *job)
{
    const char *id = job->id, *at = "/v1/jobs/";
    if (strcmp(job->kind, "benchmark") == 0)
        return json_pack("{s:s+, s:s++, s:s++, s:s++, s:s++}", "self", at, id, "events", at, id,
                         "/events", "report", at, id, "/report", "stats", at, id, "/stats", "scene",
                         at, id, "/scene");
    return json_pack("{s:s+, s:s++, s:s++, s:s++, s:s++, s:s++}", "self", at, id, "events", at, id,
                     "/events", "image", at, id, "/image", "preview", at, id, "/preview", "stats",
                     at, id, "/stats", "scene", at, id, "/scene");
}

/* A stored text as JSON; what is there was written by this program. */
static json_t *stored_json(const char *text, struct pen_status *st)
{
    json_error_t error;
    json_t *json = text ? json_loads(text, 0, &error) : json_null();
    if (!json)
        pen_fail(st, PEN_STORAGE, "a stored job is damaged: %s", error.text);
    return json;
}

static json_t *state_json(const struct pen_job_record *job, json_t *error)
{
    return json_pack("{s:s, s:s, s:I, s:o, s:o, s:o, s:o, s:i, s:o, s:o}", "id", job->id, "state",
                     pen_job_state_name(job->state), "revision", (json_int_t)job->revision,
                     "created_at", time_json(job->created_ms), "started_at",
                     time_json(job->started_ms), "finished_at", time_json(job->finished_ms),
                     "progress", progress_json(job), "attempts", job->attempts, "error", error,
                     "links", links_json(job));
}

json_t *pen_job_json(const struct pen_job_record *job, struct pen_status *st)
{
    json_t *request = stored_json(job->request, st);
    json_t *error = request ? stored_json(job->error, st) : NULL;
    if (!error) {
        json_decref(request);
        return NULL;
    }
    json_t *json = state_json(job, error);
    if (!json || json_object_update(json, request) != 0) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for a job");
        json_decref(json);
        json = NULL;
    }
    json_decref(request);
    return json;
}

bool pen_job_plan_read(const char *request, struct pen_job_plan *plan, struct pen_status *st)
{
    struct pen_errors errors = {0};
    *plan = (struct pen_job_plan){.settings = pen_settings_default()};
    plan->request = stored_json(request, st);
    if (!plan->request)
        return false;
    const char *kind = json_string_value(json_object_get(plan->request, "kind"));
    plan->benchmark = kind && strcmp(kind, "benchmark") == 0;
    plan->view_count = (int)json_array_size(json_object_get(plan->request, "views"));
    json_t *render = json_object_get(plan->request, "render");
    if (plan->view_count > 0 && render &&
        pen_settings_read(render, "/render", &plan->settings, &errors))
        return true;
    json_decref(plan->request);
    plan->request = NULL;
    return pen_fail(st, PEN_STORAGE, "a stored job is damaged: %s",
                    errors.count ? errors.item[0].msg : "no views or settings");
}

const char *pen_job_plan_view(const struct pen_job_plan *plan, int view)
{
    return json_string_value(json_array_get(json_object_get(plan->request, "views"), (size_t)view));
}

int pen_job_plan_find_view(const struct pen_job_plan *plan, const char *name)
{
    for (int view = 0; view < plan->view_count; view++) {
        if (strcmp(pen_job_plan_view(plan, view), name) == 0)
            return view;
    }
    return -1;
}
