/* SPDX-License-Identifier: MIT */
/* The threads that may block: store threads and side threads, each with a jobs handle of its own.
 * Requests wait in one queue per lane, first come first served; the number of connections bounds
 * the queues. */
#ifndef PEN_HTTP_INTERNAL_POOL_H
#define PEN_HTTP_INTERNAL_POOL_H

#include <stdbool.h>

#include "base/status.h"
#include "http/internal/routes.h"
#include "io/scene_json.h"

struct pool;

struct pool_options {
    const char *store_url;
    const struct pen_limits *limits;
    int store_threads, side_threads;
};

/* Fails: as pen_jobs_open; PEN_UNAVAILABLE (threads). */
struct pool *pen_http_pool_start(const struct pool_options *options, struct pen_status *st);

/* Works off what is queued, then ends the threads. Requests may still be offered. */
void pen_http_pool_stop(struct pool *pool);

/* Frees a stopped pool, when no thread offers requests any more. NULL is allowed. */
void pen_http_pool_free(struct pool *pool);

/* Queues a held request. False after pen_http_pool_stop has begun: the request stays the caller's.
 */
bool pen_http_pool_push(struct pool *pool, enum lane lane, struct request *request);

#endif
