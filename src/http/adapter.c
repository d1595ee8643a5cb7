/* SPDX-License-Identifier: MIT */
/* The callbacks of libmicrohttpd, which move a request through its phases (request.h).
 *
 * A reply is queued in the access callback only, never from another thread. The thread that answers
 * fills the reply and resumes the connection. libmicrohttpd then calls the callback again. */
#include "http/internal/listener.h"

#include <gnutls/gnutls.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stddef.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>

#include "http/internal/addresses.h"
#include "http/internal/encoding.h"
#include "http/internal/executor.h"
#include "http/internal/guard.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/routes.h"
#include "http/internal/streams.h"

enum {
    STREAM_BYTES = 4096,   /* read from a stream at once */
    STREAM_ACK_MS = 20000, /* a stream ends if its client acknowledges nothing for this time */
    CLIENT_GONE = 499      /* in the log: the client had gone before the answer, as in nginx */
};

/* The header fields that the server reads. */
static const struct {
    const char *name;
    size_t offset;
    bool single; /* a request that has the field twice is refused */
    bool last;   /* of several fields, the last one counts; else the first */
} known_fields[] = {
    {.name = "Host", .offset = offsetof(struct fields, host), .single = true},
    {.name = "Content-Length", .offset = offsetof(struct fields, content_length), .single = true},
    {.name = "Transfer-Encoding",
     .offset = offsetof(struct fields, transfer_encoding),
     .single = true},
    {.name = "Content-Type", .offset = offsetof(struct fields, content_type), .single = true},
    {.name = "Content-Encoding",
     .offset = offsetof(struct fields, content_encoding),
     .single = true},
    {.name = "Idempotency-Key", .offset = offsetof(struct fields, idempotency_key), .single = true},
    {.name = "Authorization", .offset = offsetof(struct fields, authorization), .single = true},
    {.name = "If-None-Match", .offset = offsetof(struct fields, if_none_match)},
    {.name = "Range", .offset = offsetof(struct fields, range)},
    {.name = "If-Range", .offset = offsetof(struct fields, if_range)},
    {.name = "Origin", .offset = offsetof(struct fields, origin), .single = true},
    {.name = "traceparent", .offset = offsetof(struct fields, traceparent)},
    {.name = "X-Request-Id", .offset = offsetof(struct fields, request_id)},
    {.name = "Last-Event-ID", .offset = offsetof(struct fields, last_event_id)},
    {.name = "Accept", .offset = offsetof(struct fields, accept)},
    {.name = "Accept-Encoding", .offset = offsetof(struct fields, accept_encoding)},
    {.name = "X-Forwarded-For", .offset = offsetof(struct fields, forwarded_for), .last = true},
    {.name = "X-Forwarded-Host", .offset = offsetof(struct fields, forwarded_host), .last = true},
};

/* Keeps the value of a header field that the server reads. Notes a repeated or malformed field. */
static enum MHD_Result on_field(void *cls, enum MHD_ValueKind kind, const char *name,
                                const char *value)
{
    (void)kind;
    struct fields *fields = cls;
    value = value ? value : "";
    fields->malformed = fields->malformed || !*name ||
                        !pen_text_is_plain(name, " \t\"(),/:;<=>?@[\\]{}") ||
                        !pen_text_is_plain(value, "");
    for (size_t i = 0; i < sizeof known_fields / sizeof known_fields[0]; i++) {
        if (strcasecmp(name, known_fields[i].name) != 0)
            continue;
        const char **field = (const char **)((char *)fields + known_fields[i].offset);
        if (*field && !known_fields[i].last)
            fields->repeated = fields->repeated || known_fields[i].single;
        else
            *field = value;
        break;
    }
    return MHD_YES;
}

static void unref_body(void *blob)
{
    pen_http_blob_unref(blob);
}

/* Called by libmicrohttpd when it can send more of an event stream. Without an event, the
 * connection is suspended until there is one. A stream never ends with an error, since
 * libmicrohttpd (0.9.75 to 1.0.10) would then keep the descriptor for an unlimited time. */
static ssize_t read_stream(void *cls, uint64_t position, char *out, size_t bytes)
{
    (void)position;
    struct request *request = cls;
    if (!request->stream)
        return MHD_CONTENT_READER_END_OF_STREAM;
    pen_guard_state(request->http->guard, request->fd, PEER_SEND);
    const ssize_t count = pen_http_stream_read(request, out, bytes);
    return count >= 0 ? count : MHD_CONTENT_READER_END_OF_STREAM;
}

/* The reply as a response of libmicrohttpd; NULL when out of memory. */
static struct MHD_Response *make_response(struct request *request)
{
    const struct reply *reply = &request->reply;
    if (reply->streaming && !reply->failed) {
        /* The kernel does not probe a connection while it has data to send. Only streams get this
         * timeout, since it would end other answers to slow readers. */
        setsockopt(request->fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &(unsigned){STREAM_ACK_MS},
                   sizeof(unsigned));
        return MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, STREAM_BYTES, read_stream,
                                                 request, NULL);
    }
    if (reply->failed || !reply->body || reply->bytes == 0)
        return MHD_create_response_from_buffer(0, (void *)"", MHD_RESPMEM_PERSISTENT);
    struct blob *blob = pen_http_blob_ref(reply->body);
    struct MHD_Response *response = MHD_create_response_from_buffer_with_free_callback_cls(
        reply->bytes, blob->content.data + reply->first, unref_body, blob);
    if (!response)
        pen_http_blob_unref(blob);
    return response;
}

/* Adds a field to an answer: a response of libmicrohttpd, or a text. */
typedef void field_adder(void *answer, const char *name, const char *value);

static void add_to_response(void *answer, const char *name, const char *value)
{
    MHD_add_response_header(answer, name, value);
}

static void add_to_text(void *answer, const char *name, const char *value)
{
    pen_buf_printf(answer, "%s: %s\r\n", name, value);
}

/* Adds the CORS fields: a page of an origin in --cors may read the answer. The answer then depends
 * on the field Origin. */
static void add_cors(const struct request *request, field_adder *add, void *answer)
{
    if (!request->http->cors)
        return;
    add(answer, "Vary", "Origin");
    if (!request->is_cross_origin)
        return;
    add(answer, "Access-Control-Allow-Origin", request->fields.origin);
    add(answer, "Access-Control-Expose-Headers", "ETag, Link, Location, Retry-After, X-Request-Id");
}

static void add_fields(const struct request *request, bool close, field_adder *add, void *answer)
{
    const struct reply *reply = &request->reply;
    for (int i = 0; !reply->failed && i < reply->field_count; i++)
        add(answer, reply->field[i].name, reply->field[i].value);
    add(answer, "X-Request-Id", request->id);
    add(answer, "X-Content-Type-Options", "nosniff");
    add_cors(request, add, answer);
    if (close)
        add(answer, "Connection", "close");
}

static enum MHD_Result send_reply(struct request *request)
{
    struct reply *reply = &request->reply;
    request->phase = PHASE_ANSWERED;
    if (request->gone) {
        reply->status = CLIENT_GONE;
        return MHD_NO;
    }
    if (reply->failed || reply->status == 0)
        reply->status = 503;
    struct MHD_Response *response = make_response(request);
    if (!response)
        return MHD_NO;
    add_fields(request,
               request->close ||
                   atomic_load_explicit(&request->http->stopping, memory_order_relaxed),
               add_to_response, response);
    /* A body that is still being sent makes the close linger (guard.c). */
    pen_guard_state(request->http->guard, request->fd,
                    request->refused_early ? PEER_BODY : PEER_SEND);
    enum MHD_Result queued =
        MHD_queue_response(request->connection, (unsigned)reply->status, response);
    MHD_destroy_response(response);
    return queued;
}

/* Answers at once if the route can; otherwise suspends the connection and queues the request. */
static enum MHD_Result dispatch(struct request *request)
{
    const struct route *route = request->route;
    const enum queue_id id = pen_http_route_queue(route, request);
    bool answered = route->quick && route->quick(request);
    if (!answered && id == QUEUE_NONE)
        answered = route->handle(request, NULL) == OUTCOME_ANSWERED;
    if (answered) {
        pen_http_request_encode(request);
        return send_reply(request);
    }
    request->phase = PHASE_WORK;
    pen_http_suspend(request);
    pen_http_executor_submit(request->http->executor, id, request);
    return MHD_YES;
}

/* Sets the client's address: the connection's, or the one that the trusted proxy names. */
static void find_client(struct request *request)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(request->connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    const struct pen_http *http = request->http;
    unsigned char *peer = request->address;
    const bool known = info && pen_http_address_of(info->client_addr, peer);
    request->is_from_proxy = http->has_proxy && known && memcmp(peer, http->proxy, 16) == 0;
    const char *forwarded = request->is_from_proxy ? request->fields.forwarded_for : NULL;
    /* Clients whose address from the proxy cannot be read count as one client. */
    request->address_is_shared =
        !forwarded && (!known || request->is_from_proxy || pen_http_address_is_loopback(peer));
    if (forwarded)
        pen_http_address_forwarded(forwarded, peer);
}

/* Called when the head is complete. libmicrohttpd closes the connection after an answer that is
 * queued now. So an answer is queued here only if a body follows that must not be read. Otherwise
 * it is queued in the next call. */
static enum MHD_Result begin(struct request *request, const char *method, const char *version)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(request->connection, MHD_CONNECTION_INFO_REQUEST_HEADER_SIZE);
    const size_t head_bytes = info ? info->header_size : 0; /* 1.0: the next call changes *info */
    request->method = method;
    request->head = strcmp(method, "HEAD") == 0;
    request->is_http_1_0 = strcmp(version, "HTTP/1.1") != 0;
    MHD_get_connection_values(request->connection, MHD_HEADER_KIND, on_field, &request->fields);
    pen_http_request_name(request);
    find_client(request);
    atomic_fetch_add_explicit(&request->http->active, 1, memory_order_relaxed);
    pen_http_request_admit(request, head_bytes);
    const char *length = request->fields.content_length;
    const bool has_body = (length && strcmp(length, "0") != 0) || request->fields.transfer_encoding;
    pen_guard_state(request->http->guard, request->fd, has_body ? PEER_BODY : PEER_WORK);
    request->refused_early = request->phase == PHASE_ANSWERED && has_body;
    return request->refused_early ? send_reply(request) : MHD_YES;
}

/* Answers in the middle of a body. libmicrohttpd cannot do that, so the answer is written to the
 * socket directly. This is safe, since nothing else is being sent on the connection. libmicrohttpd
 * then closes the connection, and the close lingers. */
static enum MHD_Result cut_short(struct request *request)
{
    const struct reply *reply = &request->reply;
    struct pen_buf text = {0};
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(request->connection, MHD_CONNECTION_INFO_GNUTLS_SESSION);
    pen_buf_printf(&text, "HTTP/1.1 %d %s\r\n", reply->status,
                   MHD_get_reason_phrase_for((unsigned)reply->status));
    add_fields(request, true, add_to_text, &text);
    pen_buf_printf(&text, "Content-Length: %zu\r\n\r\n", reply->bytes);
    if (reply->body)
        pen_buf_add(&text, reply->body->content.data, reply->bytes);
    if (!text.failed && info && info->tls_session)
        gnutls_record_send(info->tls_session, text.data, text.bytes);
    else if (!text.failed)
        (void)!send(request->fd, text.data, text.bytes, MSG_NOSIGNAL | MSG_DONTWAIT);
    pen_buf_release(&text);
    return MHD_NO;
}

void *pen_http_adapter_on_line(void *cls, const char *uri, struct MHD_Connection *connection)
{
    struct request *request = uri ? pen_http_request_new(cls, uri) : NULL;
    if (!request)
        return NULL;
    request->connection = connection;
    request->fd =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    pen_guard_state(request->http->guard, request->fd, PEER_HEAD);
    return request;
}

enum MHD_Result pen_http_adapter_on_access(void *cls, struct MHD_Connection *connection,
                                           const char *url, const char *method, const char *version,
                                           const char *data, size_t *bytes, void **state)
{
    (void)cls, (void)connection, (void)url;
    struct request *request = *state;
    if (!request)
        return MHD_NO;
    if (request->phase == PHASE_LINE)
        return begin(request, method, version);
    if (*bytes > 0) {
        pen_guard_received(request->http->guard, request->fd, *bytes);
        const bool more = pen_http_request_receive(request, data, *bytes);
        *bytes = 0;
        return more ? MHD_YES : cut_short(request);
    }
    return request->phase == PHASE_BODY ? dispatch(request) : send_reply(request);
}

void pen_http_adapter_on_completed(void *cls, struct MHD_Connection *connection, void **state,
                                   enum MHD_RequestTerminationCode why)
{
    (void)connection;
    struct pen_http *http = cls;
    struct request *request = *state;
    const bool complete = why == MHD_REQUEST_TERMINATED_COMPLETED_OK;
    *state = NULL;
    if (!request)
        return;
    if (complete && !request->refused_early)
        pen_guard_state(http->guard, request->fd, PEER_IDLE);
    uint64_t streamed = 0;
    if (request->stream) {
        streamed = pen_http_stream_close(request);
        setsockopt(request->fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &(unsigned){0}, sizeof(unsigned));
    }
    if (request->phase != PHASE_LINE) {
        pen_http_access_log_add(request, streamed, complete);
        atomic_fetch_sub_explicit(&http->active, 1, memory_order_relaxed);
    }
    pen_http_request_free(request);
}
