/* SPDX-License-Identifier: MIT */
/* The handlers of a job's results: picture, comparison, preview, statistics, report, scene. */
#include <string.h>

#include "http/internal/http.h"
#include "http/internal/pictures.h"
#include "http/internal/request.h"
#include "http/internal/routes.h"
#include "io/document.h"
#include "report/report.h"

static const char forever[] = "private, max-age=86400, immutable";

/* The job of the query parameter `with`; false if there is none. */
static bool other_job(const struct request *request, char id[PEN_ID_BYTES])
{
    const char *with = pen_http_request_param(request, "with");
    return with && pen_uuid_parse(with, id);
}

/* Whether a missing result may still come: a job of the request has not ended, and no job has ended
 * without a picture. */
static bool may_come(const struct request *request, struct pen_jobs *jobs)
{
    char with[PEN_ID_BYTES];
    const char *const ids[] = {request->job_id, other_job(request, with) ? with : NULL};
    enum pen_job_state state;
    int64_t revision;
    struct pen_status ignored;
    bool waits = false;
    for (int i = 0; i < 2 && ids[i]; i++) {
        if (!pen_jobs_state(jobs, ids[i], &state, &revision, &ignored) || state == PEN_JOB_FAILED ||
            state == PEN_JOB_CANCELLED)
            return false;
        waits = waits || state != PEN_JOB_SUCCEEDED;
    }
    return waits;
}

/* Answers with a problem. */
static enum outcome answer_status(struct request *request, struct pen_jobs *jobs,
                                  const struct pen_status *st)
{
    pen_http_request_fail(request, st);
    if (st->code == PEN_CONFLICT && may_come(request, jobs))
        pen_http_reply_field(&request->reply, "Retry-After", "1");
    return OUTCOME_ANSWERED;
}

/* Answers with an image that was made for this client alone. */
static enum outcome answer_image(struct request *request, struct pen_image *image,
                                 const char *cache_control)
{
    const struct content content = {.blob = pen_http_blob_take(&image->bytes),
                                    .type = image->type,
                                    .etag = image->etag,
                                    .cache_control = cache_control};
    return pen_http_request_content(request, &content);
}

/* Answers with a representation whose entity tag is its hash. */
static enum outcome answer_hashed(struct request *request, struct blob *blob, const char *type,
                                  const char *cache_control)
{
    char etag[ETAG_BYTES] = "";
    if (blob)
        pen_http_etag(&blob->content, etag);
    const struct content content = {
        .blob = blob, .type = type, .etag = etag, .cache_control = cache_control};
    return pen_http_request_content(request, &content);
}

typedef bool make_image(struct pen_jobs *jobs, const char *id, const struct pen_image_query *query,
                        struct pen_image *out, struct pen_status *st);

/* Answers with a kept picture, or makes and keeps it. */
static enum outcome answer_kept(struct request *request, struct pen_jobs *jobs,
                                const struct pen_image_query *query, make_image *make)
{
    struct pictures *pictures = request->http->pictures;
    struct pen_image image;
    struct picture picture;
    enum pen_job_state state;
    int64_t revision;
    struct pen_status st;
    if (!pen_jobs_state(jobs, request->job_id, &state, &revision, &st) ||
        (query->with && !pen_jobs_state(jobs, query->with, &state, &revision, &st)))
        return answer_status(request, jobs, &st);
    if (!pen_http_pictures_find(pictures, request->job_id, query, &picture) &&
        !(make(jobs, request->job_id, query, &image, &st) &&
          pen_http_pictures_take(pictures, request->job_id, query, &image, &picture, &st)))
        return answer_status(request, jobs, &st);
    const struct content content = {.blob = picture.blob,
                                    .type = picture.type,
                                    .etag = picture.etag,
                                    .cache_control = forever,
                                    .ranges = make == pen_jobs_image};
    return pen_http_request_content(request, &content);
}

enum outcome pen_http_handle_image(struct request *request, struct pen_jobs *jobs)
{
    const struct pen_image_query query = {.view = pen_http_request_param(request, "view"),
                                          .layer = pen_http_request_param(request, "layer"),
                                          .format = pen_http_request_param(request, "format"),
                                          .max_edge =
                                              (int)pen_http_request_number(request, "max_edge", 0)};
    return answer_kept(request, jobs, &query, pen_jobs_image);
}

enum outcome pen_http_handle_compare(struct request *request, struct pen_jobs *jobs)
{
    char with[PEN_ID_BYTES];
    const char *format = pen_http_request_param(request, "format");
    const struct pen_image_query query = {.view = pen_http_request_param(request, "view"),
                                          .format = format ? format : "json",
                                          .with = other_job(request, with) ? with : NULL};
    return answer_kept(request, jobs, &query, pen_jobs_compare);
}

enum outcome pen_http_handle_preview(struct request *request, struct pen_jobs *jobs)
{
    const struct pen_image_query query = {.view = pen_http_request_param(request, "view")};
    struct pen_image image;
    struct pen_status st;
    if (!pen_jobs_preview(jobs, request->job_id, &query, &image, &st))
        return answer_status(request, jobs, &st);
    return answer_image(request, &image, "no-cache");
}

enum outcome pen_http_handle_stats(struct request *request, struct pen_jobs *jobs)
{
    struct pen_status st;
    const bool so_far = pen_http_request_is_true(request, "so_far");
    json_t *stats = (so_far ? pen_jobs_stats_so_far : pen_jobs_stats)(jobs, request->job_id, &st);
    if (!stats)
        return answer_status(request, jobs, &st);
    struct blob *text = pen_http_blob_json(stats);
    json_decref(stats);
    return answer_hashed(request, text, "application/json", so_far ? "no-cache" : forever);
}

enum outcome pen_http_handle_scene(struct request *request, struct pen_jobs *jobs)
{
    struct pen_buf text = {0};
    struct pen_status st;
    if (!pen_store_scene(pen_jobs_store(jobs), request->job_id, &text, &st))
        return answer_status(request, jobs, &st);
    const bool xml = pen_text_is_xml((const char *)text.data, text.bytes);
    return answer_hashed(request, pen_http_blob_take(&text),
                         xml ? "application/xml" : "application/json", forever);
}

/* The format of a report that the client prefers; HTML if it accepts all. */
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

/* Makes the report in *format. If it does not exist in that format, makes it as JSON if the client
 * accepts JSON; *format is then "json". */
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
    if (!format || !make_report(request, jobs, &format, &report, &st))
        return answer_status(request, jobs, &st);
    pen_http_reply_field(&request->reply, "Vary", "Accept, Accept-Encoding");
    if (strcmp(format, "html") == 0)
        pen_http_reply_field(&request->reply, "Content-Security-Policy", "%s", pen_report_policy());
    return answer_image(request, &report, forever);
}
