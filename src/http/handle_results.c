/* SPDX-License-Identifier: MIT */
/* What a job has come to: picture, preview, statistics, report, scene. */
#include <string.h>

#include "http/internal/handlers.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/snapshots.h"
#include "http/internal/watch.h"
#include "io/document.h"

/* Pictures in memory together, those on their way to slow clients included. */
enum { PICTURE_BYTES = 1 << 30 };

static const char forever[] = "private, max-age=86400, immutable";

/* A result that is not there yet is worth another try: the job's state tells. */
static enum outcome answer_status(struct request *request, struct pen_jobs *jobs,
                                  const struct pen_status *st)
{
    pen_http_request_fail(request, st);
    if (st->code != PEN_CONFLICT)
        return OUTCOME_ANSWERED;
    struct pen_http *http = request->http;
    struct snapshot snapshot;
    struct pen_status ignored;
    if (!pen_http_snapshots_read(http->snapshots, pen_http_watch_notify(http->watch), jobs,
                                 request->job_id, &snapshot, &ignored))
        return OUTCOME_ANSWERED;
    if (!pen_job_state_ended(snapshot.state))
        pen_http_reply_field(&request->reply, "Retry-After", "1");
    pen_http_snapshot_release(&snapshot);
    return OUTCOME_ANSWERED;
}

static bool has_room(struct request *request)
{
    atomic_size_t *total = &request->http->picture_bytes;
    if (atomic_load_explicit(total, memory_order_relaxed) <= PICTURE_BYTES)
        return true;
    struct pen_status st;
    pen_fail(&st, PEN_UNAVAILABLE, "there is no room for a picture now; try again later");
    pen_http_request_fail(request, &st);
    return false;
}

static void answer_picture(struct request *request, struct pen_image *image, bool final)
{
    struct blob *blob = pen_http_blob_take(&image->bytes);
    pen_http_blob_count(blob, &request->http->picture_bytes);
    const struct content content = {.blob = blob,
                                    .type = image->type,
                                    .etag = image->etag,
                                    .cache_control = final ? forever : "no-cache",
                                    .ranges = final};
    pen_http_request_content(request, &content);
}

/* Answers with a representation whose tag is its hash. */
static void answer_hashed(struct request *request, struct blob *blob, const char *type)
{
    char etag[ETAG_BYTES] = "";
    if (blob)
        pen_http_blob_etag(blob, etag);
    const struct content content = {
        .blob = blob, .type = type, .etag = etag, .cache_control = forever};
    pen_http_request_content(request, &content);
}

enum outcome pen_http_handle_image(struct request *request, struct pen_jobs *jobs)
{
    const struct pen_image_query query = {.view = pen_http_request_param(request, "view"),
                                          .layer = pen_http_request_param(request, "layer"),
                                          .format = pen_http_request_param(request, "format")};
    struct pen_image image = {0};
    struct pen_status st;
    if (!has_room(request))
        return OUTCOME_ANSWERED;
    if (!pen_jobs_image(jobs, request->job_id, &query, &image, &st))
        return answer_status(request, jobs, &st);
    answer_picture(request, &image, true);
    return OUTCOME_ANSWERED;
}

enum outcome pen_http_handle_preview(struct request *request, struct pen_jobs *jobs)
{
    struct pen_image image = {0};
    struct pen_status st;
    if (!has_room(request))
        return OUTCOME_ANSWERED;
    if (!pen_jobs_preview(jobs, request->job_id, pen_http_request_param(request, "view"), &image,
                          &st))
        return answer_status(request, jobs, &st);
    answer_picture(request, &image, false);
    return OUTCOME_ANSWERED;
}

enum outcome pen_http_handle_stats(struct request *request, struct pen_jobs *jobs)
{
    struct pen_status st;
    json_t *stats = pen_jobs_stats(jobs, request->job_id, &st);
    if (!stats)
        return answer_status(request, jobs, &st);
    answer_hashed(request, pen_http_blob_json(stats), "application/json");
    json_decref(stats);
    return OUTCOME_ANSWERED;
}

enum outcome pen_http_handle_scene(struct request *request, struct pen_jobs *jobs)
{
    struct pen_buf scene = {0};
    struct pen_status st;
    if (!pen_jobs_scene(jobs, request->job_id, &scene, &st))
        return answer_status(request, jobs, &st);
    bool xml = pen_text_is_xml((const char *)scene.data, scene.bytes);
    answer_hashed(request, pen_http_blob_take(&scene),
                  xml ? "application/xml" : "application/json");
    return OUTCOME_ANSWERED;
}

/* Which form of a report is wanted; HTML where anything will do. */
static const char *choose_form(const struct request *request, struct pen_status *st)
{
    static const char *const types[] = {"text/html", "application/json", "text/csv",
                                        "text/markdown"};
    static const char *const forms[] = {"html", "json", "csv", "md"};
    int i = pen_accept_choose(request->fields.accept, types, 4);
    if (i >= 0)
        return forms[i];
    pen_fail(st, PEN_ACCEPT,
             "a report is text/html, application/json, text/csv or text/markdown, not \"%.100s\"",
             request->fields.accept);
    return NULL;
}

enum outcome pen_http_handle_report(struct request *request, struct pen_jobs *jobs)
{
    struct pen_image report = {0};
    struct pen_status st;
    const char *form = choose_form(request, &st);
    pen_http_reply_field(&request->reply, "Vary", "Accept");
    if (!form || !pen_jobs_report(jobs, request->job_id, form, &report, &st))
        return answer_status(request, jobs, &st);
    if (strcmp(form, "html") == 0)
        pen_http_reply_field(&request->reply, "Content-Security-Policy",
                             "default-src 'none'; style-src 'unsafe-inline'");
    const struct content content = {.blob = pen_http_blob_take(&report.bytes),
                                    .type = report.type,
                                    .etag = report.etag,
                                    .cache_control = forever};
    pen_http_request_content(request, &content);
    return OUTCOME_ANSWERED;
}
