/* SPDX-License-Identifier: MIT */
/* Admission: a request that can be refused by its request line and header fields is refused before
 * its body is read. Its connection then closes, and the close lingers (guard.c). So a client that
 * writes before it reads gets its answer. */
#include "http/internal/request.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "http/internal/http.h"
#include "http/internal/routes.h"

enum { HEAD_BYTES = 6 << 10 }; /* largest head */

/* Reads a length. A larger number becomes UINT64_MAX. */
static bool read_length(const char *text, uint64_t *length)
{
    size_t digits = strspn(text, "0123456789");
    if (digits == 0 || text[digits] != '\0')
        return false;
    *length = strtoull(text, NULL, 10);
    return true;
}

/* Keeps a trace context (W3C Trace Context, version 00) only if it is well formed, so that it is
 * safe in logs. An id of zeros is not valid. */
static void check_traceparent(struct fields *fields)
{
    static const int part[] = {2, 32, 16, 2};
    const char *at = fields->traceparent;
    for (int i = 0; at && i < 4; i++) {
        const size_t digits = strspn(at, "0123456789abcdef"), zeros = strspn(at, "0");
        const bool id = i == 1 || i == 2;
        if (digits != (size_t)part[i] || (id && zeros == digits) ||
            at[digits] != (i < 3 ? '-' : '\0'))
            at = NULL;
        else
            at += digits + (i < 3);
    }
    if (!at || strncmp(fields->traceparent, "00-", 3) != 0)
        fields->traceparent = NULL;
}

/* Refuses heads that two servers could read differently and that libmicrohttpd accepts. */
static bool check_framing(struct request *request, struct pen_status *st)
{
    const struct fields *fields = &request->fields;
    if (!pen_text_is_plain(request->raw_target, " \t"))
        return pen_fail(st, PEN_SYNTAX,
                        "malformed HTTP: the request target has a space or a control character");
    if (fields->malformed)
        return pen_fail(st, PEN_SYNTAX,
                        "malformed HTTP: a header field has a character that is not allowed");
    if (fields->repeated)
        return pen_fail(st, PEN_SYNTAX, "a header field that may be sent only once was repeated");
    if (fields->content_length && fields->transfer_encoding)
        return pen_fail(st, PEN_SYNTAX, "both Content-Length and Transfer-Encoding were sent");
    if (fields->content_length && !read_length(fields->content_length, &request->declared_bytes))
        return pen_fail(st, PEN_SYNTAX, "Content-Length is \"%.40s\"; a number is allowed",
                        fields->content_length);
    if (!request->is_http_1_0 && !fields->host)
        return pen_fail(st, PEN_SYNTAX, "malformed HTTP: there is no Host");
    if (!fields->transfer_encoding)
        return true;
    if (request->is_http_1_0)
        return pen_fail(st, PEN_SYNTAX, "HTTP/1.0 has no Transfer-Encoding");
    return strcasecmp(fields->transfer_encoding, "chunked") == 0 ||
           pen_fail(st, PEN_SYNTAX, "Transfer-Encoding is \"%.40s\"; \"chunked\" is allowed",
                    fields->transfer_encoding);
}

static const char *host_of(const struct request *request)
{
    return request->target.authority ? request->target.authority : request->fields.host;
}

/* Checks the Host field if there are no tokens. Then every client that reaches the port may do
 * everything. So the Host must be a name of this machine. Otherwise a page of a foreign site could
 * resolve its own name to this machine. */
static bool check_host(const struct request *request, struct pen_status *st)
{
    const char *host = host_of(request);
    return request->http->tokens || pen_host_is_loopback(host) ||
           pen_fail(st, PEN_FORBIDDEN,
                    "the Host must be localhost, 127.0.0.1 or [::1], found \"%.200s\"",
                    host ? host : "");
}

/* Checks the Origin field. A browser lets a page of any site send simple requests to this server,
 * and names the page's origin. It must be the daemon's own, or one in --cors. */
static bool check_origin(struct request *request, struct pen_status *st)
{
    const struct pen_http *http = request->http;
    const struct fields *fields = &request->fields;
    const char *origin = fields->origin;
    const bool proxied = request->is_from_proxy && fields->forwarded_host;
    if (!origin ||
        (proxied ? pen_origin_is_host(origin, NULL, fields->forwarded_host)
                 : pen_origin_is_host(origin, http->tls ? "https" : "http", host_of(request))))
        return true;
    request->is_cross_origin = http->cors && pen_origin_listed(http->cors, origin);
    return request->is_cross_origin ||
           pen_fail(st, PEN_FORBIDDEN,
                    "requests from pages of %.200s are not allowed; the daemon's --cors allows "
                    "another site, --trusted-proxy a proxy",
                    origin);
}

/* Reads the job id of the path. Job ids are UUIDs; any other text names no job. */
static bool read_job_id(struct request *request, struct pen_status *st)
{
    return pen_uuid_parse(request->arg, request->job_id) ||
           pen_fail(st, PEN_NOT_FOUND, "there is no job \"%.80s\"", request->arg);
}

/* Checks the token before the path, so that an unknown path needs a token too. */
static bool check_token(struct request *request, struct pen_status *st)
{
    struct pen_tokens *tokens = request->http->tokens;
    const enum pen_scope needed = request->route ? request->route->scope : PEN_SCOPE_READ;
    if (!tokens || needed == PEN_SCOPE_NONE)
        return true;
    if (!pen_tokens_check(tokens, request->fields.authorization, &request->holder, st)) {
        pen_http_request_fail(request, st);
        pen_http_reply_field(&request->reply, "WWW-Authenticate", "Bearer realm=\"penumbra\"");
        return false;
    }
    request->address_is_shared = false;
    return request->holder.scope >= needed ||
           pen_fail(st, PEN_FORBIDDEN, "this needs a token of scope %s; yours has the scope %s",
                    pen_scope_names[needed - PEN_SCOPE_READ],
                    pen_scope_names[request->holder.scope - PEN_SCOPE_READ]);
}

static bool find_route(struct request *request, struct pen_status *st)
{
    char allow[ALLOW_BYTES] = "";
    struct pen_status unknown;
    request->route =
        pen_http_route_find(request->method, &request->target, &request->arg, allow, &unknown);
    if (!check_token(request, st))
        return false;
    if (!request->route) {
        *st = unknown;
        pen_http_request_fail(request, st);
        if (allow[0])
            pen_http_reply_field(&request->reply, "Allow", "%s", allow);
        return false;
    }
    if (!pen_http_route_check_params(request->route, &request->target, st))
        return false;
    return strncmp(request->route->path, "/v1/jobs/{id}", 13) != 0 || read_job_id(request, st);
}

static bool check_length(struct request *request, struct pen_status *st)
{
    const struct fields *fields = &request->fields;
    size_t limit = request->http->limits.body_bytes;
    if (!fields->content_length && !fields->transfer_encoding)
        return !request->route->takes_body ||
               pen_fail(st, PEN_LENGTH,
                        "a body is required here, with Content-Length or in chunks");
    if (request->declared_bytes > limit)
        return pen_fail(st, PEN_TOO_LARGE, "the body has %.40s bytes, %zu are allowed",
                        fields->content_length, limit);
    return true;
}

static bool check_media(const struct request *request, struct pen_status *st)
{
    if (!request->route->takes_body)
        return true;
    switch (pen_media_parse(request->fields.content_type)) {
    case PEN_MEDIA_NONE:
    case PEN_MEDIA_JSON:
    case PEN_MEDIA_XML:
        return true;
    case PEN_MEDIA_OTHER:
        break;
    }
    return pen_fail(
        st, PEN_MEDIA_TYPE,
        "a body of type \"%s\" is not accepted; application/json in UTF-8, text/xml and "
        "application/xml in UTF-8 or UTF-16 are",
        request->fields.content_type);
}

/* Checks Content-Encoding. "identity" means an uncompressed body, as a missing field does. */
static bool check_encoding(struct request *request, struct pen_status *st)
{
    const char *encoding = request->fields.content_encoding;
    if (encoding && strcasecmp(encoding, "identity") == 0)
        encoding = request->fields.content_encoding = NULL;
    return !encoding || !request->route->takes_body || strcasecmp(encoding, "gzip") == 0 ||
           pen_fail(st, PEN_MEDIA_TYPE,
                    "the Content-Encoding \"%.40s\" is not accepted; \"gzip\" and \"identity\" are",
                    encoding);
}

static bool check_drain(const struct request *request, struct pen_status *st)
{
    struct pen_http *http = request->http;
    if (request->route->queue != QUEUE_NONE && !pen_http_request_has_store(request, st)) {
        if (request->route->scope == PEN_SCOPE_NONE)
            pen_http_request_hide_reason(request, st);
        return false;
    }
    if (atomic_load_explicit(&http->stopping, memory_order_relaxed))
        return pen_fail(st, PEN_UNAVAILABLE, "the daemon is stopping");
    if (request->route->submits && atomic_load_explicit(&http->draining, memory_order_relaxed))
        return pen_fail(st, PEN_UNAVAILABLE,
                        "the daemon is draining and takes no new jobs; try again later");
    return true;
}

/* Answers a preflight request, with which a page of an allowed origin asks what it may send. It has
 * no token yet. */
static bool answer_preflight(struct request *request)
{
    struct reply *reply = &request->reply;
    if (strcmp(request->method, "OPTIONS") != 0 || !request->is_cross_origin)
        return false;
    reply->status = 204;
    pen_http_reply_field(reply, "Access-Control-Allow-Methods", "GET, HEAD, POST, DELETE");
    pen_http_reply_field(reply, "Access-Control-Allow-Headers",
                         "Authorization, Content-Type, Content-Encoding, Idempotency-Key, "
                         "If-None-Match, Last-Event-ID, Range, X-Request-Id");
    pen_http_reply_field(reply, "Access-Control-Max-Age", "600");
    return true;
}

/* Returns whether the request is admitted. If not, *st has the reason, or the reply is filled. */
static bool admit(struct request *request, struct pen_status *st)
{
    return pen_target_parse(request->raw_target, &request->target, st) && check_host(request, st) &&
           check_origin(request, st) && !answer_preflight(request) && find_route(request, st) &&
           check_length(request, st) && check_media(request, st) && check_encoding(request, st) &&
           check_drain(request, st);
}

void pen_http_request_admit(struct request *request, size_t head_bytes)
{
    struct pen_status st = {.code = PEN_OK};
    check_traceparent(&request->fields);
    bool ok = check_framing(request, &st);
    request->close = !ok;
    if (ok && head_bytes > HEAD_BYTES) {
        pen_fail(&st, PEN_USAGE, "the request's head has %zu bytes, %d are allowed", head_bytes,
                 HEAD_BYTES);
        pen_http_request_refuse(request, 431, &st);
        ok = false;
    }
    ok = ok && admit(request, &st);
    request->phase = PHASE_BODY;
    if (ok)
        return;
    request->route = NULL;
    if (request->reply.status == 0)
        pen_http_request_fail(request, &st);
    request->phase = PHASE_ANSWERED;
}

bool pen_http_request_receive(struct request *request, const char *data, size_t bytes)
{
    struct pen_status st;
    size_t limit = request->http->limits.body_bytes;
    request->received_bytes += bytes;
    if (request->received_bytes > limit)
        pen_fail(&st, PEN_TOO_LARGE, "the body has more than the %zu bytes that are allowed",
                 limit);
    else if (!request->route->takes_body || (pen_http_request_count_body(request, bytes) &&
                                             pen_buf_add(&request->body, data, bytes)))
        return true;
    else
        pen_fail(&st, PEN_UNAVAILABLE, "there is no memory for this body now; try again later");
    pen_http_request_drop_body(request);
    pen_http_request_fail(request, &st);
    return false;
}
