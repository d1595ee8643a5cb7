/* SPDX-License-Identifier: MIT */
/* Making, answering and freeing a request. */
#include "http/internal/request.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/clock.h"
#include "http/internal/access_log.h"
#include "http/internal/http.h"
#include "http/internal/intake.h"
#include "http/internal/routes.h"
#include "http/wire.h"
#include "jobs/jobs.h"

/* The header fields that the server reads. */
static const struct {
    const char *name;
    size_t offset;
    bool single; /* a request that has the field twice is refused */
    bool last;   /* of several fields, the last one counts; else the first */
} read_fields[] = {
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
    {.name = "If-None-Match", .offset = offsetof(struct fields, if_none_match)},
    {.name = "Range", .offset = offsetof(struct fields, range)},
    {.name = "If-Range", .offset = offsetof(struct fields, if_range)},
    {.name = "Origin", .offset = offsetof(struct fields, origin), .single = true},
    {.name = "traceparent", .offset = offsetof(struct fields, traceparent)},
    {.name = "X-Request-Id", .offset = offsetof(struct fields, request_id)},
    {.name = "Expect", .offset = offsetof(struct fields, expect)},
    {.name = "Last-Event-ID", .offset = offsetof(struct fields, last_event_id)},
    {.name = "Accept", .offset = offsetof(struct fields, accept)},
    {.name = "Accept-Encoding", .offset = offsetof(struct fields, accept_encoding)},
    {.name = "X-Forwarded-For", .offset = offsetof(struct fields, forwarded_for), .last = true},
    {.name = "Connection", .offset = offsetof(struct fields, connection)},
};

/* Keeps the value of a header field that the server reads; notes a repeated one. */
static void read_field(struct fields *fields, const struct pen_head_field *sent)
{
    for (size_t i = 0; i < sizeof read_fields / sizeof read_fields[0]; i++) {
        if (strcasecmp(sent->name, read_fields[i].name) != 0)
            continue;
        const char **field = (const char **)((char *)fields + read_fields[i].offset);
        if (*field && field == &fields->connection)
            *field = pen_list_has_token(sent->value, "close") ? sent->value : *field;
        else if (*field && !read_fields[i].last)
            fields->repeated = fields->repeated || read_fields[i].single;
        else
            *field = sent->value;
    }
}

/* Writes a number in so many hexadecimal digits, and a zero byte. */
static void write_hex(char *out, uint32_t number, int digits)
{
    out[digits] = '\0';
    for (int i = digits - 1; i >= 0; i--, number >>= 4)
        out[i] = "0123456789abcdef"[number & 15];
}

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
    uint32_t n = atomic_fetch_add_explicit(&http->request_count, 1, memory_order_relaxed);
    write_hex(request->id, http->id_prefix, 8);
    request->id[8] = '-';
    write_hex(request->id + 9, n, n < 1 << 24 ? 6 : 8);
}

static void read_head(struct request *request, size_t bytes)
{
    struct pen_head head;
    struct pen_status st;
    int refused = pen_head_parse(request->text, bytes, &head, &st);
    for (int i = 0; i < head.field_count; i++)
        read_field(&request->fields, &head.field[i]);
    name_request(request);
    if (refused) {
        pen_http_request_refuse(request, refused, &st);
        return;
    }
    request->raw_target = head.target;
    request->method = head.method;
    request->minor = head.minor;
    request->head = strcmp(head.method, "HEAD") == 0;
}

/* Counts this head with others that are in memory, in place of what was counted for it before. */
static void count_head(struct request *request, size_t bytes)
{
    atomic_fetch_add_explicit(&request->http->head_bytes, bytes - request->head_bytes,
                              memory_order_relaxed);
    request->head_bytes = bytes;
}

struct request *pen_http_request_new(struct pen_http *http, const char *head, size_t bytes)
{
    struct request *request = malloc(sizeof *request);
    char *text = malloc(bytes + 1);
    if (!request || !text) {
        free(request);
        free(text);
        return NULL;
    }
    if (bytes > 0)
        memcpy(text, head, bytes);
    *request = (struct request){.http = http,
                                .begun_ns = pen_clock_ns(),
                                .text = text,
                                .raw_target = "-",
                                .method = "-",
                                .minor = 1};
    if (bytes > 0) {
        read_head(request, bytes);
    } else {
        name_request(request);
        request->phase = PHASE_ANSWERED;
    }
    count_head(request, bytes + strlen(request->raw_target) + 2); /* `target` has a copy */
    return request;
}

void pen_http_request_free(struct request *request)
{
    if (!request)
        return;
    pen_http_request_drop_body(request);
    pen_http_reply_release(&request->reply);
    pen_target_release(&request->target);
    count_head(request, 0);
    free(request->text);
    free(request);
}

/* Copies the beginning of a text, and a zero. Returns where the next text goes. */
static char *keep(char *to, const char *text, size_t bytes)
{
    memcpy(to, text, bytes);
    to[bytes] = '\0';
    return to + bytes + 1;
}

void pen_http_request_drop_head(struct request *request)
{
    enum { SMALL_BYTES = 512 }; /* a head that is not worth it */
    const char *trace = request->fields.traceparent ? request->fields.traceparent : "";
    const size_t method = strnlen(request->method, LOGGED_METHOD_BYTES);
    const size_t target = strnlen(request->raw_target, LOGGED_TARGET_BYTES);
    const size_t bytes = method + target + strlen(trace) + 3;
    char *kept = request->head_bytes > SMALL_BYTES ? malloc(bytes) : NULL;
    if (!kept)
        return;
    char *kept_target = keep(kept, request->method, method);
    char *kept_trace = keep(kept_target, request->raw_target, target);
    keep(kept_trace, trace, strlen(trace));
    pen_target_release(&request->target);
    free(request->text);
    request->text = kept;
    request->method = kept;
    request->raw_target = kept_target;
    request->fields = (struct fields){.traceparent = *trace ? kept_trace : NULL};
    request->arg = NULL;
    count_head(request, bytes);
}

bool pen_http_request_only_answers(const struct request *request)
{
    return request->head || strcmp(request->method, "GET") == 0 || request->route->only_answers;
}

void pen_http_request_drop_body(struct request *request)
{
    atomic_fetch_sub_explicit(&request->http->intake_bytes, request->body.bytes,
                              memory_order_relaxed);
    pen_buf_release(&request->body);
    pen_http_intake_leave(request);
}

void pen_http_request_refuse(struct request *request, int http_status, const struct pen_status *st)
{
    struct pen_buf text = {0};
    pen_problem_write(&text, st, http_status, request->id);
    pen_http_reply_problem(&request->reply, http_status, &text);
    request->phase = PHASE_ANSWERED;
    request->close = true;
}

void pen_http_request_fail(struct request *request, const struct pen_status *st)
{
    struct pen_buf text = {0};
    pen_problem_write(&text, st, 0, request->id);
    pen_http_reply_problem(&request->reply, pen_code_http(st->code), &text);
}

const char *pen_http_request_param(const struct request *request, const char *name)
{
    return pen_target_param(&request->target, name);
}

long pen_http_request_number(const struct request *request, const char *name, long otherwise)
{
    const char *text = pen_http_request_param(request, name);
    return text ? strtol(text, NULL, 10) : otherwise;
}

void pen_http_request_content(struct request *request, const struct content *content)
{
    const struct fields *fields = &request->fields;
    bool ranges = content->ranges && !request->head; /* Range is defined for GET only */
    struct reply_conditions conditions = {.if_none_match = fields->if_none_match,
                                          .range = ranges ? fields->range : NULL,
                                          .if_range = fields->if_range};
    size_t size = content->blob ? content->blob->content.bytes : 0;
    if (pen_http_reply_content(&request->reply, content->blob, content->type, content->etag,
                               &conditions)) {
        pen_http_reply_field(&request->reply, "Cache-Control", "%s", content->cache_control);
    } else {
        struct pen_status st;
        pen_fail(&st, PEN_RANGE, "the range %s lies outside the picture's %zu bytes", fields->range,
                 size);
        pen_http_request_fail(request, &st);
        pen_http_reply_field(&request->reply, "Content-Range", "bytes */%zu", size);
    }
    if (content->ranges)
        pen_http_reply_field(&request->reply, "Accept-Ranges", "bytes");
}
