/* SPDX-License-Identifier: MIT */
/* The events of a job as text. They are made from the job and its commits; there is no log of
 * events.
 *
 * Ids. Each revision of a job has PEN_JOB_TILE_PARTS + 1 ids. The last id is of the event about the
 * job; the ids before it are of the rectangles that the revision's commit has added. So ids grow,
 * and they mean the same after a restart. A client can resume after any event. If several revisions
 * come between two updates of a stream, the stream gets all their tiles and one event about the
 * job.
 *
 * Shape: a text holds whole events; an empty line ends each. */
#ifndef PEN_HTTP_INTERNAL_EVENTS_H
#define PEN_HTTP_INTERNAL_EVENTS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/buf.h"
#include "http/internal/snapshot_cache.h"
#include "jobs/jobs.h"

/* A client's place in the events of its job. */
struct event_cursor {
    int64_t id;               /* of the last event that was sent; 0: none */
    bool job_sent;            /* an event about the job was sent on this connection */
    enum pen_job_state state; /* the state in that event */
    bool more;                /* the last text was cut short: more events are due */
};

/* The place of a client that sends this Last-Event-ID. NULL, or an id that the job does not have
 * yet, means the beginning. */
struct event_cursor pen_http_events_begin(const char *last_event_id,
                                          const struct snapshot *snapshot);

/* Whether the job has ended and its client has received all events. */
bool pen_http_events_are_complete(const struct event_cursor *cursor,
                                  const struct snapshot *snapshot);

/* Appends the events after the cursor to the text, oldest first, and advances the cursor. If there
 * are none, nothing is appended. A text that would become too long ends before the event about the
 * job, and `more` is set.
 * Fails: as pen_jobs_tiles, PEN_NO_MEMORY; the cursor is then unchanged. */
bool pen_http_events_write(const struct snapshot *snapshot, struct pen_jobs *jobs,
                           struct event_cursor *cursor, struct pen_buf *text,
                           struct pen_status *st);

/* Whether the event about the job's end was sent. */
static inline bool pen_http_events_are_over(const struct event_cursor *cursor)
{
    return cursor->job_sent && pen_job_state_ended(cursor->state);
}

#endif
