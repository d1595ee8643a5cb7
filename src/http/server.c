/* SPDX-License-Identifier: MIT */
/* Start and stop. The server stops in this order:
 *   1. No new connections are accepted, and new requests are refused.
 *   2. Long polls are answered, and event streams end.
 *   3. Requests in progress are finished and sent, for finish_max_ns at most.
 *   4. The executor's threads end, so that no connection is suspended.
 *   5. All connections are closed. */
#include "http/server.h"

#include <sodium.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "access/tls.h"
#include "access/tokens.h"
#include "base/clock.h"
#include "base/utf8.h"
#include "http/internal/addresses.h"
#include "http/internal/executor.h"
#include "http/internal/http.h"
#include "http/internal/listener.h"
#include "http/internal/pictures.h"
#include "http/internal/snapshot_cache.h"
#include "http/internal/static_files.h"
#include "http/internal/watch.h"
#include "jobs/jobs.h"

enum { HEARTBEAT_MS = 10000, ANSWERS_BYTES = 256 << 20 };
static const int64_t finish_max_ns = INT64_C(1500000000);

/* Frees the server and its existing parts. No connection may be open. */
static void release(struct pen_http *http)
{
    pen_http_executor_free(http->executor);
    pen_http_watch_free(http->watch);
    pen_http_snapshot_cache_free(http->snapshot_cache);
    pen_http_pictures_free(http->pictures);
    pen_http_static_files_free(http->static_files);
    pen_tokens_close(http->tokens);
    pen_tls_close(http->tls);
    pthread_mutex_destroy(&http->ready_lock);
    free(http->cors);
    free(http);
}

static bool prepare(struct pen_http *http, const struct pen_http_options *options,
                    struct pen_status *st)
{
    const int heartbeat_ms = options->heartbeat_ms > 0 ? options->heartbeat_ms : HEARTBEAT_MS;
    http->snapshot_cache = pen_http_snapshot_cache_new();
    http->heartbeat_ns = heartbeat_ms * INT64_C(1000000);
    http->pictures = pen_http_pictures_new(ANSWERS_BYTES);
    http->cors = options->cors ? strdup(options->cors) : NULL;
    if (!http->snapshot_cache || !http->pictures || (options->cors && !http->cors))
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the HTTP server");
    http->has_proxy =
        options->trusted_proxy && pen_http_address_parse(options->trusted_proxy, http->proxy);
    if (options->tokens && !(http->tokens = pen_tokens_open(options->tokens, st)))
        return false;
    if (options->tls_cert && !(http->tls = pen_tls_open(options->tls_cert, options->tls_key, st)))
        return false;
    http->static_files = pen_http_static_files_new(st);
    return http->static_files != NULL;
}

struct pen_http *pen_http_start(const struct pen_http_options *options, struct pen_status *st)
{
    struct pen_http *http = sodium_init() >= 0 ? calloc(1, sizeof *http) : NULL;
    if (!http) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the HTTP server");
        return NULL;
    }
    http->limits = options->limits;
    http->broken = options->broken;
    http->broken_user = options->broken_user;
    http->id_prefix = randombytes_random();
    pen_fail(&http->store_fault, PEN_UNAVAILABLE, "the store is being opened");
    pthread_mutex_init(&http->ready_lock, NULL);
    if (prepare(http, options, st) &&
        (http->listener = pen_http_listener_start(http, options, st)) &&
        pen_http_listener_accept(http->listener, st))
        return http;
    pen_http_listener_stop(http->listener);
    release(http);
    return NULL;
}

/* Opens the store and starts the parts that need it. The watcher is the last of them: when it is
 * stopped, all streams end. */
static bool open_store(struct pen_http *http, const struct pen_http_options *options,
                       struct pen_status *st)
{
    struct pen_jobs *jobs = pen_jobs_open(options->store_url, &http->limits, st);
    if (!jobs)
        return false;
    http->executor = pen_http_executor_start(options->store_url, &http->limits, st);
    if (!http->executor) {
        pen_jobs_close(jobs);
        return false;
    }
    http->watch = pen_http_watch_start(http, jobs, st);
    if (http->watch)
        return true;
    pen_http_executor_stop(http->executor);
    pen_http_executor_free(http->executor);
    http->executor = NULL;
    return false;
}

bool pen_http_open(struct pen_http *http, const struct pen_http_options *options,
                   struct pen_status *st)
{
    if (open_store(http, options, st)) {
        atomic_store_explicit(&http->opened, true, memory_order_release);
        return true;
    }
    pthread_mutex_lock(&http->ready_lock);
    pen_fail(&http->store_fault, PEN_UNAVAILABLE, "the store cannot be opened: %s", st->msg);
    pthread_mutex_unlock(&http->ready_lock);
    return false;
}

void pen_http_check_store(struct pen_http *http, struct pen_jobs *jobs)
{
    struct pen_status why;
    if (http->broken && pen_store_is_broken(pen_jobs_store(jobs), &why))
        http->broken(http->broken_user, &why);
}

void pen_http_drain(struct pen_http *http)
{
    atomic_store_explicit(&http->draining, true, memory_order_relaxed);
}

void pen_http_set_not_ready(struct pen_http *http, const char *reason)
{
    pthread_mutex_lock(&http->ready_lock);
    pen_utf8_copy(http->not_ready_reason, sizeof http->not_ready_reason, reason);
    pthread_mutex_unlock(&http->ready_lock);
}

/* Waits until no request is in progress, for finish_max_ns at most, since a client may stop
 * reading. */
static void wait_for_requests(struct pen_http *http)
{
    const struct timespec pause = {.tv_nsec = 5000000};
    int64_t until = pen_clock_ns() + finish_max_ns;
    while (atomic_load_explicit(&http->active, memory_order_relaxed) > 0 && pen_clock_ns() < until)
        nanosleep(&pause, NULL);
}

void pen_http_stop(struct pen_http *http)
{
    if (!http)
        return;
    pen_http_listener_stop_accepting(http->listener);
    atomic_store_explicit(&http->stopping, true, memory_order_relaxed);
    pen_http_watch_stop(http->watch);
    wait_for_requests(http);
    pen_http_executor_stop(http->executor);
    pen_http_listener_stop(http->listener);
    release(http);
}
