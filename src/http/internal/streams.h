/* SPDX-License-Identifier: MIT */
/* Event streams: answers that go on until their job has ended. A stream costs its connection and a
 * few hundred bytes. The watcher's thread writes each new text once for all streams that need the
 * same one; the thread of each connection sends it.
 *
 *   open ──► SENDING ──all is sent──► WAITING        at the job's end, or by pen_http_streams_end:
 *               ▲                        │           ENDED
 *               └────update, heartbeat───┘
 *
 * A stream gets no new text while it is SENDING: a slow client costs the memory of one text, and
 * continues afterwards from its own place. */
#ifndef PEN_HTTP_INTERNAL_STREAMS_H
#define PEN_HTTP_INTERNAL_STREAMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "base/status.h"
#include "http/internal/events.h"

struct pen_jobs;
struct pen_tokens;
struct request;
struct snapshot_cache;
struct stream;
struct streams;

/* Fails: NULL when out of memory. */
struct streams *pen_http_streams_new(struct snapshot_cache *cache, int heartbeat_ms);
void pen_http_streams_free(struct streams *streams); /* NULL is allowed; no stream may be left */

/* Opens the stream of a request with its first text, which must not be empty; takes the contents of
 * *text. Owns: close it with pen_http_stream_close. Fails: NULL when out of memory. */
struct stream *pen_http_stream_open(struct streams *streams, struct request *request,
                                    const struct event_cursor *cursor, struct pen_buf *text);

/* Copies the next bytes to send into `out`. Returns their number; -1 at the end. If there are none
 * now, returns 0 and has suspended the connection, which is resumed with the next text. If *behind
 * becomes true, this stream has missed an update: call pen_http_watch_check_soon. Threads: the
 * connection's. */
ssize_t pen_http_stream_read(struct stream *stream, char *out, size_t bytes, bool *behind);

/* The client of a waiting stream has gone (guard.h): the stream ends. */
void pen_http_stream_gone(struct stream *stream);

/* Frees a stream. Returns the number of bytes that were read from it. Threads: the connection's. */
uint64_t pen_http_stream_close(struct stream *stream);

/* Gives every waiting stream the events that it has not been sent yet. `changes` is the store's
 * change counter from before the call. Threads: the watcher's. */
void pen_http_streams_update(struct streams *streams, struct pen_jobs *jobs, uint32_t changes);

/* Gives a heartbeat to every waiting stream that has been silent for the heartbeat interval.
 * Threads: the watcher's. */
void pen_http_streams_heartbeat(struct streams *streams, int64_t now_ns);

/* Ends the streams of tokens that are no longer valid. */
void pen_http_streams_check_tokens(struct streams *streams, struct pen_tokens *tokens);

/* Ends all streams, and makes streams that are opened later end after their first text. */
void pen_http_streams_end(struct streams *streams);

#endif
