/* SPDX-License-Identifier: MIT */
#include "http/internal/streams.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/routes.h"
#include "http/internal/snapshot_cache.h"
#include "http/internal/watch.h"

struct stream {
    struct event_cursor cursor; /* place of the stream after `text` */
    struct blob *text;          /* the text that is being sent; NULL: none */
    size_t sent;                /* bytes of text */
    uint64_t total;             /* bytes sent before text */
    uint32_t changes;           /* the change counter from before the last text was written */
    bool over;                  /* `text` is the last one */
};

/* Gives the stream its next text, and sets the time of its heartbeat. If more events are due, it is
 * now. */
static void set_text(struct request *request, struct blob *text)
{
    struct stream *stream = request->stream;
    stream->text = text;
    request->deadline_ns = stream->cursor.more ? 0 : pen_clock_ns() + request->http->heartbeat_ns;
}

void pen_http_stream_end(struct stream *stream)
{
    stream->over = true;
}

ssize_t pen_http_stream_read(struct request *request, char *out, size_t bytes)
{
    struct stream *stream = request->stream;
    if (!stream->text) {
        const bool waits =
            !stream->over && !request->gone &&
            pen_http_watch_add(request->http->watch, request, stream->changes) == WATCH_ACCEPTED;
        return waits ? 0 : -1; /* the watcher has a waiting request */
    }
    const struct pen_buf *text = &stream->text->content;
    const size_t left = text->bytes - stream->sent;
    const size_t part = left < bytes ? left : bytes;
    memcpy(out, text->data + stream->sent, part);
    stream->sent += part;
    stream->total += part;
    if (part == left) {
        pen_http_blob_unref(stream->text);
        stream->text = NULL;
        stream->sent = 0;
    }
    return (ssize_t)part;
}

uint64_t pen_http_stream_close(struct request *request)
{
    struct stream *stream = request->stream;
    const uint64_t total = stream->total;
    pen_http_blob_unref(stream->text);
    free(stream);
    request->stream = NULL;
    atomic_fetch_sub_explicit(&request->http->streams, 1, memory_order_relaxed);
    return total;
}

void pen_http_stream_texts_release(struct stream_texts *texts)
{
    while (texts->count > 0)
        pen_http_blob_unref(texts->text[--texts->count].text);
}

/* Writes the next text from a place on. If the store cannot be read now, there is no text, and the
 * next one has these events too. The streams of a deleted job end. */
static void write_text(struct pen_http *http, struct pen_jobs *jobs, uint32_t changes,
                       struct stream_text *out)
{
    struct snapshot snapshot;
    struct pen_status st;
    struct pen_buf text = {0};
    if (!pen_http_snapshot_cache_read(http->snapshot_cache, changes, jobs, out->job_id, &snapshot,
                                      &st)) {
        out->over = st.code == PEN_NOT_FOUND || st.code == PEN_GONE;
        return;
    }
    if (!pen_http_events_write(&snapshot, jobs, &out->to, &text, &st))
        pen_log_about(PEN_LOG_WARN, &(struct pen_log_about){.job = out->job_id}, "events: %s",
                      st.msg);
    else if (text.bytes > 0)
        out->text = pen_http_blob_take(&text);
    if (!out->text)
        out->to = out->from;
    out->over = pen_http_events_are_over(&out->to);
    pen_buf_release(&text);
    pen_http_snapshot_release(&snapshot);
}

static const struct stream_text *find_text(struct request *request, struct pen_jobs *jobs,
                                           uint32_t changes, struct stream_texts *texts)
{
    const struct event_cursor *at = &request->stream->cursor;
    for (int i = 0; i < texts->count; i++) {
        const struct stream_text *text = &texts->text[i];
        if (text->from.id == at->id && text->from.job_sent == at->job_sent &&
            text->from.state == at->state && strcmp(text->job_id, request->job_id) == 0)
            return text;
    }
    if (texts->count == STREAM_TEXTS)
        pen_http_stream_texts_release(texts);
    struct stream_text *text = &texts->text[texts->count++];
    *text = (struct stream_text){.from = *at, .to = *at};
    memcpy(text->job_id, request->job_id, sizeof text->job_id);
    write_text(request->http, jobs, changes, text);
    return text;
}

static struct blob *heartbeat(void)
{
    struct pen_buf text = {0};
    pen_buf_puts(&text, ": still here\n\n");
    return pen_http_blob_take(&text);
}

bool pen_http_stream_advance(struct request *request, struct pen_jobs *jobs, uint32_t changes,
                             struct stream_texts *texts)
{
    struct stream *stream = request->stream;
    struct pen_tokens *tokens = request->http->tokens;
    stream->over = tokens && !pen_tokens_holds(tokens, &request->holder);
    if (stream->over)
        return true;
    const struct stream_text *next = find_text(request, jobs, changes, texts);
    stream->changes = changes;
    stream->over = next->over;
    if (next->text) {
        stream->cursor = next->to;
        set_text(request, pen_http_blob_ref(next->text));
    } else if (request->deadline_ns <= pen_clock_ns()) {
        stream->cursor.more = false; /* no text could be written; the next change tries again */
        set_text(request, heartbeat());
    }
    return stream->text || stream->over;
}

static bool open_stream(struct request *request, struct pen_jobs *jobs,
                        const struct snapshot *snapshot, struct event_cursor *cursor,
                        uint32_t changes, struct pen_status *st)
{
    struct pen_http *http = request->http;
    struct pen_buf text = {0};
    struct stream *stream = NULL;
    if (atomic_fetch_add_explicit(&http->streams, 1, memory_order_relaxed) >= WATCH_MAX) {
        pen_fail(st, PEN_UNAVAILABLE, "%d event streams are open already; try again later",
                 WATCH_MAX);
    } else {
        pen_buf_puts(&text, "retry: 2000\n\n");
        if (pen_http_events_write(snapshot, jobs, cursor, &text, st)) {
            stream = calloc(1, sizeof *stream);
            pen_fail(st, PEN_NO_MEMORY,
                     "no memory for a stream of events"); /* if memory is missing */
        }
    }
    struct blob *first = stream ? pen_http_blob_take(&text) : NULL;
    pen_buf_release(&text);
    if (!first) {
        atomic_fetch_sub_explicit(&http->streams, 1, memory_order_relaxed);
        free(stream);
        return false;
    }
    *stream = (struct stream){
        .cursor = *cursor, .changes = changes, .over = pen_http_events_are_over(cursor)};
    request->stream = stream;
    set_text(request, first);
    return true;
}

/* Opens a stream. A store thread writes the events until now; the watcher's thread writes the later
 * ones. */
enum outcome pen_http_handle_events(struct request *request, struct pen_jobs *jobs)
{
    struct pen_http *http = request->http;
    struct reply *reply = &request->reply;
    struct snapshot snapshot;
    struct pen_status st;
    const uint32_t changes = pen_store_changes();
    if (!pen_http_snapshot_cache_read(http->snapshot_cache, changes, jobs, request->job_id,
                                      &snapshot, &st)) {
        pen_http_request_fail(request, &st);
        return OUTCOME_ANSWERED;
    }
    struct event_cursor cursor = pen_http_events_begin(request->fields.last_event_id, &snapshot);
    if (pen_http_events_are_complete(&cursor, &snapshot)) {
        reply->status = 204; /* makes a browser's EventSource stop reconnecting */
    } else if (request->head || open_stream(request, jobs, &snapshot, &cursor, changes, &st)) {
        reply->status = 200;
        reply->streaming = true;
        pen_http_reply_field(reply, "Content-Type", "text/event-stream");
        pen_http_reply_field(reply, "Cache-Control", "no-store");
        pen_http_reply_field(reply, "X-Accel-Buffering", "no"); /* a proxy must not buffer events */
    } else {
        pen_http_request_fail(request, &st);
    }
    pen_http_snapshot_release(&snapshot);
    return OUTCOME_ANSWERED;
}
