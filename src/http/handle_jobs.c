/* SPDX-License-Identifier: MIT */
/* The handlers that submit, read, list, cancel, delete, validate and explain jobs. */
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/routes.h"
#include "http/internal/snapshot_cache.h"
#include "http/internal/watch.h"
#include "io/document.h"

enum { EXPLAIN_WAIT_S = 10 }; /* after this time the answer to an explain is the job */

/* Adds a hint to the first error if the body seems to have lost its line breaks, which curl -d
 * removes. All places are then on line 1. The signs are curl's default type, one line, and
 * indentation between elements or a great length. */
static void hint_at_lost_lines(const struct request *request, struct pen_errors *errors)
{
    enum { LONG_LINE = 200 };
    const char *text = (const char *)request->body.data;
    const size_t bytes = request->body.bytes;
    if (!request->fields.content_type || errors->count == 0 || !text ||
        pen_media_parse(request->fields.content_type) != PEN_MEDIA_NONE ||
        !pen_text_is_xml(text, bytes) || memchr(text, '\n', bytes) ||
        (bytes <= LONG_LINE && !pen_text_is_utf16(text, bytes) && !memmem(text, bytes, ">  ", 3) &&
         !memmem(text, bytes, ">\t", 2)))
        return;
    char *message = errors->item[0].msg;
    const size_t used = strlen(message);
    snprintf(message + used, sizeof errors->item[0].msg - used,
             "; the body has no line breaks: curl -d removes them, curl --data-binary does not");
}

static enum outcome answer_errors(struct request *request, struct pen_errors *errors)
{
    hint_at_lost_lines(request, errors);
    const enum pen_code code = errors->count ? errors->item[0].code : PEN_INTERNAL;
    struct pen_buf text = {0};
    pen_problem_list_write(&text, errors, request->id);
    pen_http_reply_problem(&request->reply, pen_code_http(code), pen_http_blob_take(&text));
    return OUTCOME_ANSWERED;
}

/* Reads the body as a submission. A body without a type is XML if it begins like XML. */
static struct pen_submission read_submission(const struct request *request)
{
    struct pen_submission in = {.body = request->body.data ? (const char *)request->body.data : "",
                                .bytes = request->body.bytes,
                                .client_is_shared = request->address_is_shared,
                                .traceparent = request->fields.traceparent,
                                .idempotency_key = request->fields.idempotency_key};
    enum pen_media media = pen_media_parse(request->fields.content_type);
    in.xml =
        media == PEN_MEDIA_XML || (media == PEN_MEDIA_NONE && pen_text_is_xml(in.body, in.bytes));
    return in;
}

/* Notes for /readyz whether the store took a job. A stored job proves as much as a probe. If the
 * store refused a job, the next /readyz probes it. */
static void note_readiness(struct pen_http *http, const struct pen_errors *errors)
{
    const enum pen_code code = errors->count ? errors->item[0].code : PEN_OK;
    if (code != PEN_OK && code != PEN_STORAGE && code != PEN_STORAGE_FULL)
        return;
    pthread_mutex_lock(&http->ready_lock);
    http->ready_ns = code == PEN_OK ? pen_clock_ns() : 0;
    if (code == PEN_OK)
        http->ready = (struct pen_status){.code = PEN_OK};
    pthread_mutex_unlock(&http->ready_lock);
}

/* Makes a job of the body. Returns whether there is one; otherwise the request is answered. */
static bool submit(struct request *request, struct pen_jobs *jobs, bool explain,
                   struct pen_submitted *out)
{
    char client[CLIENT_BYTES];
    struct pen_submission in = read_submission(request);
    struct pen_errors errors = {0};
    in.client = pen_http_request_client(request, client);
    in.explain = explain;
    if (explain)
        in.idempotency_key = NULL;
    const bool ok = pen_jobs_submit(jobs, &in, out, &errors);
    if (!ok || !out->repeated)
        note_readiness(request->http, &errors);
    if (!ok) {
        answer_errors(request, &errors);
        return false;
    }
    memcpy(request->job_id, out->id, sizeof request->job_id);
    request->changed = !out->repeated;
    return true;
}

/* Answers with a job that has not ended. */
static enum outcome answer_accepted(struct request *request, struct blob *job)
{
    pen_http_reply_body(&request->reply, 202, job, "application/json");
    pen_http_reply_field(&request->reply, "Location", "/v1/jobs/%s", request->job_id);
    pen_http_reply_field(&request->reply, "Retry-After", "1");
    return OUTCOME_ANSWERED;
}

enum outcome pen_http_handle_submit(struct request *request, struct pen_jobs *jobs)
{
    struct pen_submitted out = {0};
    if (!submit(request, jobs, false, &out))
        return OUTCOME_ANSWERED;
    return answer_accepted(request, pen_http_blob_take(&out.answer));
}

enum outcome pen_http_handle_validate(struct request *request, struct pen_jobs *jobs)
{
    struct pen_submission in = read_submission(request);
    struct pen_errors errors = {0};
    json_t *answer = NULL;
    if (!pen_jobs_validate(jobs, &in, &answer, &errors))
        return answer_errors(request, &errors);
    return pen_http_request_json(request, 200, answer);
}

bool pen_http_quick_job(struct request *request)
{
    struct snapshot snapshot;
    struct pen_http *http = request->http;
    if (!pen_http_snapshot_cache_peek(http->snapshot_cache, pen_store_changes(), request->job_id,
                                      &snapshot))
        return false;
    bool due = pen_http_request_number(request, "wait", 0) == 0 ||
               pen_http_snapshot_is_due(&snapshot, request);
    if (due)
        pen_http_snapshot_reply(&snapshot, request);
    pen_http_snapshot_release(&snapshot);
    return due;
}

/* Answers with the error of a failed job. */
static void answer_error(struct request *request, const struct snapshot *snapshot)
{
    const struct pen_buf *text = &snapshot->json->content;
    json_t *job = json_loadb((const char *)text->data, text->bytes, 0, NULL);
    json_t *error = json_object_get(job, "error");
    json_object_set_new(error, "request_id", json_string(request->id));
    pen_http_reply_problem(&request->reply,
                           (int)json_integer_value(json_object_get(error, "status")),
                           pen_http_blob_json(error));
    json_decref(job);
}

/* Cancels and deletes a job, since its only client has gone. */
static void drop_job(struct request *request, struct pen_jobs *jobs)
{
    struct pen_job_snapshot job;
    struct pen_status st;
    if (pen_jobs_cancel(jobs, request->job_id, NULL, &job, &st)) {
        json_decref(job.json);
        pen_jobs_delete(jobs, request->job_id, NULL, false, &st);
    }
    pen_fail(&st, PEN_UNAVAILABLE, "the client closed its side before the explanation");
    pen_http_request_fail(request, &st);
}

/* Answers with the explanation, the error of a failed job, or the job if it takes long. The job of
 * an explanation is deleted when it was answered or cancelled. A failed job stays, since its error
 * says how to repeat it from the job's scene. */
static void answer_explanation(struct request *request, struct pen_jobs *jobs,
                               const struct snapshot *snapshot)
{
    struct reply *reply = &request->reply;
    struct pen_image report = {0};
    struct pen_status st;
    if (!pen_job_state_ended(snapshot->state)) {
        if (request->gone)
            drop_job(request, jobs);
        else
            answer_accepted(request, pen_http_blob_ref(snapshot->json));
        return;
    }
    if (snapshot->state == PEN_JOB_FAILED)
        answer_error(request, snapshot);
    else if (pen_jobs_report(jobs, request->job_id, "json", &report, &st))
        pen_http_reply_body(reply, 200, pen_http_blob_take(&report.bytes), report.type);
    else
        pen_http_request_fail(request, &st);
    if (reply->status != 200)
        pen_http_reply_field(reply, "Location", "/v1/jobs/%s", request->job_id);
    if ((reply->status == 200 && !reply->failed) || snapshot->state == PEN_JOB_CANCELLED)
        pen_jobs_delete(jobs, request->job_id, NULL, false,
                        &st); /* if this fails, the list keeps the job */
}

/* Reads the job. Answers, or gives the request to the watcher until its deadline. */
static enum outcome read_or_wait(struct request *request, struct pen_jobs *jobs)
{
    struct pen_http *http = request->http;
    const bool explains = request->route->handle_again;
    const uint32_t changes = pen_store_changes();
    enum watch_result result = WATCH_CLOSED;
    struct snapshot snapshot;
    struct pen_status st;
    if (!pen_http_snapshot_cache_read(http->snapshot_cache, changes, jobs, request->job_id,
                                      &snapshot, &st))
        return pen_http_request_fail(request, &st);
    if (pen_clock_ns() < request->deadline_ns && !pen_http_snapshot_is_due(&snapshot, request))
        result = pen_http_watch_add(http->watch, request, changes);
    /* A request that the watcher has accepted must not be touched here any more. */
    if (result != WATCH_ACCEPTED && explains) {
        answer_explanation(request, jobs, &snapshot); /* its job exists in any case */
    } else if (result == WATCH_CLOSED) {
        pen_http_snapshot_reply(&snapshot, request);
    } else if (result == WATCH_FULL) {
        pen_fail(&st, PEN_UNAVAILABLE, "%d requests are waiting already; try again later",
                 WATCH_MAX);
        pen_http_request_fail(request, &st);
    }
    pen_http_snapshot_release(&snapshot);
    return result == WATCH_ACCEPTED ? OUTCOME_WATCHED : OUTCOME_ANSWERED;
}

enum outcome pen_http_handle_job(struct request *request, struct pen_jobs *jobs)
{
    const long wait = pen_http_request_number(request, "wait", 0);
    request->deadline_ns = request->begun_ns + wait * INT64_C(1000000000);
    return read_or_wait(request, jobs);
}

/* The first call makes the job and waits for it, the second one answers. */
enum outcome pen_http_handle_explain(struct request *request, struct pen_jobs *jobs)
{
    if (!request->job_id[0]) {
        struct pen_submitted out = {0};
        if (!submit(request, jobs, true, &out))
            return OUTCOME_ANSWERED;
        pen_buf_release(&out.answer);
        pen_http_request_drop_body(request);
        request->fields.if_none_match = NULL; /* has no meaning for a POST */
        request->deadline_ns = pen_clock_ns() + EXPLAIN_WAIT_S * INT64_C(1000000000);
    }
    return read_or_wait(request, jobs);
}

/* Appends name=value, percent-encoded, if the query of this request has the parameter. */
static void add_param(struct pen_buf *query, const char *name, const char *value)
{
    static const char plain[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";
    if (!value)
        return;
    pen_buf_printf(query, "%s%s=", query->bytes ? "&" : "", name);
    for (; *value; value++)
        pen_buf_printf(query, strchr(plain, *value) ? "%c" : "%%%02X", (unsigned char)*value);
}

static void link_next(struct request *request, const char *next)
{
    struct pen_buf query = {0};
    for (const struct param_rule *rule = request->route->params; rule->name; rule++) {
        const bool is_cursor = strcmp(rule->name, "cursor") == 0;
        add_param(&query, rule->name,
                  is_cursor ? next : pen_http_request_param(request, rule->name));
    }
    if (query.failed)
        request->reply.failed = true;
    else
        pen_http_reply_field(&request->reply, "Link", "</v1/jobs?%s>; rel=\"next\"",
                             (const char *)query.data);
    pen_buf_release(&query);
}

enum outcome pen_http_handle_list(struct request *request, struct pen_jobs *jobs)
{
    const char *state_name = pen_http_request_param(request, "state");
    enum pen_job_state state;
    struct pen_list_query query = {.state = -1,
                                   .kind = pen_http_request_param(request, "kind"),
                                   .name = pen_http_request_param(request, "name"),
                                   .label = pen_http_request_param(request, "label"),
                                   .limit = (int)pen_http_request_number(request, "limit", 50),
                                   .cursor = pen_http_request_param(request, "cursor")};
    if (state_name && pen_job_state_of_name(state_name, &state))
        query.state = (int)state;
    struct pen_status st;
    json_t *list = pen_jobs_list(jobs, &query, &st);
    if (!list)
        return pen_http_request_fail(request, &st);
    const char *next = json_string_value(json_object_get(list, "next"));
    if (next)
        link_next(request, next);
    return pen_http_request_json(request, 200, list);
}

enum outcome pen_http_handle_cancel(struct request *request, struct pen_jobs *jobs)
{
    struct pen_job_snapshot job;
    struct pen_status st;
    char text[CLIENT_BYTES];
    const char *owner = pen_http_request_owner(request, text);
    if (!pen_jobs_cancel(jobs, request->job_id, owner, &job, &st))
        return pen_http_request_fail(request, &st);
    request->changed = job.cancelled_now;
    return pen_http_request_json(request, 202, job.json);
}

enum outcome pen_http_handle_delete(struct request *request, struct pen_jobs *jobs)
{
    struct pen_status st;
    char text[CLIENT_BYTES];
    const char *owner = pen_http_request_owner(request, text);
    const bool keep_stats = !pen_http_request_is_true(request, "stats");
    if (!pen_jobs_delete(jobs, request->job_id, owner, keep_stats, &st))
        return pen_http_request_fail(request, &st);
    request->changed = true;
    request->reply.status = 204;
    return OUTCOME_ANSWERED;
}
