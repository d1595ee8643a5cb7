/* SPDX-License-Identifier: MIT */
/* Event streams: long polls that are answered many times, until their job has ended. A stream costs
 * its connection and a few hundred bytes.
 *
 *   open ──► SENDING ──all is sent──► WAITING in the watcher ──► the end of the job, or of the
 *               ▲                        │                       daemon, token or client: END
 *               └────events, heartbeat───┘
 *
 * A stream belongs to its connection's thread while it is SENDING, and to the watcher while it is
 * WAITING, as its request does. A slow client costs the memory of one text, and continues
 * afterwards from its own place. */
#ifndef PEN_HTTP_INTERNAL_STREAMS_H
#define PEN_HTTP_INTERNAL_STREAMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "http/internal/events.h"

struct pen_jobs;
struct request;
struct stream;

/* The texts that were written last. All streams of a job at the same place send the same text. */
enum { STREAM_TEXTS = 16 };
struct stream_texts {
    struct stream_text {
        char job_id[PEN_ID_BYTES];
        struct event_cursor from, to;
        struct blob *text; /* NULL: no new events */
        bool over;         /* the last text of the stream */
    } text[STREAM_TEXTS];
    int count;
};
void pen_http_stream_texts_release(struct stream_texts *texts);

/* Gives a waiting stream its next events, or a heartbeat if there are none and it is due. `changes`
 * is the store's change counter from before the call. Returns whether the stream has something to
 * send, or ends.
 * Threads: the watcher's. */
bool pen_http_stream_advance(struct request *request, struct pen_jobs *jobs, uint32_t changes,
                             struct stream_texts *texts);

/* Ends a stream after the text that it is sending.
 * Threads: the one that has the request. */
void pen_http_stream_end(struct stream *stream);

/* Copies the next bytes to send into `out`. Returns their number; -1 at the end. If there are none
 * now, it gives the request to the watcher and returns 0.
 * Threads: the connection's. */
ssize_t pen_http_stream_read(struct request *request, char *out, size_t bytes);

/* Frees a stream. Returns the number of bytes that were read from it.
 * Threads: the connection's. */
uint64_t pen_http_stream_close(struct request *request);

#endif
