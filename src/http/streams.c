/* SPDX-License-Identifier: MIT */
/* One lock guards all streams. It is held while pointers change and bytes are copied, never while
 * the store is read. An update has three steps:
 *   1. note_updates, under the lock: which texts are needed, one for each job and place;
 *   2. write_update, without it: each text, from the store;
 *   3. deliver, under the lock: the texts to the streams, without those that closed meanwhile.
 *
 * A stream that waits for its next text is suspended, and the guard watches its client. Whoever
 * takes it back from the guard (wake) may resume it; else pen_http_stream_gone does.
 *
 * Order of locks: the streams' lock, then the guard's. */
#include "http/internal/streams.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "http/internal/guard.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/snapshot_cache.h"

struct stream {
    struct streams *streams;
    struct request *request;
    char job_id[PEN_ID_BYTES];
    uint64_t key; /* of job_id */
    /* guarded by the streams' lock: */
    struct stream *next, **link;
    struct update *update;      /* for this stream in the update under way; NULL: none */
    struct event_cursor cursor; /* its place once `text` is sent */
    struct blob *text;          /* what is being sent; NULL: nothing */
    size_t sent;                /* bytes of text */
    uint64_t total;             /* bytes sent before text */
    int64_t last_text_ns;       /* when it was last given a text */
    bool behind;                /* an update came while the stream was sending, or was cut short */
    bool ended;                 /* nothing follows text */
    bool waiting;               /* suspended */
};

/* The next text for all streams of one job that are at the same place. */
struct update {
    char job_id[PEN_ID_BYTES];
    uint64_t key;
    struct event_cursor from, to;
    struct blob *text; /* NULL: nothing new */
    bool over;
};

struct streams {
    struct snapshot_cache *cache;
    int64_t heartbeat_interval_ns;
    struct blob *heartbeat;
    pthread_mutex_t lock;
    struct stream *list;    /* guarded by lock */
    int count;              /* guarded by lock */
    bool ended;             /* guarded by lock */
    struct update *updates; /* used by the watcher's thread alone */
    int update_count, update_capacity;
};

struct streams *pen_http_streams_new(struct snapshot_cache *cache, int heartbeat_ms)
{
    struct streams *streams = calloc(1, sizeof *streams);
    struct pen_buf text = {0};
    pen_buf_puts(&text, ": still here\n\n");
    struct blob *heartbeat = pen_http_blob_take(&text);
    if (!streams || !heartbeat) {
        pen_http_blob_unref(heartbeat);
        free(streams);
        return NULL;
    }
    *streams = (struct streams){.cache = cache,
                                .heartbeat_interval_ns = heartbeat_ms * INT64_C(1000000),
                                .heartbeat = heartbeat};
    pthread_mutex_init(&streams->lock, NULL);
    return streams;
}

void pen_http_streams_free(struct streams *streams)
{
    if (!streams)
        return;
    pthread_mutex_destroy(&streams->lock);
    pen_http_blob_unref(streams->heartbeat);
    free(streams->updates);
    free(streams);
}

/* The random end of a UUIDv7. It is compared first, because it differs between nearly all jobs. */
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
                              .behind = cursor->more,
                              .last_text_ns = pen_clock_ns(),
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

/* Drops a text that was sent. Returns whether the stream needs another update at once. */
static bool finish_text(struct stream *stream)
{
    stream->total += stream->sent;
    stream->sent = 0;
    pen_http_blob_unref(stream->text);
    stream->text = NULL;
    bool behind = stream->behind && !stream->ended;
    stream->behind = false;
    return behind;
}

ssize_t pen_http_stream_read(struct stream *stream, char *out, size_t bytes, bool *behind)
{
    struct streams *streams = stream->streams;
    struct request *request = stream->request;
    *behind = false;
    pthread_mutex_lock(&streams->lock);
    ssize_t count = stream->ended ? -1 : 0;
    if (stream->text) {
        const struct pen_buf *text = &stream->text->content;
        size_t left = text->bytes - stream->sent;
        size_t part = left < bytes ? left : bytes;
        memcpy(out, text->data + stream->sent, part);
        stream->sent += part;
        count = (ssize_t)part;
        *behind = part == left && finish_text(stream);
    } else if (!stream->ended) {
        stream->waiting = true;
        pen_http_suspend(request);
        pen_guard_watch(request->http->guard, request->fd, request);
    }
    pthread_mutex_unlock(&streams->lock);
    return count;
}

void pen_http_stream_gone(struct stream *stream)
{
    struct streams *streams = stream->streams;
    struct request *request = stream->request;
    pthread_mutex_lock(&streams->lock);
    stream->ended = true;
    stream->waiting = false;
    pthread_mutex_unlock(&streams->lock);
    pen_http_resume(request);
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
    return total;
}

/* Takes a waiting stream back from the guard. Returns false if its client has gone, or if it does
 * not wait: it will read by itself. Called with the lock held. */
static bool wake(struct stream *stream)
{
    const struct request *request = stream->request;
    if (!stream->waiting || !pen_guard_unwatch(request->http->guard, request->fd))
        return false;
    stream->waiting = false;
    return true;
}

/* Gives a stream without a text one. Called with the lock held. */
static void send_text(struct stream *stream, struct blob *text, int64_t now_ns)
{
    const bool resume = wake(stream);
    stream->text = pen_http_blob_ref(text);
    stream->last_text_ns = now_ns;
    if (resume)
        pen_http_resume(stream->request);
}

/* Nothing follows what is being sent. Called with the lock held. */
static void end(struct stream *stream)
{
    stream->ended = true;
    if (!stream->text && wake(stream))
        pen_http_resume(stream->request);
}

static struct update *find_update(struct streams *streams, const struct stream *stream)
{
    const struct event_cursor *at = &stream->cursor;
    for (int i = 0; i < streams->update_count; i++) {
        struct update *update = &streams->updates[i];
        if (update->key == stream->key && update->from.id == at->id &&
            update->from.job_sent == at->job_sent && update->from.state == at->state &&
            strcmp(update->job_id, stream->job_id) == 0)
            return update;
    }
    return NULL;
}

static struct update *add_update(struct streams *streams, const struct stream *stream)
{
    struct update *update = &streams->updates[streams->update_count++];
    *update = (struct update){.key = stream->key, .from = stream->cursor, .to = stream->cursor};
    memcpy(update->job_id, stream->job_id, sizeof update->job_id);
    return update;
}

/* Lists the texts that waiting streams need, in streams->updates. Called with the lock held.
 * Returns false when out of memory. */
static bool note_updates(struct streams *streams)
{
    streams->update_count = 0;
    if (streams->update_capacity < streams->count) {
        size_t bytes = (size_t)streams->count * sizeof *streams->updates;
        struct update *updates = realloc(streams->updates, bytes);
        if (!updates)
            return false;
        streams->updates = updates;
        streams->update_capacity = streams->count;
    }
    for (struct stream *stream = streams->list; stream; stream = stream->next) {
        stream->behind = stream->text != NULL;
        stream->update = NULL;
        if (stream->text || stream->ended)
            continue;
        stream->update = find_update(streams, stream);
        if (!stream->update)
            stream->update = add_update(streams, stream);
    }
    return true;
}

/* Writes an update's text. If the store cannot be read now, the update stays empty and the next one
 * writes these events too. The streams of a job that was deleted end. */
static void write_update(struct streams *streams, struct update *update, struct pen_jobs *jobs,
                         uint32_t changes)
{
    struct snapshot snapshot;
    struct pen_status st;
    struct pen_buf text = {0};
    if (!pen_http_snapshot_cache_read(streams->cache, changes, jobs, update->job_id, &snapshot,
                                      &st)) {
        update->over = st.code == PEN_NOT_FOUND || st.code == PEN_GONE;
        return;
    }
    if (!pen_http_events_write(&snapshot, jobs, &update->to, &text, &st))
        pen_log_about(PEN_LOG_WARN, &(struct pen_log_about){.job = update->job_id}, "events: %s",
                      st.msg);
    else if (text.bytes > 0)
        update->text = pen_http_blob_take(&text);
    if (!update->text)
        update->to = update->from;
    update->over = pen_http_events_are_over(&update->to);
    pen_buf_release(&text);
    pen_http_snapshot_release(&snapshot);
}

/* Gives each stream the text of its update. Called with the lock held. */
static void deliver(struct streams *streams, int64_t now_ns)
{
    for (struct stream *stream = streams->list; stream; stream = stream->next) {
        struct update *update = stream->update;
        if (!update || (!update->text && !update->over))
            continue;
        stream->cursor = update->to;
        stream->ended = stream->ended || update->over;
        stream->behind = update->to.more;
        if (update->text)
            send_text(stream, update->text, now_ns);
        else
            end(stream);
    }
}

void pen_http_streams_update(struct streams *streams, struct pen_jobs *jobs, uint32_t changes)
{
    pthread_mutex_lock(&streams->lock);
    bool ok = note_updates(streams);
    pthread_mutex_unlock(&streams->lock);
    if (!ok)
        return;
    for (int i = 0; i < streams->update_count; i++)
        write_update(streams, &streams->updates[i], jobs, changes);
    pthread_mutex_lock(&streams->lock);
    deliver(streams, pen_clock_ns());
    pthread_mutex_unlock(&streams->lock);
    for (int i = 0; i < streams->update_count; i++)
        pen_http_blob_unref(streams->updates[i].text);
}

void pen_http_streams_heartbeat(struct streams *streams, int64_t now_ns)
{
    pthread_mutex_lock(&streams->lock);
    for (struct stream *stream = streams->list; stream; stream = stream->next) {
        if (!stream->text && !stream->ended &&
            now_ns - stream->last_text_ns >= streams->heartbeat_interval_ns)
            send_text(stream, streams->heartbeat, now_ns);
    }
    pthread_mutex_unlock(&streams->lock);
}

void pen_http_streams_end(struct streams *streams)
{
    pthread_mutex_lock(&streams->lock);
    streams->ended = true;
    for (struct stream *stream = streams->list; stream; stream = stream->next)
        end(stream);
    pthread_mutex_unlock(&streams->lock);
}

void pen_http_streams_check_tokens(struct streams *streams, struct pen_tokens *tokens)
{
    pthread_mutex_lock(&streams->lock);
    for (struct stream *stream = streams->list; stream; stream = stream->next) {
        if (!stream->ended && !pen_tokens_holds(tokens, &stream->request->holder))
            end(stream);
    }
    pthread_mutex_unlock(&streams->lock);
}
