/* SPDX-License-Identifier: MIT */
/* The job object has two parts: the stored request, which submit.c wrote, and the state of the job,
 * which is added here. Both depend only on the stored job, so a revision of a job always has the
 * same text. */
#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "io/json_build.h"
#include "jobs/internal/job_json.h"
#include "jobs/internal/stored_request.h"

json_t *pen_time_json(int64_t wall_ms)
{
    char text[25];
    if (wall_ms == 0)
        return json_null();
    pen_clock_format(wall_ms, text);
    return json_string(text);
}

/* Returns the seconds left when the job's work was last reported; null if not known. The workers'
 * time that is left is scaled by the elapsed time for each second of workers' time so far, because
 * workers share their time among jobs, and several may work on one job. */
static json_t *eta_json(const struct pen_job_record *job)
{
    const double spent_ms = (double)job->told_us / 1000,
                 passed_ms = (double)(job->told_elapsed_us - job->queue_us) / 1000,
                 left_ms = fmax(0, (double)job->estimate_ms - spent_ms),
                 sharing = spent_ms > 0 ? passed_ms / spent_ms : 1,
                 work = (double)job->work / PEN_WORK_ALL;
    if (job->state == PEN_JOB_SUCCEEDED)
        return json_integer(0);
    if (job->state != PEN_JOB_RUNNING || (job->estimate_ms == 0 && work == 0))
        return json_null();
    return json_real(
        (job->estimate_ms > 0 ? left_ms * sharing : passed_ms * fmax(0, 1 - work) / work) / 1000);
}

static json_t *progress_json(const struct pen_job_record *job)
{
    const double work = fmin(1, (double)job->work / PEN_WORK_ALL);
    return json_pack("{s:I, s:I, s:f, s:o}", "done", (json_int_t)job->done_pixels, "total",
                     (json_int_t)job->total_pixels, "fraction",
                     job->state == PEN_JOB_SUCCEEDED ? 1 : work, "eta_seconds", eta_json(job));
}

static json_t *links_json(const struct pen_job_record *job)
{
    static const char *const of_report[] = {"events", "report", "stats", "scene", NULL};
    static const char *const of_picture[] = {"events", "image", "preview", "stats", "scene", NULL};
    enum pen_job_kind kind;
    const bool report = pen_job_kind_of_name(job->kind, &kind) && pen_job_kind_has_report(kind);
    json_t *links = json_pack("{s:s+}", "self", "/v1/jobs/", job->id);
    for (const char *const *name = report ? of_report : of_picture; *name; name++)
        links = pen_json_with(links, *name, json_sprintf("/v1/jobs/%s/%s", job->id, *name));
    return links;
}

static json_t *state_json(const struct pen_job_record *job, json_t *error)
{
    return json_pack("{s:s, s:s, s:I, s:o, s:o, s:o, s:o, s:i, s:o, s:o}", "id", job->id, "state",
                     pen_job_state_name(job->state), "revision", (json_int_t)job->revision,
                     "created_at", pen_time_json(job->created_ms), "started_at",
                     pen_time_json(job->started_ms), "finished_at", pen_time_json(job->finished_ms),
                     "progress", progress_json(job), "attempts", job->attempts, "error", error,
                     "links", links_json(job));
}

json_t *pen_job_json_with(const struct pen_job_record *job, json_t *request, struct pen_status *st)
{
    json_t *error = pen_stored_json(job->error, st);
    if (!error)
        return NULL;
    json_t *json = state_json(job, error);
    if (json && json_object_update(json, request) == 0) {
        json_object_del(json, "bound_rays"); /* for workers alone */
        return json;
    }
    pen_fail(st, PEN_NO_MEMORY, "no memory for a job");
    json_decref(json);
    return NULL;
}

json_t *pen_job_json(const struct pen_job_record *job, struct pen_status *st)
{
    json_t *request = pen_stored_json(job->request, st);
    json_t *json = request ? pen_job_json_with(job, request, st) : NULL;
    json_decref(request);
    return json;
}
