/* SPDX-License-Identifier: MIT */
#include "http/internal/access_log.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/log.h"
#include "http/internal/request.h"

/* The kinds of requests that get lines above level debug: so many in a minute, and one more that
 * tells how many others there were. */
enum kind { REFUSED, FAILED, CHANGED, KINDS, OTHER = KINDS };

static const int64_t minute_ns = INT64_C(60000000000);
static const struct {
    enum pen_log_level level;
    int lines_in_minute;
    const char *what;
} kinds[KINDS] = {[REFUSED] = {PEN_LOG_WARN, 1, "were refused (429, 503)"},
                  [FAILED] = {PEN_LOG_WARN, 10, "failed (5xx)"},
                  [CHANGED] = {PEN_LOG_INFO, 600, "changed the store"}};

/* A minute that begins with a request of a kind; all zero: there is none. */
struct minute {
    int64_t begun_ms; /* wall clock */
    int64_t ends_ns;
    int told; /* in lines of their own */
    uint64_t untold;
};

struct access_log {
    /* atomic: relaxed, sums */
    atomic_uint_least64_t refused_429, refused_503, failed;
    _Atomic int64_t due_ns; /* when requests that are not told have to be. atomic: relaxed, it
                             * spares others the lock */
    pthread_mutex_t lock;
    struct minute minute[KINDS]; /* guarded by lock */
};

struct access_log *pen_http_access_log_new(void)
{
    struct access_log *log = calloc(1, sizeof *log);
    if (!log)
        return NULL;
    atomic_init(&log->due_ns, INT64_MAX);
    pthread_mutex_init(&log->lock, NULL);
    return log;
}

/* Takes the minutes that are over. Called with the lock held. */
static void take_minutes(struct access_log *log, int64_t now_ns, struct minute over[KINDS])
{
    for (int kind = 0; kind < KINDS; kind++) {
        struct minute *minute = &log->minute[kind];
        over[kind] = (struct minute){0};
        if (minute->ends_ns <= now_ns) {
            over[kind] = *minute;
            *minute = (struct minute){0};
        }
    }
}

/* Notes when requests have to be told. Called with the lock held. */
static void note_due(struct access_log *log)
{
    int64_t due_ns = INT64_MAX;
    for (int kind = 0; kind < KINDS; kind++) {
        const struct minute *minute = &log->minute[kind];
        if (minute->untold > 0 && minute->ends_ns < due_ns)
            due_ns = minute->ends_ns;
    }
    atomic_store_explicit(&log->due_ns, due_ns, memory_order_relaxed);
}

static void tell_minutes(const struct minute over[KINDS])
{
    for (int kind = 0; kind < KINDS; kind++) {
        char since[25];
        if (over[kind].untold == 0)
            continue;
        pen_clock_format(over[kind].begun_ms, since);
        pen_log(kinds[kind].level, "%llu more requests %s since %s",
                (unsigned long long)over[kind].untold, kinds[kind].what, since);
    }
}

void pen_http_access_log_free(struct access_log *log)
{
    if (!log)
        return;
    struct minute all[KINDS];
    take_minutes(log, INT64_MAX, all);
    tell_minutes(all);
    pthread_mutex_destroy(&log->lock);
    free(log);
}

/* Counts a request of this kind. Returns whether it gets a line of its own. Called with the lock
 * held. */
static bool count(struct access_log *log, enum kind kind, int64_t now_ns)
{
    struct minute *minute = &log->minute[kind];
    if (minute->ends_ns == 0)
        *minute = (struct minute){.begun_ms = pen_clock_wall_ms(), .ends_ns = now_ns + minute_ns};
    if (minute->told < kinds[kind].lines_in_minute) {
        minute->told++;
        return true;
    }
    minute->untold++;
    return false;
}

/* Tells what is due, and counts a request. Returns whether it gets a line of its own. */
static bool bound(struct access_log *log, enum kind kind, int64_t now_ns)
{
    struct minute over[KINDS];
    if (kind == OTHER && now_ns < atomic_load_explicit(&log->due_ns, memory_order_relaxed))
        return false;
    pthread_mutex_lock(&log->lock);
    take_minutes(log, now_ns, over);
    const bool told = kind != OTHER && count(log, kind, now_ns);
    note_due(log);
    pthread_mutex_unlock(&log->lock);
    tell_minutes(over);
    return told;
}

/* Sorts a request, and counts it if it was refused or failed. What has no route is refused before
 * it comes to anything, with 505 at worst. */
static enum kind sort(struct access_log *log, const struct request *request)
{
    const int status = request->reply.status;
    const enum kind other = request->changed ? CHANGED : OTHER;
    if (status < 429 || atomic_load_explicit(&request->unwanted, memory_order_relaxed))
        return other;
    if (status == 429 || status == 503) {
        atomic_fetch_add_explicit(status == 429 ? &log->refused_429 : &log->refused_503, 1,
                                  memory_order_relaxed);
        return REFUSED;
    }
    if (status < 500 || !request->route)
        return other;
    atomic_fetch_add_explicit(&log->failed, 1, memory_order_relaxed);
    return FAILED;
}

void pen_http_access_log_add(struct access_log *log, const struct request *request,
                             uint64_t streamed, bool complete)
{
    const struct reply *reply = &request->reply;
    const int64_t now_ns = pen_clock_ns();
    const enum kind kind = sort(log, request);
    const enum pen_log_level level = bound(log, kind, now_ns) ? kinds[kind].level : PEN_LOG_DEBUG;
    const int64_t us = (now_ns - request->begun_ns) / 1000;
    const bool sent = !request->head && reply->status != 304;
    const uint64_t bytes = streamed + (sent ? reply->bytes : 0);
    const struct pen_log_about about = {.job = request->job_id, .request = request->id};
    const char *trace = request->fields.traceparent;
    pen_log_about(level, &about, "%.*s %.*s %d %llu bytes %lld.%03lld ms%s%s%s",
                  LOGGED_METHOD_BYTES, request->method, LOGGED_TARGET_BYTES, request->raw_target,
                  reply->status, (unsigned long long)bytes, (long long)(us / 1000),
                  (long long)(us % 1000), complete ? "" : " (cut short)",
                  trace ? " traceparent=" : "", trace ? trace : "");
}

struct access_counts pen_http_access_log_counts(const struct access_log *log)
{
    return (struct access_counts){
        .refused_429 = atomic_load_explicit(&log->refused_429, memory_order_relaxed),
        .refused_503 = atomic_load_explicit(&log->refused_503, memory_order_relaxed),
        .failed = atomic_load_explicit(&log->failed, memory_order_relaxed)};
}
