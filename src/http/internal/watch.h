/* SPDX-License-Identifier: MIT */
/* The watcher: one thread that serves all requests that wait for a job to change, long polls, which
 * it answers then, and event streams, which it updates every time (streams.h). It sleeps on the
 * store's change counter (PEN_SIGNAL_CHANGES) and checks the watched jobs whenever the counter has
 * grown; a check every second covers notifications that got lost. */
#ifndef PEN_HTTP_INTERNAL_WATCH_H
#define PEN_HTTP_INTERNAL_WATCH_H

#include <stdint.h>

#include "base/status.h"

struct pen_http;
struct pen_jobs;
struct request;
struct watch;

enum { WATCH_MAX = 512 }; /* polls and streams: half of the connections stay free for others */

/* Takes the jobs handle, also on failure. Fails: PEN_UNAVAILABLE (threads). */
struct watch *pen_http_watch_start(struct pen_http *http, struct pen_jobs *jobs,
                                   struct pen_status *st);

/* Answers all waiting requests with their jobs as they are, ends the streams and the thread; later
 * calls of pen_http_watch_add get WATCH_CLOSED. */
void pen_http_watch_stop(struct watch *watch);

/* Frees a stopped watcher that no thread uses any more. NULL is allowed. */
void pen_http_watch_free(struct watch *watch);

/* The store's change counter. */
uint32_t pen_http_watch_changes(struct watch *watch);

enum watch_result {
    WATCH_ACCEPTED, /* the request is the watcher's */
    WATCH_CHANGED,  /* the store has changed meanwhile: read the job again */
    WATCH_FULL,     /* WATCH_MAX requests wait already */
    WATCH_CLOSED    /* the daemon is stopping */
};

/* Hands a suspended request with its deadline to the watcher. `changes` is the counter from before
 * the caller read the job, so no change falls between reading and waiting. */
enum watch_result pen_http_watch_add(struct watch *watch, struct request *request,
                                     uint32_t changes);

/* Counts an event stream among the waiting requests, and removes it again. WATCH_CHANGED is not
 * returned. */
enum watch_result pen_http_watch_add_stream(struct watch *watch);
void pen_http_watch_remove_stream(struct watch *watch);

/* Call it once a stream is open whose first text was written at counter `changes`: if the other
 * streams have had an update meanwhile, this one gets it too. */
void pen_http_watch_stream_opened(struct watch *watch, uint32_t changes);

/* Makes the watcher check all jobs soon. */
void pen_http_watch_check_soon(struct watch *watch);

#endif
