/* SPDX-License-Identifier: MIT */
/* Long polls: requests that wait for a job to change. One thread sleeps on the store's NEWS and
 * looks again at the watched jobs when it grows; a look every second covers hints that got lost. */
#ifndef HTTP_WATCH_H
#define HTTP_WATCH_H

#include <stdint.h>

#include "pen/base/status.h"

struct pen_http;
struct pen_jobs;
struct request;
struct watch;

enum { WATCH_MAX = 512 }; /* farm.md: half of the connections stay free for other calls */

/* Takes the jobs handle, also on failure. Fails: PEN_UNAVAILABLE (threads). */
struct watch *pen_http_watch_start(struct pen_http *http, struct pen_jobs *jobs,
                                   struct pen_status *st);

/* Answers all waiting requests with their jobs as they are, and ends the thread; later calls of
 * pen_http_watch_add get WATCH_CLOSED. The watch must be freed when no thread uses it any more. */
void pen_http_watch_stop(struct watch *watch);
void pen_http_watch_free(struct watch *watch); /* NULL is allowed */

/* The store's NEWS counter. */
uint32_t pen_http_watch_news(struct watch *watch);

enum watch_answer {
    WATCH_TAKEN, /* the request is the watcher's */
    WATCH_NEWS,  /* something has changed meanwhile: look at the job again */
    WATCH_FULL,
    WATCH_CLOSED
};

/* Hands a held request with its deadline to the watcher. `news` is the counter from before the
 * caller looked at the job, so no change falls between looking and waiting. */
enum watch_answer pen_http_watch_add(struct watch *watch, struct request *request, uint32_t news);

#endif
