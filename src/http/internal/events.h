/* SPDX-License-Identifier: MIT */
/* The events of a job as text, made from the job and what was committed; no log of events is kept.
 *
 * Ids. A job's revision r stands for PEN_JOB_TILE_PARTS + 1 ids that end with the event about the
 * job itself; those before it are for the rectangles that the commit behind r has added. So ids
 * grow, mean the same after a restart, and a client can go on after any event. Revisions passed
 * over (two commits between two looks) are told by their tiles and the next event of the job. */
#ifndef PEN_HTTP_INTERNAL_EVENTS_H
#define PEN_HTTP_INTERNAL_EVENTS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/buf.h"
#include "http/internal/snapshots.h"
#include "jobs/jobs.h"

/* How far a client has been told. */
struct event_cursor {
    int64_t id;               /* of the last event; 0: none */
    bool greeted;             /* the job was told on this connection */
    enum pen_job_state state; /* as told then */
    bool more;                /* the last text was not everything */
};

/* Where a client begins that sends this Last-Event-ID; NULL or an id that this job cannot have
 * given: at the beginning. */
struct event_cursor pen_http_events_begin(const char *last_event_id,
                                          const struct snapshot *snapshot);

/* Whether such a client knows all there will ever be. */
bool pen_http_events_are_known(const struct event_cursor *cursor, const struct snapshot *snapshot);

/* Appends what the client does not know, oldest first, and moves the cursor; nothing if it knows
 * everything. What would become too long ends before the event of the job, and sets `more`. Fails:
 * as pen_jobs_tiles, PEN_NO_MEMORY; the cursor is then as before. */
bool pen_http_events_write(const struct snapshot *snapshot, struct pen_jobs *jobs,
                           struct event_cursor *cursor, struct pen_buf *text,
                           struct pen_status *st);

/* Whether the client has been told that the job has ended. */
static inline bool pen_http_events_are_over(const struct event_cursor *cursor)
{
    return cursor->greeted && pen_job_state_ended(cursor->state);
}

#endif
