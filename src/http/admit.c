/* SPDX-License-Identifier: MIT */
/* Admission: a request that can be refused by its request line and header fields is refused before
 * its body is read. The body of a refused request, if it has an allowed size, is still read and
 * discarded, so that a client that writes before it reads gets its answer and keeps its connection.
 * With `Expect: 100-continue`, or with a body over the limit, the answer is sent at once. */
#include "http/internal/admit.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/routes.h"

/* The limit of all bodies in memory together. Beyond it uploads are read, discarded and answered
 * 503. */
enum { INTAKE_BYTES = 256 << 20 };

/* Takes the client's own request id if it can be written into logs safely, else makes one. */
static void name_request(struct request *request)
{
    const char *theirs = request->fields.request_id;
    size_t length = theirs ? strspn(theirs, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                            "0123456789._-")
                           : 0;
    if (length > 0 && length < sizeof request->id && theirs[length] == '\0') {
        memcpy(request->id, theirs, length + 1);
        return;
    }
    struct pen_http *http = request->http;
    unsigned n = atomic_fetch_add_explicit(&http->request_count, 1, memory_order_relaxed);
    snprintf(request->id, sizeof request->id, "%08" PRIx32 "-%06x", http->id_prefix, n);
}

/* Checks Host and Origin, and fields that could make two servers read one request differently. */
static bool check_sender(const struct request *request, struct pen_status *st)
{
    const struct fields *fields = &request->fields;
    if (fields->repeated)
        return pen_fail(st, PEN_SYNTAX, "a header field that may be sent only once was repeated");
    if (fields->content_length && fields->transfer_encoding)
        return pen_fail(st, PEN_SYNTAX, "both Content-Length and Transfer-Encoding were sent");
    const char *host = request->target.authority ? request->target.authority : fields->host;
    if (!pen_host_is_loopback(host))
        return pen_fail(st, PEN_FORBIDDEN,
                        "the Host must be localhost, 127.0.0.1 or [::1], found \"%s\"",
                        host ? host : "");
    /* A browser lets a page of any site send simple requests to this server. It keeps the answers
     * from the page; the check here keeps the page from changing anything. */
    bool reads = strcmp(request->method, "GET") == 0 || request->head;
    if (!reads && fields->origin && !pen_origin_is_host(fields->origin, host))
        return pen_fail(st, PEN_FORBIDDEN, "requests from pages of %s are not allowed",
                        fields->origin);
    return true;
}

/* Job ids are UUIDs, for which upper and lower case are the same. Any other text names no job. */
static bool read_job_id(struct request *request, struct pen_status *st)
{
    static const char form[] = "xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx";
    const char *arg = request->arg;
    for (size_t i = 0; i < sizeof form; i++) {
        char c = arg[i];
        bool good = form[i] == 'x' ? isxdigit((unsigned char)c) != 0 : c == form[i];
        if (!good)
            return pen_fail(st, PEN_NOT_FOUND, "there is no job \"%.80s\"", arg);
        request->job_id[i] = (char)tolower((unsigned char)c);
    }
    return true;
}

static bool find_route(struct request *request, char allow[ALLOW_BYTES], struct pen_status *st)
{
    request->route =
        pen_http_route_find(request->method, &request->target, &request->arg, allow, st);
    if (!request->route || !pen_http_route_check_params(request->route, &request->target, st))
        return false;
    return strncmp(request->route->path, "/v1/jobs/{id}", 13) != 0 || read_job_id(request, st);
}

static bool check_length(struct request *request, struct pen_status *st)
{
    const struct fields *fields = &request->fields;
    size_t limit = request->http->limits.body_bytes;
    if (fields->transfer_encoding)
        return pen_fail(st, PEN_LENGTH, "chunked bodies are not accepted; send Content-Length");
    if (!fields->content_length)
        return !request->route->takes_body ||
               pen_fail(st, PEN_LENGTH, "a body with Content-Length is required here");
    if (request->declared_bytes > limit)
        return pen_fail(st, PEN_TOO_LARGE, "the body has %" PRIu64 " bytes, %zu are allowed",
                        request->declared_bytes, limit);
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
    return pen_fail(st, PEN_MEDIA_TYPE,
                    "a body of type %s is not accepted; application/json, text/xml and "
                    "application/xml in UTF-8 are",
                    request->fields.content_type);
}

static bool check_drain(const struct request *request, struct pen_status *st)
{
    struct pen_http *http = request->http;
    if (atomic_load_explicit(&http->stopping, memory_order_relaxed))
        return pen_fail(st, PEN_UNAVAILABLE, "the daemon is stopping");
    if (request->route->submits && atomic_load_explicit(&http->draining, memory_order_relaxed))
        return pen_fail(st, PEN_UNAVAILABLE,
                        "the daemon is draining and takes no new jobs; try again later");
    return true;
}

/* How much of a refused request's body is read and dropped. Without that the connection would be
 * closed with unread bytes, which resets it: a client that is still sending may lose its answer. */
static uint64_t discard_max(const struct request *request)
{
    return 2 * (uint64_t)request->http->limits.body_bytes;
}

/* Whether to read and discard the body of a refused request. The length of a chunked body is not
 * known yet; pen_http_request_receive bounds it. */
static bool wants_discard(const struct request *request)
{
    const struct fields *fields = &request->fields;
    bool waits = fields->expect && strcasecmp(fields->expect, "100-continue") == 0;
    if (fields->repeated || waits)
        return false;
    if (fields->transfer_encoding)
        return !fields->content_length && strcasecmp(fields->transfer_encoding, "chunked") == 0;
    return fields->content_length && request->declared_bytes <= discard_max(request);
}

void pen_http_request_admit(struct request *request)
{
    struct pen_status st;
    char allow[ALLOW_BYTES] = "";
    request->head = strcmp(request->method, "HEAD") == 0;
    name_request(request);
    if (request->fields.content_length)
        request->declared_bytes = strtoull(request->fields.content_length, NULL, 10);
    bool ok = pen_target_parse(request->raw_target, &request->target, &st) &&
              check_sender(request, &st) && find_route(request, allow, &st) &&
              check_length(request, &st) && check_media(request, &st) && check_drain(request, &st);
    if (ok) {
        request->phase = PHASE_BODY;
        return;
    }
    request->route = NULL;
    pen_http_request_fail(request, &st);
    if (allow[0])
        pen_http_reply_field(&request->reply, "Allow", "%s", allow);
    request->phase = wants_discard(request) ? PHASE_DISCARD : PHASE_ANSWERED;
}

bool pen_http_request_receive(struct request *request, const char *data, size_t bytes)
{
    request->received_bytes += bytes;
    const bool dropped = request->phase == PHASE_DISCARD;
    if (request->received_bytes >
        (dropped ? discard_max(request) : request->http->limits.body_bytes))
        return false;
    if (request->phase != PHASE_BODY || !request->route->takes_body)
        return true;
    atomic_size_t *intake = &request->http->intake_bytes;
    size_t before = atomic_fetch_add_explicit(intake, bytes, memory_order_relaxed);
    bool fits = before + bytes <= INTAKE_BYTES && pen_buf_add(&request->body, data, bytes);
    if (fits)
        return true;
    atomic_fetch_sub_explicit(intake, bytes, memory_order_relaxed);
    pen_http_request_drop_body(request);
    struct pen_status st;
    pen_fail(&st, PEN_UNAVAILABLE, "there is no memory for this body now; try again later");
    pen_http_request_fail(request, &st);
    request->phase = PHASE_DISCARD;
    return true;
}
