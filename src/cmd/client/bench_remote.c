/* SPDX-License-Identifier: MIT */
#include "cmd/client/bench_remote.h"

#include "cmd/client/job_request.h"
#include "cmd/client/remote_job.h"
#include "cmd/report.h"

static bool make_request(const struct pen_bench_remote *remote, struct pen_job_request *request,
                         struct pen_errors *errors)
{
    const struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    json_t *scene = NULL;
    if (remote->source->xml && !(scene = pen_source_json(remote->source, &limits, errors)))
        return false;
    const bool ok = pen_job_request_wrap(request, remote->source, scene, remote->members, &st);
    if (!ok)
        pen_errors_add(errors, &st);
    json_decref(scene);
    return ok;
}

/* Submits the job. Returns the exit code. */
static int submit(const struct pen_bench_remote *remote, json_t **job)
{
    struct pen_job_request request = {0};
    struct pen_errors errors = {0};
    int code = 0;
    *job = NULL;
    if (!make_request(remote, &request, &errors))
        code = pen_report_errors_json(remote->source->label, remote->json, &errors);
    else if (!pen_job_request_post(remote->client, &request, job, &errors))
        code = pen_job_request_report(&request, remote->source, remote->json, &errors);
    pen_buf_release(&request.text);
    return code;
}

static int follow(const struct pen_bench_remote *remote, const char *id, json_t **report)
{
    struct pen_errors errors = {0};
    json_t *job;
    bool ok = pen_remote_wait(remote->client, id, remote->quiet, &job, &errors);
    const json_t *problem = json_object_get(job, "error");
    if (!ok && json_is_object(problem))
        errors.item[0].code =
            pen_problem_code(problem, (long)json_integer_value(json_object_get(problem, "status")));
    ok = ok && pen_remote_report(remote->client, id, report, &errors);
    json_decref(job);
    return ok ? 0 : pen_report_errors_json(NULL, remote->json, &errors);
}

int pen_bench_remote_run(const struct pen_bench_remote *remote, json_t **report)
{
    json_t *job;
    *report = NULL;
    int code = submit(remote, &job);
    if (code == 0) {
        if (!remote->quiet)
            pen_report_say(stderr, "penumbra: job %s", pen_remote_text(job, "id"));
        code = follow(remote, pen_remote_text(job, "id"), report);
    }
    json_decref(job);
    return code;
}
