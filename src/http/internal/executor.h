/* SPDX-License-Identifier: MIT */
/* The threads that may block. Each has a jobs handle of its own. All threads of a kind serve one
 * queue of requests, first in, first out. The length of a queue is limited; beyond it requests are
 * refused. */
#ifndef PEN_HTTP_INTERNAL_EXECUTOR_H
#define PEN_HTTP_INTERNAL_EXECUTOR_H

#include <stdbool.h>

#include "base/status.h"
#include "http/internal/routes.h"
#include "io/scene_json.h"

struct executor;

/* Starts the threads.
 * Owns: stop, then free.
 * Fails: as pen_jobs_open; PEN_UNAVAILABLE (threads), PEN_NO_MEMORY. */
struct executor *pen_http_executor_start(const char *store_url, const struct pen_limits *limits,
                                         struct pen_status *st);

/* Handles the queued requests, then ends the threads. pen_http_executor_submit may still be called.
 * NULL is allowed. */
void pen_http_executor_stop(struct executor *executor);

/* Frees a stopped executor, once no thread calls pen_http_executor_submit any more. NULL is
 * allowed. */
void pen_http_executor_free(struct executor *executor);

/* Queues a suspended request in PHASE_WORK. A thread runs the handler of its route, compresses the
 * answer if the client accepts that, and resumes the request. If the queue is full or the executor
 * is stopped, the request is answered 503 and resumed.
 * Threads: any. */
void pen_http_executor_submit(struct executor *executor, enum queue_id id, struct request *request);

#endif
