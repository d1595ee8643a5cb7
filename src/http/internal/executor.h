/* SPDX-License-Identifier: MIT */
/* The threads that may block: store, submit, list, compute and intake threads, one for changes and
 * one for large work, each with a jobs handle of its own. All threads of a kind serve one queue of
 * requests: that of the store threads, whose requests are all short, first in, first out, the
 * others by turns of the clients (waiting.h). In each queue only so many new requests wait; more
 * are refused.
 *
 * A request whose client has gone is not worked on if nothing would come of it but its answer. */
#ifndef PEN_HTTP_INTERNAL_EXECUTOR_H
#define PEN_HTTP_INTERNAL_EXECUTOR_H

#include <stdbool.h>

#include "base/status.h"
#include "http/internal/routes.h"
#include "io/scene_json.h"

struct executor;

struct executor_options {
    const char *store_url;
    const struct pen_limits *limits;
    int store_threads, submit_threads, list_threads, compute_threads, intake_threads;
};

/* Starts the threads. Owns: stop, then free. Fails: as pen_jobs_open; PEN_UNAVAILABLE (threads),
 * PEN_NO_MEMORY. */
struct executor *pen_http_executor_start(const struct executor_options *options,
                                         struct pen_status *st);

/* Handles the queued requests, then ends the threads. pen_http_executor_submit may be called later
 * too. */
void pen_http_executor_stop(struct executor *executor);

/* Frees a stopped executor, once no thread calls pen_http_executor_submit any more. NULL is
 * allowed. */
void pen_http_executor_free(struct executor *executor);

/* Queues a request in PHASE_WORK; a thread runs the handler of its route, unless it was handled
 * already, compresses the answer where that is wanted, and resumes it. Returns false once
 * pen_http_executor_stop was called, and for a new request if too many wait; the request then stays
 * the caller's. Threads: any. */
bool pen_http_executor_submit(struct executor *executor, enum queue_id id, bool is_new,
                              struct request *request);

/* Answers a request that was not taken. */
void pen_http_executor_refuse(struct executor *executor, struct request *request);

/* The queue whose threads have to compress an answered request's body: a large body keeps neither
 * a loop nor a store thread. QUEUE_NONE: a thread of `here` may do it. */
enum queue_id pen_http_executor_encodes(const struct request *request, enum queue_id here);

#endif
