/* SPDX-License-Identifier: MIT */
/* Event streams: answers that go on until their job has ended. A stream costs its connection and a
 * few hundred bytes. The watcher's thread writes each new text once for all streams that need the
 * same one, and the thread of each connection sends it.
 *
 *   open ──► SENDING ──all is sent──► WAITING        at the job's end, or by `end`: ENDED
 *               ▲                        │
 *               └────update, heartbeat───┘
 *
 * A stream takes no new text while it is SENDING: a slow client costs one text, and continues
 * afterwards from its own place. A client that has gone is noticed only when something is sent to
 * it, and then only with the second text or heartbeat: the first still fits into the socket's
 * buffer. */
#ifndef PEN_HTTP_INTERNAL_STREAMS_H
#define PEN_HTTP_INTERNAL_STREAMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "base/status.h"
#include "http/internal/events.h"

struct pen_jobs;
struct request;
struct snapshot_cache;
struct stream;
struct streams;

/* Fails: NULL when out of memory. */
struct streams *pen_http_streams_new(struct snapshot_cache *cache, int heartbeat_ms);
void pen_http_streams_free(struct streams *streams); /* NULL is allowed; no stream may be left */

/* Opens the stream of a request with its first text, which must not be empty; takes the contents.
 * Fails: NULL when out of memory. */
struct stream *pen_http_stream_open(struct streams *streams, struct request *request,
                                    const struct event_cursor *cursor, struct pen_buf *text);

/* Takes the next bytes to send: 0 if there are none now, -1 at the end. *behind: this stream has
 * missed an update, so the caller has to have the watcher check soon. Threads: the connection's. */
ssize_t pen_http_stream_read(struct stream *stream, char *out, size_t bytes, bool *behind);

/* Ends and frees a stream; returns how many bytes were read. Threads: the connection's. */
uint64_t pen_http_stream_close(struct stream *stream);

/* Gives every waiting stream the events that it does not have yet. `changes` is the store's change
 * counter from before the call. Threads: the watcher's. */
void pen_http_streams_update(struct streams *streams, struct pen_jobs *jobs, uint32_t changes);

/* Gives a heartbeat to every waiting stream that was given nothing for a while. Threads: the
 * watcher's. */
void pen_http_streams_heartbeat(struct streams *streams, int64_t now_ns);

/* Ends all streams, also those that are opened later. */
void pen_http_streams_end(struct streams *streams);

#endif
