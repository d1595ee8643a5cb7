/* SPDX-License-Identifier: MIT */
/* Start and stop. The server stops in this order:
 *   1. no new connections are accepted, and new requests are refused;
 *   2. long polls are answered, and event streams end;
 *   3. requests in progress are finished and sent, for finish_max_ns at most;
 *   4. the executor's threads end;
 *   5. all connections are closed. */
#include "http/server.h"

#include <sodium.h>
#include <stdlib.h>
#include <time.h>

#include "base/clock.h"
#include "base/utf8.h"
#include "http/internal/access_log.h"
#include "http/internal/executor.h"
#include "http/internal/http.h"
#include "http/internal/listener.h"
#include "http/internal/pictures.h"
#include "http/internal/snapshot_cache.h"
#include "http/internal/static_files.h"
#include "http/internal/streams.h"
#include "http/internal/trim.h"
#include "http/internal/watch.h"
#include "jobs/jobs.h"

enum {
    STORE_THREADS = 4,
    SUBMIT_THREADS = 4,
    LIST_THREADS = 2,
    COMPUTE_THREADS = 2,
    INTAKE_THREADS = 1,
    HEARTBEAT_MS = 10000,
    WAITING_PER_ADDRESS = 32
};
static const int64_t finish_max_ns = INT64_C(1500000000);

/* Frees the server and those of its parts that exist. No connection may be open. */
static void release(struct pen_http *http)
{
    pen_http_trim_stop(http->trim);
    pen_http_executor_free(http->executor);
    pen_http_watch_free(http->watch);
    pen_http_snapshot_cache_free(http->snapshot_cache);
    pen_http_streams_free(http->streams);
    pen_http_pictures_free(http->pictures);
    pen_http_static_files_free(http->static_files);
    pen_http_access_log_free(http->access_log);
    pthread_mutex_destroy(&http->ready_lock);
    pthread_mutex_destroy(&http->intake_lock);
    pen_http_answers_release(&http->answers);
    free(http);
}

static bool start_threads(struct pen_http *http, const struct pen_http_options *options,
                          struct pen_status *st)
{
    struct pen_jobs *jobs = pen_jobs_open(options->store_url, &http->limits, st);
    if (!jobs)
        return false;
    int address_max = options->waiting_per_address;
    address_max = address_max > 0 ? address_max : WAITING_PER_ADDRESS;
    http->watch = pen_http_watch_start(http, jobs, address_max, st);
    http->trim = http->watch ? pen_http_trim_start(st) : NULL;
    if (!http->trim)
        return false;
    const struct executor_options executor = {
        .store_url = options->store_url,
        .limits = &http->limits,
        .store_threads = options->store_threads > 0 ? options->store_threads : STORE_THREADS,
        .submit_threads = SUBMIT_THREADS,
        .list_threads = LIST_THREADS,
        .compute_threads = COMPUTE_THREADS,
        .intake_threads = INTAKE_THREADS};
    http->executor = pen_http_executor_start(&executor, st);
    return http->executor != NULL;
}

static void stop_threads(struct pen_http *http)
{
    if (http->executor)
        pen_http_executor_stop(http->executor);
    if (http->watch)
        pen_http_watch_stop(http->watch);
}

static bool prepare(struct pen_http *http, int heartbeat_ms, struct pen_status *st)
{
    http->access_log = pen_http_access_log_new();
    http->snapshot_cache = pen_http_snapshot_cache_new();
    http->streams =
        pen_http_streams_new(http->snapshot_cache, heartbeat_ms > 0 ? heartbeat_ms : HEARTBEAT_MS);
    http->pictures = pen_http_pictures_new();
    if (!http->access_log || !http->snapshot_cache || !http->streams || !http->pictures)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the HTTP server");
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
    http->id_prefix = randombytes_random();
    pthread_mutex_init(&http->ready_lock, NULL);
    pthread_mutex_init(&http->intake_lock, NULL);
    pen_http_answers_init(&http->answers);
    bool ok = prepare(http, options->heartbeat_ms, st) && start_threads(http, options, st) &&
              (http->listener = pen_http_listener_start(http, options, st)) &&
              pen_http_listener_accept(http->listener, st);
    if (ok)
        return http;
    stop_threads(http);
    pen_http_listener_stop(http->listener);
    release(http);
    return NULL;
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

/* Waits until no request is in progress; finish_max_ns at most, as a client may stop reading. */
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
