/* SPDX-License-Identifier: MIT */
#include "http/internal/request.h"

#include "base/clock.h"
#include "base/log.h"
#include "http/internal/http.h"

enum { METHOD_BYTES = 20, TARGET_BYTES = 300 }; /* the most of each in a line */

static void count(atomic_uint_least64_t *sum)
{
    atomic_fetch_add_explicit(sum, 1, memory_order_relaxed);
}

static enum pen_log_level level_of(const struct request *request, int status)
{
    struct pen_http *http = request->http;
    if (status == 429)
        count(&http->refused_429);
    else if (status == 503)
        count(&http->refused_503);
    else if (status >= 500)
        count(&http->failed);
    if (status >= 500 && status != 503)
        return PEN_LOG_WARN;
    return request->changed ? PEN_LOG_INFO : PEN_LOG_DEBUG;
}

void pen_http_access_log_add(const struct request *request, uint64_t streamed, bool complete)
{
    const struct reply *reply = &request->reply;
    const int64_t us = (pen_clock_ns() - request->begun_ns) / 1000;
    const bool sent = !request->head && reply->status != 304;
    const uint64_t bytes = streamed + (sent ? reply->bytes : 0);
    const struct pen_log_about about = {.job = request->job_id, .request = request->id};
    const char *trace = request->fields.traceparent;
    pen_log_about(level_of(request, reply->status), &about,
                  "%.*s %.*s %d %llu bytes %lld.%03lld ms%s%s%s%s%s", METHOD_BYTES, request->method,
                  TARGET_BYTES, request->raw_target, reply->status, (unsigned long long)bytes,
                  (long long)(us / 1000), (long long)(us % 1000), complete ? "" : " (cut short)",
                  request->holder.name[0] ? " by " : "", request->holder.name,
                  trace ? " traceparent=" : "", trace ? trace : "");
}
