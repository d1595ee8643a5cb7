/* SPDX-License-Identifier: MIT */
/* The callbacks of libmicrohttpd, which lead a request through its phases (see request.h).
 *
 * A reply is queued in the access callback only, never from another thread: the thread that answers
 * fills the reply and resumes the connection, and libmicrohttpd then calls the callback again. */
#include "http/internal/adapter.h"

#include <stddef.h>
#include <string.h>
#include <strings.h>

#include "base/clock.h"
#include "base/log.h"
#include "http/internal/admit.h"
#include "http/internal/executor.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/routes.h"
#include "http/internal/streams.h"
#include "http/internal/suspend.h"
#include "http/internal/watch.h"

enum { STREAM_BYTES = 4096 }; /* read from a stream at once, for clients of HTTP/1.0 */

/* The header fields that the server reads. */
static const struct {
    const char *name;
    size_t offset;
    bool single; /* a request that has the field twice is refused */
} read_fields[] = {
    {.name = "Host", .offset = offsetof(struct fields, host), .single = true},
    {.name = "Content-Length", .offset = offsetof(struct fields, content_length), .single = true},
    {.name = "Transfer-Encoding",
     .offset = offsetof(struct fields, transfer_encoding),
     .single = true},
    {.name = "Content-Type", .offset = offsetof(struct fields, content_type), .single = true},
    {.name = "Idempotency-Key", .offset = offsetof(struct fields, idempotency_key), .single = true},
    {.name = "If-None-Match", .offset = offsetof(struct fields, if_none_match)},
    {.name = "Range", .offset = offsetof(struct fields, range)},
    {.name = "If-Range", .offset = offsetof(struct fields, if_range)},
    {.name = "Origin", .offset = offsetof(struct fields, origin), .single = true},
    {.name = "X-Request-Id", .offset = offsetof(struct fields, request_id)},
    {.name = "Expect", .offset = offsetof(struct fields, expect)},
    {.name = "Last-Event-ID", .offset = offsetof(struct fields, last_event_id)},
    {.name = "Accept", .offset = offsetof(struct fields, accept)},
};

/* Keeps the value of a header field that the server reads; notes a repeated one. */
static enum MHD_Result on_field(void *cls, enum MHD_ValueKind kind, const char *name,
                                const char *value)
{
    (void)kind;
    struct fields *fields = cls;
    for (size_t i = 0; i < sizeof read_fields / sizeof read_fields[0]; i++) {
        if (strcasecmp(name, read_fields[i].name) != 0)
            continue;
        const char **field = (const char **)((char *)fields + read_fields[i].offset);
        if (*field)
            fields->repeated = fields->repeated || read_fields[i].single;
        else
            *field = value ? value : "";
    }
    return MHD_YES;
}

static void unref_body(void *blob)
{
    pen_http_blob_unref(blob);
}

/* Called by libmicrohttpd when it can send more of an event stream. If there is nothing to send,
 * the connection is suspended until the stream resumes it. */
static ssize_t read_stream(void *cls, uint64_t position, char *out, size_t bytes)
{
    (void)position;
    struct request *request = cls;
    ssize_t count = request->stream ? 0 : -1;
    while (count == 0) {
        bool behind;
        count = pen_http_stream_read(request->stream, out, bytes, &behind);
        if (behind)
            pen_http_watch_check_soon(request->http->watch);
        if (count == 0 && pen_http_suspend(request))
            return 0;
    }
    return count > 0 ? count : MHD_CONTENT_READER_END_OF_STREAM;
}

/* The reply as a response of libmicrohttpd; NULL when out of memory. */
static struct MHD_Response *make_response(struct request *request)
{
    const struct reply *reply = &request->reply;
    if (reply->streaming && !reply->failed)
        return MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, STREAM_BYTES, read_stream,
                                                 request, NULL);
    if (reply->failed || !reply->body || reply->bytes == 0)
        return MHD_create_response_from_buffer(0, (void *)"", MHD_RESPMEM_PERSISTENT);
    struct blob *blob = pen_http_blob_ref(reply->body);
    struct MHD_Response *response = MHD_create_response_from_buffer_with_free_callback_cls(
        reply->bytes, blob->content.data + reply->first, unref_body, blob);
    if (!response)
        pen_http_blob_unref(blob);
    return response;
}

static void add_fields(struct MHD_Response *response, const struct request *request)
{
    const struct reply *reply = &request->reply;
    for (int i = 0; !reply->failed && i < reply->field_count; i++)
        MHD_add_response_header(response, reply->field[i].name, reply->field[i].value);
    MHD_add_response_header(response, "X-Request-Id", request->id);
    MHD_add_response_header(response, "X-Content-Type-Options", "nosniff");
    if (atomic_load_explicit(&request->http->stopping, memory_order_relaxed))
        MHD_add_response_header(response, "Connection", "close");
}

static enum MHD_Result send_reply(struct request *request)
{
    struct reply *reply = &request->reply;
    request->phase = PHASE_ANSWERED;
    if (reply->failed || reply->status == 0)
        reply->status = 503;
    struct MHD_Response *response = make_response(request);
    if (!response)
        return MHD_NO;
    add_fields(response, request);
    enum MHD_Result queued =
        MHD_queue_response(request->connection, (unsigned)reply->status, response);
    MHD_destroy_response(response);
    return queued;
}

/* Answers at once if the route can; otherwise suspends the connection and queues the request. */
static enum MHD_Result dispatch(struct request *request)
{
    const struct route *route = request->route;
    if (route->quick && route->quick(request))
        return send_reply(request);
    enum queue_id id = pen_http_route_queue(route, &request->target);
    if (id == QUEUE_NONE) {
        route->handle(request, NULL);
        return send_reply(request);
    }
    request->phase = PHASE_SUSPENDED;
    pen_http_suspend(request);
    if (!pen_http_executor_submit(request->http->executor, id, request)) {
        struct pen_status st;
        pen_fail(&st, PEN_UNAVAILABLE, "the daemon is stopping");
        pen_http_request_fail(request, &st);
        pen_http_resume(request);
    }
    return MHD_YES;
}

/* The head is complete. libmicrohttpd closes the connection after an answer that is queued now. So
 * an answer is queued here only if a body follows that must not be read, else in the next call. */
static enum MHD_Result begin(struct request *request, const char *method)
{
    request->method = method;
    MHD_get_connection_values(request->connection, MHD_HEADER_KIND, on_field, &request->fields);
    atomic_fetch_add_explicit(&request->http->active, 1, memory_order_relaxed);
    pen_http_request_admit(request);
    bool has_body = request->declared_bytes > 0 || request->fields.transfer_encoding;
    return request->phase == PHASE_ANSWERED && has_body ? send_reply(request) : MHD_YES;
}

void *pen_http_adapter_on_line(void *cls, const char *uri, struct MHD_Connection *connection)
{
    struct request *request = uri ? pen_http_request_new(cls, uri) : NULL;
    if (request)
        request->connection = connection;
    return request;
}

enum MHD_Result pen_http_adapter_on_access(void *cls, struct MHD_Connection *connection,
                                           const char *url, const char *method, const char *version,
                                           const char *data, size_t *bytes, void **state)
{
    (void)cls, (void)connection, (void)url, (void)version;
    struct request *request = *state;
    if (!request)
        return MHD_NO;
    if (request->phase == PHASE_LINE)
        return begin(request, method);
    if (*bytes > 0) {
        bool more = pen_http_request_receive(request, data, *bytes);
        *bytes = 0;
        return more ? MHD_YES : MHD_NO;
    }
    return request->phase == PHASE_BODY ? dispatch(request) : send_reply(request);
}

/* Logs a request. Requests that only read, or are refused, are logged at debug level, because they
 * could fill a disk. */
static void log_access(const struct request *request, uint64_t streamed, bool complete)
{
    const struct reply *reply = &request->reply;
    bool reads = request->head || strcmp(request->method, "GET") == 0;
    bool refused = reply->status >= 400;
    enum pen_log_level level = reply->status >= 500 ? PEN_LOG_WARN
                               : reads || refused   ? PEN_LOG_DEBUG
                                                    : PEN_LOG_INFO;
    int64_t us = (pen_clock_ns() - request->begun_ns) / 1000;
    bool sent = !request->head && reply->status != 304;
    uint64_t bytes = streamed + (sent ? reply->bytes : 0);
    const struct pen_log_about about = {.job = request->job_id, .request = request->id};
    pen_log_about(level, &about, "%s %.300s %d %llu bytes %lld.%03lld ms%s", request->method,
                  request->raw_target, reply->status, (unsigned long long)bytes,
                  (long long)(us / 1000), (long long)(us % 1000), complete ? "" : " (cut short)");
}

void pen_http_adapter_on_completed(void *cls, struct MHD_Connection *connection, void **state,
                                   enum MHD_RequestTerminationCode why)
{
    (void)connection;
    struct pen_http *http = cls;
    struct request *request = *state;
    *state = NULL;
    uint64_t streamed = 0;
    if (request && request->stream) {
        streamed = pen_http_stream_close(request->stream);
        pen_http_watch_remove_stream(http->watch);
    }
    if (request && request->phase != PHASE_LINE) {
        log_access(request, streamed, why == MHD_REQUEST_TERMINATED_COMPLETED_OK);
        atomic_fetch_sub_explicit(&http->active, 1, memory_order_relaxed);
    }
    pen_http_request_free(request);
}
