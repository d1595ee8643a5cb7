/* SPDX-License-Identifier: MIT */
/* One lock guards all streams: it is held for copies and pointer changes, never while the store is
 * asked. The watcher notes which texts are wanted under the lock, writes them without it, and
 * hands them out under it again; a stream that has gone meanwhile is just not found.
 *
 * Order of locks: the streams' lock, then those of pen_http_adapter_wake. */
#include "http/internal/streams.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "http/internal/adapter.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/watch.h"

struct stream {
    struct streams *streams;
    struct request *request;
    char job_id[PEN_ID_BYTES];
    uint64_t key; /* of job_id */
    /* guarded by the streams' lock: */
    struct stream *next, **link;
    struct frame *frame;        /* for it, in the look that goes on; NULL: none */
    struct event_cursor cursor; /* as it will be when text is sent */
    struct blob *text;          /* what is being sent; NULL: nothing */
    size_t sent;                /* bytes of it */
    uint64_t total;             /* bytes sent before it */
    int64_t said_ns;            /* when there last was a text */
    bool missed;                /* a look went by while it was sending, or was not enough */
    bool ended;                 /* nothing comes after text */
};

/* What streams of one job that stand at the same place are told. */
struct frame {
    char job_id[PEN_ID_BYTES];
    uint64_t key;
    struct event_cursor from, to;
    struct blob *text; /* NULL: nothing new */
    bool over;
};

struct streams {
    struct pen_http *http;
    int64_t beat_ns;
    struct blob *beat;
    pthread_mutex_t lock;
    struct stream *list;  /* guarded by lock */
    int count;            /* guarded by lock */
    bool ended;           /* guarded by lock */
    struct frame *frames; /* of the watcher's thread */
    int frame_count, frame_capacity;
};

struct streams *pen_http_streams_new(struct pen_http *http, int beat_ms)
{
    struct streams *streams = calloc(1, sizeof *streams);
    struct pen_buf text = {0};
    pen_buf_puts(&text, ": still here\n\n");
    struct blob *beat = pen_http_blob_take(&text);
    if (!streams || !beat) {
        pen_http_blob_unref(beat);
        free(streams);
        return NULL;
    }
    *streams = (struct streams){.http = http, .beat_ns = beat_ms * INT64_C(1000000), .beat = beat};
    pthread_mutex_init(&streams->lock, NULL);
    return streams;
}

void pen_http_streams_free(struct streams *streams)
{
    if (!streams)
        return;
    pthread_mutex_destroy(&streams->lock);
    pen_http_blob_unref(streams->beat);
    free(streams->frames);
    free(streams);
}

/* The random end of a UUIDv7: tells ids apart at a glance. */
static uint64_t key_of(const char *job_id)
{
    uint64_t key;
    memcpy(&key, job_id + PEN_ID_BYTES - 1 - sizeof key, sizeof key);
    return key;
}

struct stream *pen_http_stream_open(struct streams *streams, struct request *request,
                                    const struct event_cursor *cursor, struct pen_buf *text)
{
    struct stream *stream = calloc(1, sizeof *stream);
    struct blob *blob = stream ? pen_http_blob_take(text) : NULL;
    if (!blob) {
        free(stream);
        return NULL;
    }
    *stream = (struct stream){.streams = streams,
                              .request = request,
                              .cursor = *cursor,
                              .text = blob,
                              .missed = cursor->more,
                              .said_ns = pen_clock_ns(),
                              .ended = pen_http_events_are_over(cursor)};
    memcpy(stream->job_id, request->job_id, sizeof stream->job_id);
    stream->key = key_of(stream->job_id);
    pthread_mutex_lock(&streams->lock);
    stream->ended = stream->ended || streams->ended;
    stream->next = streams->list;
    stream->link = &streams->list;
    if (stream->next)
        stream->next->link = &stream->next;
    streams->list = stream;
    streams->count++;
    pthread_mutex_unlock(&streams->lock);
    return stream;
}

/* Forgets a text that was sent. Returns whether the stream has to be looked at out of turn. */
static bool finish_text(struct stream *stream)
{
    stream->total += stream->sent;
    stream->sent = 0;
    pen_http_blob_unref(stream->text);
    stream->text = NULL;
    bool missed = stream->missed && !stream->ended;
    stream->missed = false;
    return missed;
}

ssize_t pen_http_stream_read(struct stream *stream, char *out, size_t bytes)
{
    struct streams *streams = stream->streams;
    bool missed = false;
    pthread_mutex_lock(&streams->lock);
    ssize_t count = stream->ended ? -1 : 0;
    if (stream->text) {
        const struct pen_buf *text = &stream->text->content;
        size_t left = text->bytes - stream->sent;
        size_t part = left < bytes ? left : bytes;
        memcpy(out, text->data + stream->sent, part);
        stream->sent += part;
        count = (ssize_t)part;
        missed = part == left && finish_text(stream);
    }
    pthread_mutex_unlock(&streams->lock);
    if (missed)
        pen_http_watch_hurry(streams->http->watch);
    return count;
}

uint64_t pen_http_stream_close(struct stream *stream)
{
    struct streams *streams = stream->streams;
    pthread_mutex_lock(&streams->lock);
    *stream->link = stream->next;
    if (stream->next)
        stream->next->link = stream->link;
    streams->count--;
    pthread_mutex_unlock(&streams->lock);
    uint64_t total = stream->total + stream->sent;
    pen_http_blob_unref(stream->text);
    free(stream);
    pen_http_watch_remove(streams->http->watch);
    return total;
}

/* Gives a waiting stream a text. Its request has been answered, or its first text would still be
 * there: so it may be woken. Called with the lock held. */
static void tell(struct stream *stream, struct blob *text, int64_t now_ns)
{
    stream->text = pen_http_blob_ref(text);
    stream->said_ns = now_ns;
    pen_http_adapter_wake(stream->request);
}

static struct frame *find_frame(struct streams *streams, const struct stream *stream)
{
    const struct event_cursor *at = &stream->cursor;
    for (int i = 0; i < streams->frame_count; i++) {
        struct frame *frame = &streams->frames[i];
        if (frame->key == stream->key && frame->from.id == at->id &&
            frame->from.greeted == at->greeted && frame->from.state == at->state &&
            strcmp(frame->job_id, stream->job_id) == 0)
            return frame;
    }
    return NULL;
}

static struct frame *add_frame(struct streams *streams, const struct stream *stream)
{
    struct frame *frame = &streams->frames[streams->frame_count++];
    *frame = (struct frame){.key = stream->key, .from = stream->cursor, .to = stream->cursor};
    memcpy(frame->job_id, stream->job_id, sizeof frame->job_id);
    return frame;
}

/* Notes what is wanted. Called with the lock held. False when out of memory. */
static bool note_frames(struct streams *streams)
{
    streams->frame_count = 0;
    if (streams->frame_capacity < streams->count) {
        size_t bytes = (size_t)streams->count * sizeof *streams->frames;
        struct frame *frames = realloc(streams->frames, bytes);
        if (!frames)
            return false;
        streams->frames = frames;
        streams->frame_capacity = streams->count;
    }
    for (struct stream *stream = streams->list; stream; stream = stream->next) {
        stream->missed = stream->text != NULL;
        stream->frame = NULL;
        if (stream->text || stream->ended)
            continue;
        stream->frame = find_frame(streams, stream);
        if (!stream->frame)
            stream->frame = add_frame(streams, stream);
    }
    return true;
}

/* Writes a frame. A store that cannot be asked just now changes nothing; a job that is gone has
 * nothing more to tell. */
static void write_frame(struct streams *streams, struct frame *frame, struct pen_jobs *jobs,
                        uint32_t news)
{
    struct snapshot snapshot;
    struct pen_status st;
    struct pen_buf text = {0};
    if (!pen_http_snapshots_read(streams->http->snapshots, news, jobs, frame->job_id, &snapshot,
                                 &st)) {
        frame->over = st.code == PEN_NOT_FOUND;
        return;
    }
    if (!pen_http_events_write(&snapshot, jobs, &frame->to, &text, &st))
        pen_log_about(PEN_LOG_WARN, &(struct pen_log_about){.job = frame->job_id}, "events: %s",
                      st.msg);
    else if (text.bytes > 0)
        frame->text = pen_http_blob_take(&text);
    if (!frame->text)
        frame->to = frame->from;
    frame->over = pen_http_events_are_over(&frame->to);
    pen_buf_release(&text);
    pen_http_snapshot_release(&snapshot);
}

/* Called with the lock held. */
static void hand_out(struct streams *streams, int64_t now_ns)
{
    for (struct stream *stream = streams->list; stream; stream = stream->next) {
        struct frame *frame = stream->frame;
        if (!frame || (!frame->text && !frame->over))
            continue;
        stream->cursor = frame->to;
        stream->ended = frame->over;
        stream->missed = frame->to.more;
        if (frame->text)
            tell(stream, frame->text, now_ns);
        else
            pen_http_adapter_wake(stream->request);
    }
}

void pen_http_streams_look(struct streams *streams, struct pen_jobs *jobs, uint32_t news)
{
    pthread_mutex_lock(&streams->lock);
    bool ok = note_frames(streams);
    pthread_mutex_unlock(&streams->lock);
    if (!ok)
        return;
    for (int i = 0; i < streams->frame_count; i++)
        write_frame(streams, &streams->frames[i], jobs, news);
    pthread_mutex_lock(&streams->lock);
    hand_out(streams, pen_clock_ns());
    pthread_mutex_unlock(&streams->lock);
    for (int i = 0; i < streams->frame_count; i++)
        pen_http_blob_unref(streams->frames[i].text);
}

void pen_http_streams_beat(struct streams *streams, int64_t now_ns)
{
    pthread_mutex_lock(&streams->lock);
    for (struct stream *stream = streams->list; stream; stream = stream->next) {
        if (!stream->text && !stream->ended && now_ns - stream->said_ns >= streams->beat_ns)
            tell(stream, streams->beat, now_ns);
    }
    pthread_mutex_unlock(&streams->lock);
}

void pen_http_streams_end(struct streams *streams)
{
    pthread_mutex_lock(&streams->lock);
    streams->ended = true;
    for (struct stream *stream = streams->list; stream; stream = stream->next) {
        stream->ended = true;
        if (!stream->text)
            pen_http_adapter_wake(stream->request);
    }
    pthread_mutex_unlock(&streams->lock);
}
