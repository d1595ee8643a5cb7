/* SPDX-License-Identifier: MIT */
/* Making, answering and freeing a request. */
#include "http/internal/request.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "http/internal/http.h"
#include "jobs/jobs.h"

struct request *pen_http_request_new(struct pen_http *http, const char *raw_target)
{
    struct request *request = calloc(1, sizeof *request);
    if (!request)
        return NULL;
    request->http = http;
    request->begun_ns = pen_clock_ns();
    request->raw_target = strdup(raw_target);
    if (!request->raw_target) {
        free(request);
        return NULL;
    }
    return request;
}

void pen_http_request_free(struct request *request)
{
    if (!request)
        return;
    pen_http_request_drop_body(request);
    pen_http_reply_release(&request->reply);
    pen_target_release(&request->target);
    free(request->raw_target);
    free(request);
}

void pen_http_request_drop_body(struct request *request)
{
    atomic_fetch_sub_explicit(&request->http->intake_bytes, request->body.bytes,
                              memory_order_relaxed);
    pen_buf_release(&request->body);
}

void pen_http_request_fail(struct request *request, const struct pen_status *st)
{
    pen_http_reply_problem(&request->reply, pen_problem(st), request->id);
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
