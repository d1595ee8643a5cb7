/* SPDX-License-Identifier: MIT */
/* Event streams: answers that go on until their job has ended. A stream costs its connection and a
 * few hundred bytes: the watcher's thread writes what is new once for all that wait for the same,
 * and the thread of the connection sends it.
 *
 *   open ──► SENDING ──all is sent──► WAITING        with the job's end, or `end`: ENDED
 *               ▲                        │
 *               └───────look, beat───────┘
 *
 * A stream takes no new text while it is SENDING, so a slow client costs one text, and goes on
 * from where it stands afterwards. A client that is gone is noticed when something is sent to it,
 * and then only by the second text or heartbeat: the first still finds room in the socket. */
#ifndef PEN_HTTP_INTERNAL_STREAMS_H
#define PEN_HTTP_INTERNAL_STREAMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "base/status.h"
#include "http/internal/events.h"

struct pen_http;
struct pen_jobs;
struct request;
struct stream;
struct streams;

/* Fails: NULL when out of memory. */
struct streams *pen_http_streams_new(struct pen_http *http, int beat_ms);
void pen_http_streams_free(struct streams *streams); /* NULL is allowed; no stream may be left */

/* Opens the stream of a request with its first text, which must not be empty; takes the contents.
 * The place that it has at the watcher is given back by pen_http_stream_close. Fails: NULL when
 * out of memory; the place stays the caller's. */
struct stream *pen_http_stream_open(struct streams *streams, struct request *request,
                                    const struct event_cursor *cursor, struct pen_buf *text);

/* Takes the next bytes to send: 0 if there are none now, -1 at the end. Threads: the connection's.
 */
ssize_t pen_http_stream_read(struct stream *stream, char *out, size_t bytes);

/* Ends and frees a stream; returns how many bytes were read. Threads: the connection's. */
uint64_t pen_http_stream_close(struct stream *stream);

/* Tells all streams that wait what is new with their jobs. Threads: the watcher's. */
void pen_http_streams_look(struct streams *streams, struct pen_jobs *jobs, uint32_t news);

/* Sends a heartbeat where nothing was sent for a while. Threads: the watcher's. */
void pen_http_streams_beat(struct streams *streams, int64_t now_ns);

/* Ends all streams, also those still to come. */
void pen_http_streams_end(struct streams *streams);

#endif
