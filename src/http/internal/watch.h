/* SPDX-License-Identifier: MIT */
/* The watcher: one thread for all requests that wait until a job changes. It answers long polls,
 * and gives event streams their updates (streams.h). It waits for the store's change counter
 * (PEN_SIGNAL_CHANGES) and checks the jobs whenever the counter has grown; a check every second
 * covers notifications that got lost.
 *
 * Threads: any, except start, stop and free. */
#ifndef PEN_HTTP_INTERNAL_WATCH_H
#define PEN_HTTP_INTERNAL_WATCH_H

#include <stdint.h>

#include "base/status.h"

struct pen_http;
struct pen_jobs;
struct request;
struct watch;

enum { WATCH_MAX = 512 }; /* polls, and as many streams */

/* Starts the thread; takes the jobs handle, after failure too. Owns: stop, then free. Fails:
 * PEN_UNAVAILABLE (threads), PEN_NO_MEMORY. */
struct watch *pen_http_watch_start(struct pen_http *http, struct pen_jobs *jobs,
                                   struct pen_status *st);

/* Answers all waiting requests with their jobs as they are, ends the streams, and ends the thread.
 * Later calls of pen_http_watch_add return WATCH_CLOSED. NULL is allowed. */
void pen_http_watch_stop(struct watch *watch);

/* Frees a stopped watcher that no thread uses any more. NULL is allowed. */
void pen_http_watch_free(struct watch *watch);

/* The store's change counter. */
uint32_t pen_http_watch_changes(struct watch *watch);

enum watch_result {
    WATCH_ACCEPTED, /* the request belongs to the watcher now */
    WATCH_CHANGED,  /* the store has changed meanwhile: read the job again */
    WATCH_FULL,     /* WATCH_MAX requests are waiting already */
    WATCH_CLOSED    /* the daemon is stopping, or the client has gone */
};

/* Fails with what a client is told of WATCH_FULL or WATCH_CLOSED. */
bool pen_http_watch_fail(enum watch_result result, struct pen_status *st);

/* Gives a request with its deadline to the watcher. `changes` is the change counter from
 * before the caller read the job; thus no change between reading and waiting is missed. */
enum watch_result pen_http_watch_add(struct watch *watch, struct request *request,
                                     uint32_t changes);

/* The client of a request that the watcher has has gone (guard.h): it waits no longer. */
void pen_http_watch_gone(struct watch *watch, struct request *request);

/* Counts an event stream, and removes it again. WATCH_CHANGED is not returned. */
enum watch_result pen_http_watch_add_stream(struct watch *watch);
void pen_http_watch_remove_stream(struct watch *watch);

/* How many long polls wait, and how many event streams are open. */
void pen_http_watch_counts(struct watch *watch, int *polls, int *streams);

/* Call it when a stream was opened; `changes` is the change counter from before its first text was
 * written. If the other streams have had an update since then, this one gets it too. */
void pen_http_watch_stream_opened(struct watch *watch, uint32_t changes);

/* Makes the watcher check all jobs soon. */
void pen_http_watch_check_soon(struct watch *watch);

#endif
