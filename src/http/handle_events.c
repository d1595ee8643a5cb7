/* SPDX-License-Identifier: MIT */
/* Opening an event stream. A store thread writes the events up to now, here; the watcher's thread
 * writes those that follow. */
#include "http/internal/handlers.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/snapshot_cache.h"
#include "http/internal/streams.h"
#include "http/internal/watch.h"

static void answer_stream(struct request *request)
{
    struct reply *reply = &request->reply;
    reply->status = 200;
    reply->streaming = true;
    pen_http_reply_field(reply, "Content-Type", "text/event-stream");
    pen_http_reply_field(reply, "Cache-Control", "no-store");
    pen_http_reply_field(reply, "X-Accel-Buffering", "no"); /* a proxy must not hold events back */
}

static bool count_stream(struct request *request, struct pen_status *st)
{
    struct watch *watch = request->http->watch;
    enum watch_result result = pen_http_watch_add_stream(watch);
    return result == WATCH_ACCEPTED || pen_http_watch_fail(result, st);
}

static bool open_stream(struct request *request, struct pen_jobs *jobs,
                        const struct snapshot *snapshot, struct event_cursor *cursor,
                        struct pen_status *st)
{
    struct pen_buf text = {0};
    if (!count_stream(request, st))
        return false;
    pen_buf_puts(&text, "retry: 2000\n\n");
    bool ok = pen_http_events_write(snapshot, jobs, cursor, &text, st);
    if (ok) {
        request->stream = pen_http_stream_open(request->http->streams, request, cursor, &text);
        ok = request->stream || pen_fail(st, PEN_NO_MEMORY, "no memory for a stream of events");
    }
    if (!ok)
        pen_http_watch_remove_stream(request->http->watch);
    pen_buf_release(&text);
    return ok;
}

enum outcome pen_http_handle_events(struct request *request, struct pen_jobs *jobs)
{
    struct pen_http *http = request->http;
    struct snapshot snapshot;
    struct pen_status st;
    uint32_t changes = pen_http_watch_changes(http->watch);
    if (!pen_http_snapshot_cache_read(http->snapshot_cache, changes, jobs, request->job_id,
                                      &snapshot, &st)) {
        pen_http_request_fail(request, &st);
        return OUTCOME_ANSWERED;
    }
    struct event_cursor cursor = pen_http_events_begin(request->fields.last_event_id, &snapshot);
    if (pen_http_events_are_complete(&cursor, &snapshot))
        request->reply.status = 204; /* makes a browser's EventSource stop reconnecting */
    else if (request->head || open_stream(request, jobs, &snapshot, &cursor, &st))
        answer_stream(request);
    else
        pen_http_request_fail(request, &st);
    pen_http_snapshot_release(&snapshot);
    if (request->stream)
        pen_http_watch_stream_opened(http->watch, changes);
    return OUTCOME_ANSWERED;
}
