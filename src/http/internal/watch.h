/* SPDX-License-Identifier: MIT */
/* The watcher: one thread for all requests that wait until a job changes. These are long polls and
 * event streams (streams.h). It waits for the store's change counter (PEN_SIGNAL_CHANGES), and
 * checks the jobs when the counter has grown. It also checks them every second, in case a
 * notification was lost.
 *
 * Threads: any, except start, stop and free. */
#ifndef PEN_HTTP_INTERNAL_WATCH_H
#define PEN_HTTP_INTERNAL_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

struct pen_http;
struct pen_jobs;
struct request;
struct watch;

enum { WATCH_MAX = 512 }; /* polls, and as many streams */

/* Starts the thread.
 * Owns: takes the jobs handle, after failure too. Stop, then free.
 * Fails: PEN_UNAVAILABLE (threads), PEN_NO_MEMORY. */
struct watch *pen_http_watch_start(struct pen_http *http, struct pen_jobs *jobs,
                                   struct pen_status *st);

/* Answers all waiting requests with the present state of their jobs, ends the streams, and ends the
 * thread. Later calls of pen_http_watch_add return WATCH_CLOSED. NULL is allowed. */
void pen_http_watch_stop(struct watch *watch);

/* Frees a stopped watcher that no thread uses any more. NULL is allowed. */
void pen_http_watch_free(struct watch *watch);

enum watch_result {
    WATCH_ACCEPTED, /* the watcher has the request, and its connection is suspended */
    WATCH_FULL,     /* WATCH_MAX polls are waiting already */
    WATCH_CLOSED    /* the daemon is stopping, or the client has gone */
};

/* Gives a request to the watcher until its job has changed, or until request->deadline_ns (0: now).
 * `changes` is the change counter from before the caller read the job. So no change between reading
 * and waiting is missed. Suspends the connection of a stream. The connection of a poll is suspended
 * already. */
enum watch_result pen_http_watch_add(struct watch *watch, struct request *request,
                                     uint32_t changes);

/* Ends the wait of a request whose client has gone (guard.h). */
void pen_http_watch_gone(struct watch *watch, struct request *request);

#endif
