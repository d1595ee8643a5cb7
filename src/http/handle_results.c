/* SPDX-License-Identifier: MIT */
/* The handlers of a job's results: picture, preview, statistics, report, scene. */
#include <string.h>

#include "http/internal/encoding.h"
#include "http/internal/handlers.h"
#include "http/internal/http.h"
#include "http/internal/pictures.h"
#include "http/internal/request.h"
#include "http/internal/snapshot_cache.h"
#include "http/internal/watch.h"
#include "io/document.h"

static const char forever[] = "private, max-age=86400, immutable";

/* Answers with a problem. Adds Retry-After if the job has not ended, because its result may still
 * come. */
static enum outcome answer_status(struct request *request, struct pen_jobs *jobs,
                                  const struct pen_status *st)
{
    pen_http_request_fail(request, st);
    if (st->code != PEN_CONFLICT)
        return OUTCOME_ANSWERED;
    struct pen_http *http = request->http;
    struct snapshot snapshot;
    struct pen_status ignored;
    if (!pen_http_snapshot_cache_read(http->snapshot_cache, pen_http_watch_changes(http->watch),
                                      jobs, request->job_id, &snapshot, &ignored))
        return OUTCOME_ANSWERED;
    if (!pen_job_state_ended(snapshot.state))
        pen_http_reply_field(&request->reply, "Retry-After", "1");
    pen_http_snapshot_release(&snapshot);
    return OUTCOME_ANSWERED;
}

/* Answers with a picture; takes the reference to its blob. */
static void answer_picture(struct request *request, const struct picture *picture, bool final)
{
    const struct content content = {.blob = picture->blob,
                                    .type = picture->type,
                                    .etag = picture->etag,
                                    .cache_control = final ? forever : "no-cache",
                                    .ranges = final};
    pen_http_request_content(request, &content);
}

/* Answers with a representation whose entity tag is its hash. */
static void answer_hashed(struct request *request, struct blob *blob, const char *type)
{
    char etag[ETAG_BYTES] = "";
    if (blob)
        pen_http_etag(&blob->content, etag);
    const struct content content = {
        .blob = blob, .type = type, .etag = etag, .cache_control = forever};
    pen_http_request_content(request, &content);
}

static struct picture_key key_of(const struct request *request)
{
    return (struct picture_key){.job = request->job_id,
                                .view = pen_http_request_param(request, "view"),
                                .layer = pen_http_request_param(request, "layer"),
                                .format = pen_http_request_param(request, "format")};
}

/* Looks for an answer in memory without a read of the store. */
static bool find_quickly(const struct request *request, const struct picture_key *key,
                         struct picture *out)
{
    struct pen_http *http = request->http;
    struct snapshot snapshot;
    if (!pen_http_snapshot_cache_peek(http->snapshot_cache, pen_http_watch_changes(http->watch),
                                      request->job_id, &snapshot))
        return false;
    pen_http_snapshot_release(&snapshot); /* the job is there */
    return pen_http_pictures_find(http->pictures, key, out);
}

bool pen_http_quick_image(struct request *request)
{
    const struct picture_key key = key_of(request);
    struct picture picture;
    if (!find_quickly(request, &key, &picture))
        return false;
    answer_picture(request, &picture, true);
    return true;
}

/* Looks for an answer in memory, if the job is there. Where the store says that it is not, or does
 * not answer, the caller's own read says so too. */
static bool find_kept(const struct request *request, struct pen_jobs *jobs,
                      const struct picture_key *key, struct picture *out)
{
    struct pen_http *http = request->http;
    struct snapshot snapshot;
    struct pen_status ignored;
    if (!pen_http_snapshot_cache_read(http->snapshot_cache, pen_http_watch_changes(http->watch),
                                      jobs, request->job_id, &snapshot, &ignored))
        return false;
    pen_http_snapshot_release(&snapshot);
    return pen_http_pictures_find(http->pictures, key, out);
}

/* A picture that is being made. */
struct making {
    struct request *request;
    struct picture_room room;
};

/* What was set aside before is not needed. */
static bool reserve(void *user, size_t bytes, struct pen_status *st)
{
    struct making *making = user;
    struct request *request = making->request;
    pen_http_pictures_give_up(request->http->pictures, &making->room);
    making->room.bytes = bytes;
    return pen_http_pictures_reserve(request->http->pictures, &making->room, st);
}

static enum outcome answer_made(struct making *making, struct pen_jobs *jobs, bool made,
                                struct pen_image *image, const struct picture_key *key,
                                struct pen_status *st)
{
    struct request *request = making->request;
    struct pictures *pictures = request->http->pictures;
    struct picture picture;
    if (!made)
        pen_http_pictures_give_up(pictures, &making->room);
    if (!made || !pen_http_pictures_take(pictures, key, image, &making->room, &picture, st))
        return answer_status(request, jobs, st);
    answer_picture(request, &picture, key != NULL);
    return OUTCOME_ANSWERED;
}

enum outcome pen_http_handle_image(struct request *request, struct pen_jobs *jobs)
{
    const struct picture_key key = key_of(request);
    struct making making = {.request = request};
    const struct pen_image_query query = {.view = key.view,
                                          .layer = key.layer,
                                          .format = key.format,
                                          .reserve = reserve,
                                          .user = &making};
    struct pen_image image = {0};
    struct picture picture;
    struct pen_status st;
    if (find_kept(request, jobs, &key, &picture)) {
        answer_picture(request, &picture, true);
        return OUTCOME_ANSWERED;
    }
    const bool made = pen_jobs_image(jobs, request->job_id, &query, &image, &st);
    return answer_made(&making, jobs, made, &image, &key, &st);
}

enum outcome pen_http_handle_preview(struct request *request, struct pen_jobs *jobs)
{
    struct making making = {.request = request};
    const struct pen_image_query query = {
        .view = pen_http_request_param(request, "view"), .reserve = reserve, .user = &making};
    struct pen_image image = {0};
    struct pen_status st;
    const bool made = pen_jobs_preview(jobs, request->job_id, &query, &image, &st);
    return answer_made(&making, jobs, made, &image, NULL, &st);
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
    struct pen_buf text = {0};
    struct pen_status st;
    if (!pen_jobs_scene(jobs, request->job_id, &text, &st))
        return answer_status(request, jobs, &st);
    const bool xml = pen_text_is_xml((const char *)text.data, text.bytes);
    answer_hashed(request, pen_http_blob_take(&text), xml ? "application/xml" : "application/json");
    return OUTCOME_ANSWERED;
}

/* The format of a report that the client prefers; HTML if it accepts anything. */
static const char *choose_format(const struct request *request, struct pen_status *st)
{
    static const char *const types[] = {"text/html", "application/json", "text/csv",
                                        "text/markdown"};
    static const char *const formats[] = {"html", "json", "csv", "md"};
    _Static_assert(sizeof types == sizeof formats, "each media type has its format");
    int i = pen_accept_choose(request->fields.accept, types, 4);
    if (i >= 0)
        return formats[i];
    pen_fail(st, PEN_ACCEPT,
             "a report is text/html, application/json, text/csv or text/markdown, not \"%.100s\"",
             request->fields.accept);
    return NULL;
}

/* Makes the report in *format, or, where there is none in that format, as JSON if the client
 * accepts that too; *format is then "json". */
static bool make_report(const struct request *request, struct pen_jobs *jobs, const char **format,
                        struct pen_image *report, struct pen_status *st)
{
    static const char *const json[] = {"application/json"};
    if (pen_jobs_report(jobs, request->job_id, *format, report, st))
        return true;
    if (st->code != PEN_ACCEPT || pen_accept_choose(request->fields.accept, json, 1) < 0)
        return false;
    *format = "json";
    return pen_jobs_report(jobs, request->job_id, *format, report, st);
}

enum outcome pen_http_handle_report(struct request *request, struct pen_jobs *jobs)
{
    struct pen_image report = {0};
    struct pen_status st;
    const char *format = choose_format(request, &st);
    pen_http_reply_field(&request->reply, "Vary", "Accept, Accept-Encoding");
    if (!format || !make_report(request, jobs, &format, &report, &st))
        return answer_status(request, jobs, &st);
    if (strcmp(format, "html") == 0)
        pen_http_reply_field(&request->reply, "Content-Security-Policy",
                             "default-src 'none'; style-src 'unsafe-inline'; img-src data:");
    const struct content content = {.blob = pen_http_blob_take(&report.bytes),
                                    .type = report.type,
                                    .etag = report.etag,
                                    .cache_control = forever};
    pen_http_request_content(request, &content);
    return OUTCOME_ANSWERED;
}
