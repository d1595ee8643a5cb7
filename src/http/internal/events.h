/* SPDX-License-Identifier: MIT */
/* The events of a job as text, made from the job and its commits; no log of events is kept.
 *
 * Ids. A job's revision r owns PEN_JOB_TILE_PARTS + 1 ids. The last of them is the event about the
 * job itself; those before it are for the rectangles that the commit behind r has added. So ids
 * grow, mean the same after a restart, and a client can resume after any event. When several
 * revisions lie between two updates of a stream, it gets the tiles of all of them and one event of
 * the job. */
#ifndef PEN_HTTP_INTERNAL_EVENTS_H
#define PEN_HTTP_INTERNAL_EVENTS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/buf.h"
#include "http/internal/snapshot_cache.h"
#include "jobs/jobs.h"

/* A client's place in the events of its job. */
struct event_cursor {
    int64_t id;               /* of the last event it was sent; 0: none */
    bool job_sent;            /* the job itself was sent on this connection */
    enum pen_job_state state; /* as sent then */
    bool more;                /* the last text was cut short */
};

/* The place of a client that sends this Last-Event-ID. NULL, or an id that this job has not given
 * yet: at the beginning. */
struct event_cursor pen_http_events_begin(const char *last_event_id,
                                          const struct snapshot *snapshot);

/* Whether such a client was sent all events there will ever be. */
bool pen_http_events_are_complete(const struct event_cursor *cursor,
                                  const struct snapshot *snapshot);

/* Appends the events after the cursor, oldest first, and advances the cursor; nothing if there are
 * none. A text that would become too long ends before the event of the job, and sets `more`.
 * Fails: as pen_jobs_tiles, PEN_NO_MEMORY; the cursor is then unchanged. */
bool pen_http_events_write(const struct snapshot *snapshot, struct pen_jobs *jobs,
                           struct event_cursor *cursor, struct pen_buf *text,
                           struct pen_status *st);

/* Whether the client was sent the end of the job. */
static inline bool pen_http_events_are_over(const struct event_cursor *cursor)
{
    return cursor->job_sent && pen_job_state_ended(cursor->state);
}

#endif
