/* SPDX-License-Identifier: MIT */
#include "cmd/client/remote_job.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

#include "base/utf8.h"
#include "cmd/client/output.h"
#include "cmd/client/progress.h"
#include "cmd/files.h"
#include "report/report.h"

enum {
    ANSWER_S = 30,
    LONG_POLL_S = 30,
    SILENCE_S = 35 /* of a stream of events: three missing heartbeats */
};

const char *pen_remote_text(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

void pen_remote_label(const json_t *object, const char *key, char *out, size_t bytes)
{
    pen_utf8_show(out, bytes, pen_remote_text(object, key));
}

double pen_remote_time(const json_t *object, const char *key)
{
    struct tm tm = {0};
    double second;
    if (sscanf(pen_remote_text(object, key), "%d-%d-%dT%d:%d:%lfZ", &tm.tm_year, &tm.tm_mon,
               &tm.tm_mday, &tm.tm_hour, &tm.tm_min, &second) != 6)
        return -1;
    tm.tm_year -= 1900;
    tm.tm_mon -= 1;
    return (double)timegm(&tm) + second;
}

static bool out_of_memory(struct pen_errors *errors)
{
    struct pen_status st;
    *errors = (struct pen_errors){0};
    pen_fail(&st, PEN_NO_MEMORY, "out of memory");
    pen_errors_add(errors, &st);
    return false;
}

static bool job_path(struct pen_client *client, const char *id, const char *suffix,
                     struct pen_buf *path)
{
    return pen_buf_puts(path, "/v1/jobs/") && pen_client_escape(client, path, id) &&
           pen_buf_puts(path, suffix);
}

static bool request_json(struct pen_client *client, const char *method, const char *path,
                         json_t **json, struct pen_errors *errors)
{
    struct pen_reply reply = {0};
    struct pen_request request = {
        .method = method, .path = path, .repeatable = true, .timeout_s = ANSWER_S};
    bool ok = pen_client_json(client, &request, &reply, json, errors);
    pen_reply_release(&reply);
    return ok;
}

bool pen_remote_get(struct pen_client *client, const char *path, json_t **json,
                    struct pen_errors *errors)
{
    return request_json(client, "GET", path, json, errors);
}

bool pen_remote_job(struct pen_client *client, const char *method, const char *id,
                    const char *suffix, json_t **json, struct pen_errors *errors)
{
    struct pen_buf path = {0};
    *json = NULL;
    bool ok = (job_path(client, id, suffix, &path) || out_of_memory(errors)) &&
              request_json(client, method, (const char *)path.data, json, errors);
    pen_buf_release(&path);
    return ok;
}

/* Updates *job and etag, unless the job's revision is still that of etag ("": none). `path`
 * contains the time that the daemon waits for another revision. */
static bool poll_job(struct pen_client *client, const char *path, char etag[128], json_t **job,
                     struct pen_errors *errors)
{
    struct pen_request request = {.method = "GET",
                                  .path = path,
                                  .if_none_match = etag[0] ? etag : NULL,
                                  .repeatable = true,
                                  .timeout_s = LONG_POLL_S + ANSWER_S};
    struct pen_reply reply = {0};
    json_t *state = NULL;
    bool ok = pen_client_json(client, &request, &reply, &state, errors);
    if (ok && state) {
        json_decref(*job);
        *job = state;
        memcpy(etag, reply.etag, sizeof reply.etag);
    }
    pen_reply_release(&reply);
    return ok;
}

static bool has_ended(const json_t *job)
{
    const char *state = pen_remote_text(job, "state");
    return strcmp(state, "succeeded") == 0 || strcmp(state, "failed") == 0 ||
           strcmp(state, "cancelled") == 0;
}

static void show(struct pen_progress *progress, const json_t *job)
{
    const json_t *done = json_object_get(job, "progress");
    const json_t *eta = json_object_get(done, "eta_seconds");
    if (strcmp(pen_remote_text(job, "state"), "queued") == 0)
        pen_progress_note(progress, "queued");
    else
        pen_progress_show(progress, json_number_value(json_object_get(done, "fraction")),
                          json_is_number(eta) ? json_number_value(eta) : -1);
}

static void on_pause(void *user, const char *reason)
{
    char note[128];
    snprintf(note, sizeof note, "%s, trying again", reason);
    pen_progress_note(user, note);
}

/* Returns true if the job succeeded. If not, adds the reason from its problem document to
 * *errors. */
static bool check_end(const json_t *job, struct pen_errors *errors)
{
    struct pen_status st;
    const char *state = pen_remote_text(job, "state");
    const char *id = pen_remote_text(job, "id");
    if (strcmp(state, "succeeded") == 0)
        return true;
    const char *detail = pen_remote_text(json_object_get(job, "error"), "detail");
    if (strcmp(state, "failed") == 0)
        pen_fail(&st, PEN_RENDER_FAILED, "job %s failed%s%s", id, *detail ? ": " : "", detail);
    else
        pen_fail(&st, PEN_RENDER_FAILED, "job %s was cancelled", id);
    pen_errors_add(errors, &st);
    return false;
}

/* State of following a job. */
struct following {
    struct pen_client *client;
    struct pen_progress *progress;
    json_t **job;
    /* The job's path, alone and with a wait of 1 s and 30 s, and the path of its events. */
    struct pen_buf path, wait_short, wait_long, events;
    char etag[sizeof((struct pen_reply *)0)->etag];
};

static void on_event(void *user, const char *type, const char *data)
{
    struct following *following = user;
    json_t *job = strcmp(type, "tile") == 0 ? NULL : json_loads(data, 0, NULL);
    if (!job)
        return;
    json_decref(*following->job);
    *following->job = job;
    if (!has_ended(job))
        show(following->progress, job);
}

/* Reads the stream of events until it ends or breaks; the next call resumes it. *usable becomes
 * false if no event came. Then the daemon serves no further stream, or a proxy holds the events
 * back. */
static void read_events(struct following *following, struct pen_sse *sse, bool *usable)
{
    int before = sse->events;
    pen_client_events(following->client, (const char *)following->events.data, sse, SILENCE_S);
    *usable = sse->events > before;
    following->etag[0] = '\0'; /* events may have brought a newer state than the tag */
}

/* Follows the job by events, or by long polls if there are none. The first request waits for a
 * second, so a job that ends within it costs one request. */
static bool follow(struct following *following, struct pen_errors *errors)
{
    const char *path = (const char *)following->path.data;
    const char *wait_long = (const char *)following->wait_long.data;
    struct pen_sse sse = {.each = on_event, .user = following};
    bool usable = true;
    bool ok = poll_job(following->client, (const char *)following->wait_short.data, following->etag,
                       following->job, errors);
    while (ok && !has_ended(*following->job)) {
        show(following->progress, *following->job);
        if (usable)
            read_events(following, &sse, &usable);
        if (!has_ended(*following->job))
            ok = poll_job(following->client, usable ? path : wait_long, following->etag,
                          following->job, errors);
    }
    pen_sse_release(&sse);
    return ok;
}

bool pen_remote_wait(struct pen_client *client, const char *id, bool quiet, json_t **job,
                     struct pen_errors *errors)
{
    struct pen_progress progress;
    struct following following = {.client = client, .progress = &progress, .job = job};
    char label[16];
    *job = NULL;
    snprintf(label, sizeof label, "job %.8s…", id);
    pen_progress_begin(&progress, label, quiet);
    pen_client_on_pause(client, on_pause, &progress);
    bool ok = (job_path(client, id, "", &following.path) &&
               job_path(client, id, "?wait=1", &following.wait_short) &&
               job_path(client, id, "?wait=30", &following.wait_long) &&
               job_path(client, id, "/events", &following.events)) ||
              out_of_memory(errors);
    ok = ok && follow(&following, errors);
    pen_client_on_pause(client, NULL, NULL);
    pen_progress_end(&progress);
    pen_buf_release(&following.path);
    pen_buf_release(&following.wait_short);
    pen_buf_release(&following.wait_long);
    pen_buf_release(&following.events);
    return ok && check_end(*job, errors);
}

bool pen_remote_report(struct pen_client *client, const char *id, json_t **report,
                       struct pen_errors *errors)
{
    struct pen_buf path = {0};
    struct pen_reply reply = {0};
    *report = NULL;
    bool ok = job_path(client, id, "/report", &path) || out_of_memory(errors);
    if (ok) {
        const struct pen_request request = {.method = "GET",
                                            .path = (const char *)path.data,
                                            .accept = "application/json",
                                            .repeatable = true,
                                            .timeout_s = ANSWER_S};
        ok = pen_client_json(client, &request, &reply, report, errors);
    }
    pen_reply_release(&reply);
    pen_buf_release(&path);
    return ok;
}

static bool add_query(struct pen_client *client, struct pen_buf *path, const char *key,
                      const char *value, char separator)
{
    return !value || (pen_buf_printf(path, "%c%s=", separator, key) &&
                      pen_client_escape(client, path, value));
}

static bool image_path(struct pen_client *client, const char *id, const struct pen_fetch *fetch,
                       const char *format, struct pen_buf *path)
{
    return job_path(client, id, "/image", path) && add_query(client, path, "format", format, '?') &&
           add_query(client, path, "view", fetch->view, '&') &&
           add_query(client, path, "layer", fetch->layer, '&');
}

/* Makes the path of the picture or report, and its media type. *accept NULL: the path contains the
 * format. */
static bool result_path(struct pen_client *client, const char *id, const struct pen_fetch *fetch,
                        struct pen_buf *path, const char **accept, struct pen_errors *errors)
{
    struct pen_status st;
    const char *format = fetch->report ? pen_output_report_format(fetch->output, fetch->format, &st)
                                       : pen_output_format(fetch->output, fetch->format, &st);
    if (!format) {
        pen_errors_add(errors, &st);
        return false;
    }
    *accept = fetch->report ? pen_report_media_type(format) : NULL;
    return (fetch->report ? job_path(client, id, "/report", path)
                          : image_path(client, id, fetch, format, path)) ||
           out_of_memory(errors);
}

bool pen_remote_fetch(struct pen_client *client, const char *id, const struct pen_fetch *fetch,
                      struct pen_errors *errors)
{
    struct pen_status st;
    struct pen_buf path = {0};
    struct pen_reply reply = {0};
    const char *accept = NULL;
    bool ok = result_path(client, id, fetch, &path, &accept, errors);
    if (ok) {
        struct pen_request request = {.method = "GET",
                                      .path = (const char *)path.data,
                                      .accept = accept,
                                      .repeatable = true,
                                      .timeout_s = ANSWER_S};
        ok = pen_client_send(client, &request, &reply, errors);
    }
    if (ok && !pen_file_write(fetch->output, reply.body.data, reply.body.bytes, &st)) {
        pen_errors_add(errors, &st);
        ok = false;
    }
    pen_reply_release(&reply);
    pen_buf_release(&path);
    return ok;
}
