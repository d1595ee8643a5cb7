/* SPDX-License-Identifier: MIT */
/* Those who wait: long polls, which are answered when their job has changed, and event streams,
 * which are told every time (streams.h). One thread sleeps on the store's NEWS and
 * looks again at the watched jobs when it grows; a look every second covers hints that got lost. */
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

/* Answers all waiting requests with their jobs as they are, and ends the thread; later calls of
 * pen_http_watch_add get WATCH_CLOSED. The watch must be freed when no thread uses it any more. */
void pen_http_watch_stop(struct watch *watch);
void pen_http_watch_free(struct watch *watch); /* NULL is allowed */

/* The store's NEWS counter. */
uint32_t pen_http_watch_notify(struct watch *watch);

enum watch_answer {
    WATCH_TAKEN, /* the request is the watcher's */
    WATCH_NEWS,  /* something has changed meanwhile: look at the job again */
    WATCH_FULL,
    WATCH_CLOSED
};

/* Hands a held request with its deadline to the watcher. `news` is the counter from before the
 * caller looked at the job, so no change falls between looking and waiting. */
enum watch_answer pen_http_watch_add(struct watch *watch, struct request *request, uint32_t news);

/* Takes a place for an event stream, as many as WATCH_MAX has left; WATCH_NEWS is not given. */
enum watch_answer pen_http_watch_enter(struct watch *watch);
void pen_http_watch_remove(struct watch *watch);

/* To be called after a stream was opened from a look at NEWS `news`: what the watcher has told
 * others meanwhile, it tells this one too. */
void pen_http_watch_joined(struct watch *watch, uint32_t news);

/* Has all streams looked at soon. */
void pen_http_watch_hurry(struct watch *watch);

#endif
