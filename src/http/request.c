/* SPDX-License-Identifier: MIT */
/* Making, answering and freeing a request. */
#include "http/internal/request.h"

#include <inttypes.h>
#include <microhttpd.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "http/internal/addresses.h"
#include "http/internal/guard.h"
#include "http/internal/http.h"
#include "http/internal/routes.h"
#include "jobs/jobs.h"

enum { BODIES_BYTES = 256 << 20 };

void pen_http_request_name(struct request *request)
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
    snprintf(request->id, sizeof request->id, "%08" PRIx32 "-%06" PRIx32, http->id_prefix, n);
}

struct request *pen_http_request_new(struct pen_http *http, const char *raw_target)
{
    const size_t bytes = strlen(raw_target) + 1;
    struct request *request = calloc(1, sizeof *request + bytes);
    if (!request)
        return NULL;
    request->http = http;
    request->begun_ns = pen_clock_ns();
    request->method = "-";
    memcpy(request->raw_target, raw_target, bytes);
    return request;
}

void pen_http_request_free(struct request *request)
{
    if (!request)
        return;
    pen_http_request_drop_body(request);
    pen_http_reply_release(&request->reply);
    pen_target_release(&request->target);
    free(request);
}

bool pen_http_request_has_store(const struct request *request, struct pen_status *st)
{
    struct pen_http *http = request->http;
    if (atomic_load_explicit(&http->opened, memory_order_acquire))
        return true;
    pthread_mutex_lock(&http->ready_lock);
    *st = http->store_fault;
    pthread_mutex_unlock(&http->ready_lock);
    return false;
}

void pen_http_request_hide_reason(const struct request *request, struct pen_status *st)
{
    struct pen_token_holder holder;
    struct pen_status ignored;
    struct pen_tokens *tokens = request->http->tokens;
    if (tokens && !pen_tokens_check(tokens, request->fields.authorization, &holder, &ignored))
        pen_fail(st, PEN_UNAVAILABLE, "the daemon is not ready; with a token it says why");
}

void pen_http_suspend(struct request *request)
{
    pen_guard_state(request->http->guard, request->fd, PEER_WORK);
    MHD_suspend_connection(request->connection);
}

void pen_http_resume(struct request *request)
{
    request->phase = PHASE_ANSWERED;
    MHD_resume_connection(request->connection);
}

bool pen_http_request_count_body(struct request *request, size_t bytes)
{
    atomic_size_t *sum = &request->http->body_bytes;
    if (atomic_fetch_add_explicit(sum, bytes, memory_order_relaxed) + bytes > BODIES_BYTES) {
        atomic_fetch_sub_explicit(sum, bytes, memory_order_relaxed);
        return false;
    }
    request->counted_bytes += bytes;
    return true;
}

void pen_http_request_drop_body(struct request *request)
{
    atomic_fetch_sub_explicit(&request->http->body_bytes, request->counted_bytes,
                              memory_order_relaxed);
    request->counted_bytes = 0;
    pen_buf_release(&request->body);
}

void pen_http_request_refuse(struct request *request, int http_status, const struct pen_status *st)
{
    struct pen_buf text = {0};
    pen_problem_write(&text, st, http_status, request->id);
    pen_http_reply_problem(&request->reply, http_status ? http_status : pen_code_http(st->code),
                           pen_http_blob_take(&text));
}

enum outcome pen_http_request_fail(struct request *request, const struct pen_status *st)
{
    pen_http_request_refuse(request, 0, st);
    return OUTCOME_ANSWERED;
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

bool pen_http_request_is_true(const struct request *request, const char *name)
{
    const char *text = pen_http_request_param(request, name);
    return text && strcmp(text, "true") == 0;
}

const char *pen_http_request_client(const struct request *request, char text[CLIENT_BYTES])
{
    if (request->holder.name[0])
        snprintf(text, CLIENT_BYTES, "token:%s", request->holder.name);
    else
        pen_http_address_text(request->address, text, CLIENT_BYTES);
    return text;
}

const char *pen_http_request_owner(const struct request *request, char text[CLIENT_BYTES])
{
    return request->holder.scope == PEN_SCOPE_SUBMIT ? pen_http_request_client(request, text)
                                                     : NULL;
}

/* The part that a GET requests. If-Range must be the entity tag, byte for byte. A date never
 * matches, since the server sends no dates. */
static enum pen_range_kind read_range(const struct request *request, const struct content *content,
                                      uint64_t *first, uint64_t *count)
{
    const struct fields *fields = &request->fields;
    if (!content->ranges || !content->blob || !fields->range || request->head ||
        (fields->if_range && strcmp(fields->if_range, content->etag) != 0))
        return PEN_RANGE_WHOLE;
    return pen_range_parse(fields->range, content->blob->content.bytes, first, count);
}

static enum outcome fail_range(struct request *request, struct blob *blob)
{
    struct pen_status st;
    const size_t bytes = blob->content.bytes;
    pen_http_blob_unref(blob);
    pen_fail(&st, PEN_RANGE, "the range %s lies outside the picture's %zu bytes",
             request->fields.range, bytes);
    pen_http_request_fail(request, &st);
    pen_http_reply_field(&request->reply, "Content-Range", "bytes */%zu", bytes);
    pen_http_reply_field(&request->reply, "Accept-Ranges", "bytes");
    return OUTCOME_ANSWERED;
}

enum outcome pen_http_request_content(struct request *request, const struct content *content)
{
    struct reply *reply = &request->reply;
    const char *known = request->fields.if_none_match;
    enum pen_range_kind range = PEN_RANGE_WHOLE;
    uint64_t first, count;
    int status = 200;
    if (known && pen_etag_known(known, content->etag))
        status = 304;
    else if ((range = read_range(request, content, &first, &count)) == PEN_RANGE_OUTSIDE)
        return fail_range(request, content->blob);
    else if (range == PEN_RANGE_PART)
        status = 206;
    /* The Content-Length of a 304 is that of the 200. */
    pen_http_reply_body(reply, status, content->blob, content->type);
    pen_http_reply_field(reply, "ETag", "%s", content->etag);
    pen_http_reply_field(reply, "Cache-Control", "%s", content->cache_control);
    if (content->ranges)
        pen_http_reply_field(reply, "Accept-Ranges", "bytes");
    if (status == 206) {
        reply->first = (size_t)first;
        reply->bytes = (size_t)count;
        pen_http_reply_field(reply, "Content-Range", "bytes %zu-%zu/%zu", reply->first,
                             reply->first + reply->bytes - 1, content->blob->content.bytes);
    }
    return OUTCOME_ANSWERED;
}

enum outcome pen_http_request_json(struct request *request, int http_status, json_t *json)
{
    pen_http_reply_body(&request->reply, http_status, pen_http_blob_json(json), "application/json");
    json_decref(json);
    pen_http_reply_field(&request->reply, "Cache-Control", "no-store");
    return OUTCOME_ANSWERED;
}
