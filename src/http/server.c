/* SPDX-License-Identifier: MIT */
/* Start and stop. Stopping goes from the outside in: no new connections, no new work, long polls
 * answered and event streams ended, work in progress finished and sent, threads ended, connections
 * closed. */
#include "http/server.h"

#include <sodium.h>
#include <stdlib.h>
#include <time.h>

#include "base/clock.h"
#include "base/utf8.h"
#include "http/internal/adapter.h"
#include "http/internal/http.h"
#include "http/internal/pool.h"
#include "http/internal/snapshots.h"
#include "http/internal/statics.h"
#include "http/internal/streams.h"
#include "http/internal/watch.h"
#include "jobs/jobs.h"

enum { STORE_THREADS = 4, SIDE_THREADS = 2, IDLE_SECONDS = 30, BEAT_MS = 10000 };
static const int64_t finish_ns = INT64_C(1500000000);

/* Frees whatever there is. No connection may be open. */
static void release(struct pen_http *http)
{
    pen_http_pool_free(http->pool);
    pen_http_watch_free(http->watch);
    pen_http_snapshots_free(http->snapshots);
    pen_http_streams_free(http->streams);
    pen_http_statics_free(http->statics);
    pthread_mutex_destroy(&http->ready_lock);
    free(http);
}

static bool start_threads(struct pen_http *http, const struct pen_http_options *options,
                          struct pen_status *st)
{
    struct pen_jobs *jobs = pen_jobs_open(options->store_url, &http->limits, st);
    if (!jobs)
        return false;
    http->watch = pen_http_watch_start(http, jobs, st);
    if (!http->watch)
        return false;
    const struct pool_options pool = {
        .store_url = options->store_url,
        .limits = &http->limits,
        .store_threads = options->store_threads > 0 ? options->store_threads : STORE_THREADS,
        .side_threads = SIDE_THREADS};
    http->pool = pen_http_pool_start(&pool, st);
    return http->pool != NULL;
}

static void stop_threads(struct pen_http *http)
{
    if (http->pool)
        pen_http_pool_stop(http->pool);
    if (http->watch)
        pen_http_watch_stop(http->watch);
}

static bool prepare(struct pen_http *http, int beat_ms, struct pen_status *st)
{
    http->snapshots = pen_http_snapshots_new();
    http->streams = pen_http_streams_new(http, beat_ms > 0 ? beat_ms : BEAT_MS);
    if (!http->snapshots || !http->streams)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the HTTP server");
    http->statics = pen_http_statics_new(st);
    return http->statics != NULL;
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
    int idle = options->idle_seconds > 0 ? options->idle_seconds : IDLE_SECONDS;
    bool ok = prepare(http, options->beat_ms, st) && start_threads(http, options, st) &&
              (http->adapter = pen_http_adapter_start(http, options->listen_fd, idle, st)) &&
              pen_http_adapter_accept(http->adapter, st);
    if (ok)
        return http;
    stop_threads(http);
    pen_http_adapter_stop(http->adapter);
    release(http);
    return NULL;
}

void pen_http_drain(struct pen_http *http)
{
    atomic_store_explicit(&http->draining, true, memory_order_relaxed);
}

void pen_http_note(struct pen_http *http, const char *trouble)
{
    pthread_mutex_lock(&http->ready_lock);
    pen_utf8_copy(http->trouble, sizeof http->trouble, trouble);
    pthread_mutex_unlock(&http->ready_lock);
}

/* Waits until no request is in progress, but not for ever: a client may not be reading. */
static void wait_for_quiet(struct pen_http *http)
{
    const struct timespec pause = {.tv_nsec = 5000000};
    int64_t until = pen_clock_ns() + finish_ns;
    while (atomic_load_explicit(&http->active, memory_order_relaxed) > 0 && pen_clock_ns() < until)
        nanosleep(&pause, NULL);
}

void pen_http_stop(struct pen_http *http)
{
    if (!http)
        return;
    pen_http_adapter_stop_accepting(http->adapter);
    atomic_store_explicit(&http->stopping, true, memory_order_relaxed);
    pen_http_watch_stop(http->watch);
    wait_for_quiet(http);
    pen_http_pool_stop(http->pool);
    pen_http_adapter_stop(http->adapter);
    release(http);
}
