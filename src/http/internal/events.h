/* SPDX-License-Identifier: MIT */
/* The events of a job as text, made from the job and its commits; no log of events is kept.
 *
 * Ids. Each revision of a job has PEN_JOB_TILE_PARTS + 1 ids. The last one is for the event about
 * the job itself; those before it are for the rectangles that the commit of this revision has
 * added. So ids grow, they mean the same after a restart, and a client can resume after any event.
 * If several revisions come between two updates of a stream, the stream gets the tiles of all of
 * them and one event about the job.
 *
 * Shape: a text holds whole events, each ended by an empty line. */
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

/* The place of a client that sends this Last-Event-ID. With NULL, or an id that this job has not
 * given yet, it is the beginning. */
struct event_cursor pen_http_events_begin(const char *last_event_id,
                                          const struct snapshot *snapshot);

/* Whether the job has ended and its client has received all events. */
bool pen_http_events_are_complete(const struct event_cursor *cursor,
                                  const struct snapshot *snapshot);

/* Appends the events after the cursor to the text, oldest first, and advances the cursor. If there
 * are none, nothing is appended. A text that would become too long ends before the event about the
 * job, and `more` is set. Fails: as pen_jobs_tiles, PEN_NO_MEMORY; the cursor is then unchanged. */
bool pen_http_events_write(const struct snapshot *snapshot, struct pen_jobs *jobs,
                           struct event_cursor *cursor, struct pen_buf *text,
                           struct pen_status *st);

/* Whether the event about the job's end was sent. */
static inline bool pen_http_events_are_over(const struct event_cursor *cursor)
{
    return cursor->job_sent && pen_job_state_ended(cursor->state);
}

#endif
