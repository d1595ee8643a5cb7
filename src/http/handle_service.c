/* SPDX-License-Identifier: MIT */
/* The handlers of the service itself: health, readiness, workers, and the embedded files. */
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/routes.h"
#include "http/internal/static_files.h"

static const int64_t probe_again_ns = INT64_C(1000000000);
static const int64_t probe_late_ns = 5 * INT64_C(1000000000);

/* Finds the file that a path names. A file in a folder has the name "folder/file". */
static const struct static_file *find_file(const struct request *request, struct pen_status *st)
{
    const struct pen_target *target = &request->target;
    const int last = target->segment_count - 1;
    char name[64] = "page/index.html";
    if (request->arg)
        snprintf(name, sizeof name, "%s/%s", target->segment[last - 1], request->arg);
    else if (last >= 0)
        snprintf(name, sizeof name, "%s", target->segment[last]);
    const struct static_file *file = pen_http_static_files_find(request->http->static_files, name);
    if (!file)
        pen_fail(st, PEN_NOT_FOUND, "there is no built-in file \"%.80s\"%s", name,
                 strncmp(name, "scenes/", 7) == 0 ? "; GET /v1/scenes lists all scenes" : "");
    return file;
}

enum outcome pen_http_handle_file(struct request *request, struct pen_jobs *jobs)
{
    (void)jobs;
    struct pen_status st;
    const struct static_file *file = find_file(request, &st);
    if (!file)
        return pen_http_request_fail(request, &st);
    if (file->policy) {
        pen_http_reply_field(&request->reply, "Content-Security-Policy", "%s", file->policy);
        pen_http_reply_field(&request->reply, "Referrer-Policy", "no-referrer");
    }
    const struct content content = {.blob = pen_http_blob_ref(file->blob),
                                    .type = file->type,
                                    .etag = file->etag,
                                    .cache_control = "no-cache"};
    return pen_http_request_content(request, &content);
}

static enum outcome answer_health(struct request *request, const char *state)
{
    return pen_http_request_json(request, 200,
                                 json_pack("{s:s, s:s}", "status", state, "version", PEN_VERSION));
}

enum outcome pen_http_handle_healthz(struct request *request, struct pen_jobs *jobs)
{
    (void)jobs;
    return answer_health(request, "ok");
}

enum outcome pen_http_handle_workers(struct request *request, struct pen_jobs *jobs)
{
    struct pen_status st;
    json_t *workers = pen_jobs_workers(jobs, &st);
    return workers ? pen_http_request_json(request, 200, workers)
                   : pen_http_request_fail(request, &st);
}

/* Finds out whether a write reaches the disk. The last submit shows it (handle_jobs.c), else a
 * probe. There is at most one probe a second, so that a frequent monitor does not wear the disk. A
 * probe may wait until a large job is stored. Meanwhile other threads use the last result, if it is
 * recent. */
static void probe(struct pen_http *http, struct pen_jobs *jobs, struct pen_status *st)
{
    pthread_mutex_lock(&http->ready_lock);
    const int64_t age = http->ready_ns ? pen_clock_ns() - http->ready_ns : INT64_MAX;
    const bool known = age < probe_again_ns || (http->probing && age < probe_late_ns);
    *st = http->ready;
    http->probing = http->probing || !known;
    pthread_mutex_unlock(&http->ready_lock);
    if (known)
        return;
    *st = (struct pen_status){.code = PEN_OK};
    pen_store_intake(pen_jobs_store(jobs), st);
    pthread_mutex_lock(&http->ready_lock);
    http->probing = false;
    http->ready_ns = pen_clock_ns();
    http->ready = *st;
    pthread_mutex_unlock(&http->ready_lock);
}

/* Fails with the reason why the daemon is not ready. */
static bool check_ready(struct pen_http *http, struct pen_jobs *jobs, struct pen_status *st)
{
    struct pen_status fault;
    if (atomic_load_explicit(&http->draining, memory_order_relaxed))
        return pen_fail(st, PEN_UNAVAILABLE, "the daemon is draining");
    pthread_mutex_lock(&http->ready_lock);
    const bool ok =
        !http->not_ready_reason[0] || pen_fail(st, PEN_UNAVAILABLE, "%s", http->not_ready_reason);
    pthread_mutex_unlock(&http->ready_lock);
    if (!ok) /* after an I/O error, a probe might end this process too */
        return false;
    probe(http, jobs, &fault);
    if (fault.code != PEN_OK)
        return pen_fail(st, PEN_UNAVAILABLE, "the store does not take writes: %s", fault.msg);
    return !http->tokens || !pen_tokens_fault(http->tokens, &fault) ||
           pen_fail(st, PEN_UNAVAILABLE, "the token file cannot be used: %s", fault.msg);
}

enum outcome pen_http_handle_readyz(struct request *request, struct pen_jobs *jobs)
{
    struct pen_status st;
    if (check_ready(request->http, jobs, &st))
        return answer_health(request, "ready");
    pen_http_request_hide_reason(request, &st);
    return pen_http_request_fail(request, &st);
}
