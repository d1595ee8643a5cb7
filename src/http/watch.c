/* SPDX-License-Identifier: MIT */
/* A long poll is in the watcher's list from pen_http_watch_add until it is answered, except while
 * the thread checks its job.
 *
 * Why no change is missed: `seen` is raised, under the lock, before the jobs are read.
 *   - A request with a counter older than `seen` may have missed that check: pen_http_watch_add
 *     returns WATCH_CHANGED, and its caller reads the job again.
 *   - A request with the same counter or a newer one is in the list before the next check.
 *
 * The guard watches a request's client from pen_http_watch_add until its wait is over. Whoever ends
 * the wait owns the request: the thread, if it can take it back from the guard, else
 * pen_http_watch_gone. Order of locks: the watcher's, then the guard's. */
#include "http/internal/watch.h"

#include <pthread.h>
#include <stdlib.h>

#include "base/clock.h"
#include "http/internal/encoding.h"
#include "http/internal/executor.h"
#include "http/internal/guard.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/snapshot_cache.h"
#include "http/internal/streams.h"
#include "jobs/jobs.h"

enum {
    POLL_MS = 250,   /* the longest delay until a deadline is noticed */
    UPDATE_MS = 20,  /* the shortest time between two updates of streams, on average */
    UPDATE_BURST = 4 /* updates that may follow each other at once: the whole life of a small job */
};
static const int64_t update_interval_ns = UPDATE_MS * INT64_C(1000000);
static const int64_t check_all_ns = INT64_C(1000000000); /* between checks of all jobs */

struct watch {
    struct pen_http *http;
    struct pen_jobs *jobs; /* used by the thread alone, except in pen_store_wait and _wake */
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t filled;
    struct request *list; /* guarded by lock */
    int count;            /* guarded by lock: long polls, in the list or being checked */
    int streams;          /* guarded by lock: open event streams */
    uint32_t seen;        /* guarded by lock: the change counter at the last check */
    bool closed;          /* guarded by lock */
};

uint32_t pen_http_watch_changes(struct watch *watch)
{
    uint32_t changes = 0;
    pen_store_wait(pen_jobs_store(watch->jobs), PEN_SIGNAL_CHANGES, &changes, 0);
    return changes;
}

/* Answers a request if the change that it waits for has come, or in any case if `now` is set.
 * Returns whether its wait is over; otherwise it waits on. The text of a job is made only for an
 * answer: most changes are those of other jobs. */
static bool answer(struct watch *watch, struct request *request, uint32_t changes, bool now)
{
    struct snapshot_cache *cache = watch->http->snapshot_cache;
    struct snapshot snapshot;
    struct pen_status st;
    bool due = now;
    if ((!due && !pen_http_snapshot_cache_check(cache, changes, watch->jobs, request, &due, &st)) ||
        (due && !pen_http_snapshot_cache_read(cache, changes, watch->jobs, request->job_id,
                                              &snapshot, &st))) {
        pen_http_request_fail(request, &st);
        return true;
    }
    if (!due)
        return false;
    if (!request->route->handle_again)
        pen_http_snapshot_reply(&snapshot, request);
    pen_http_snapshot_release(&snapshot);
    return true;
}

/* Takes requests out of the list: all of them, or those past their deadline. */
static struct request *take_requests(struct watch *watch, bool all, int64_t now)
{
    struct request *taken = NULL;
    struct request **link = &watch->list;
    while (*link) {
        struct request *request = *link;
        if (all || request->deadline_ns <= now) {
            *link = request->next;
            request->watch = WATCHED_CHECKED;
            request->next = taken;
            taken = request;
        } else {
            link = &request->next;
        }
    }
    return taken;
}

/* Puts a request into the list. Called with the lock held. */
static void enlist(struct watch *watch, struct request *request)
{
    request->watch = WATCHED_LISTED;
    request->next = watch->list;
    watch->list = request;
}

/* Gives a request whose wait is over to its connection, or to its handler. */
static void pass_on(struct watch *watch, struct request *request)
{
    if (request->route->handle_again && request->reply.status == 0) {
        pen_http_executor_submit(watch->http->executor, request->route->queue, request);
        return;
    }
    pen_http_request_encode(request);
    pen_http_resume(request);
}

/* Notes what came of a check: puts a request whose wait is not over back to the list. Returns
 * whether its wait is over, and the request the caller's. */
static bool settle(struct watch *watch, struct request *request, bool answered)
{
    bool over = false;
    pthread_mutex_lock(&watch->lock);
    if (request->gone) {
        over = true;
    } else if (!answered) {
        enlist(watch, request);
    } else {
        over = pen_guard_unwatch(watch->http->guard, request->fd);
        request->watch = WATCHED_LEFT; /* to pen_http_watch_gone, unless it is over */
    }
    watch->count -= over;
    pthread_mutex_unlock(&watch->lock);
    return over;
}

/* Reads the jobs of these requests; requests that wait on go back to the list. */
static void check_requests(struct watch *watch, struct request *taken, uint32_t changes,
                           bool closing)
{
    for (struct request *next; taken; taken = next) {
        next = taken->next;
        bool late = closing || taken->deadline_ns <= pen_clock_ns();
        if (settle(watch, taken, answer(watch, taken, changes, late)))
            pass_on(watch, taken);
    }
}

/* One pass of the thread's loop, and what it keeps from pass to pass. */
struct pass {
    uint32_t changes; /* the store's change counter */
    int64_t now_ns;
    int64_t checked_ns; /* when all jobs were last checked */
    int64_t update_ns;  /* the earliest time of the next update of streams. It lies up to
                         * UPDATE_BURST intervals in the past, which allows a burst */
    bool closing;
    bool check_all;  /* check every job, and not only requests past their deadline */
    bool update_due; /* streams have had no update since the last check of all jobs */
};

/* Sleeps while no request waits; then until the store has changed, or something else is due. */
static void sleep_until_due(struct watch *watch, struct pass *pass)
{
    pthread_mutex_lock(&watch->lock);
    while (!watch->list && !watch->streams && !watch->closed)
        pthread_cond_wait(&watch->filled, &watch->lock);
    pass->changes = watch->seen;
    bool closed = watch->closed;
    pthread_mutex_unlock(&watch->lock);
    int wait_ms = closed ? 0 : pass->update_due ? UPDATE_MS : POLL_MS;
    pen_store_wait(pen_jobs_store(watch->jobs), PEN_SIGNAL_CHANGES, &pass->changes, wait_ms);
    pass->now_ns = pen_clock_ns();
}

static void serve_polls(struct watch *watch, struct pass *pass)
{
    pthread_mutex_lock(&watch->lock);
    pass->closing = watch->closed;
    pass->check_all = pass->closing || pass->changes != watch->seen ||
                      pass->now_ns - pass->checked_ns >= check_all_ns;
    watch->seen = pass->changes;
    struct request *taken = take_requests(watch, pass->check_all, pass->now_ns);
    pthread_mutex_unlock(&watch->lock);
    if (pass->check_all)
        pass->checked_ns = pass->now_ns;
    check_requests(watch, taken, pass->changes, pass->closing);
}

/* Updates the streams if that is due, but not more often than every UPDATE_MS on average. */
static void serve_streams(struct watch *watch, struct pass *pass)
{
    struct streams *streams = watch->http->streams;
    pass->update_due = pass->update_due || pass->check_all;
    if (pass->closing || (pass->update_due && pass->now_ns >= pass->update_ns)) {
        int64_t earliest_ns = pass->now_ns - UPDATE_BURST * update_interval_ns;
        pass->update_due = false;
        pass->update_ns =
            (pass->update_ns > earliest_ns ? pass->update_ns : earliest_ns) + update_interval_ns;
        pen_http_streams_update(streams, watch->jobs, pass->changes);
    }
    pen_http_streams_heartbeat(streams, pass->now_ns);
    if (pass->closing)
        pen_http_streams_end(streams);
}

static void *run(void *arg)
{
    struct watch *watch = arg;
    struct pass pass = {0};
    while (!pass.closing) {
        sleep_until_due(watch, &pass);
        serve_polls(watch, &pass);
        serve_streams(watch, &pass);
    }
    return NULL;
}

struct watch *pen_http_watch_start(struct pen_http *http, struct pen_jobs *jobs,
                                   struct pen_status *st)
{
    struct watch *watch = calloc(1, sizeof *watch);
    if (!watch) {
        pen_jobs_close(jobs);
        pen_fail(st, PEN_NO_MEMORY, "no memory for the watcher");
        return NULL;
    }
    *watch = (struct watch){.http = http, .jobs = jobs};
    pthread_mutex_init(&watch->lock, NULL);
    pthread_cond_init(&watch->filled, NULL);
    watch->seen = pen_http_watch_changes(watch);
    if (pthread_create(&watch->thread, NULL, run, watch) == 0)
        return watch;
    pen_http_watch_free(watch);
    pen_fail(st, PEN_UNAVAILABLE, "no thread for the watcher");
    return NULL;
}

void pen_http_watch_stop(struct watch *watch)
{
    if (!watch)
        return;
    pthread_mutex_lock(&watch->lock);
    watch->closed = true;
    pthread_cond_signal(&watch->filled);
    pthread_mutex_unlock(&watch->lock);
    pthread_join(watch->thread, NULL);
}

void pen_http_watch_free(struct watch *watch)
{
    if (!watch)
        return;
    pen_jobs_close(watch->jobs);
    pthread_cond_destroy(&watch->filled);
    pthread_mutex_destroy(&watch->lock);
    free(watch);
}

bool pen_http_watch_fail(enum watch_result result, struct pen_status *st)
{
    if (result == WATCH_FULL)
        return pen_fail(st, PEN_UNAVAILABLE, "%d requests are waiting already; try again later",
                        WATCH_MAX);
    return pen_fail(st, PEN_UNAVAILABLE, "the daemon is stopping");
}

/* Whether one request more may wait, of `count` of its kind. Called with the lock held. */
static enum watch_result take_place(const struct watch *watch, int count)
{
    return watch->closed ? WATCH_CLOSED : count >= WATCH_MAX ? WATCH_FULL : WATCH_ACCEPTED;
}

enum watch_result pen_http_watch_add(struct watch *watch, struct request *request, uint32_t changes)
{
    pthread_mutex_lock(&watch->lock);
    if (!watch->count && !watch->streams)
        watch->seen = changes; /* no other request waited, so no check was due before this one */
    enum watch_result result = WATCH_CHANGED;
    if (request->gone)
        result = WATCH_CLOSED;
    else if (watch->closed || (int32_t)(changes - watch->seen) >= 0)
        result = take_place(watch, watch->count);
    if (result == WATCH_ACCEPTED) {
        enlist(watch, request);
        pen_guard_watch(watch->http->guard, request->fd, request);
        watch->count++;
        pthread_cond_signal(&watch->filled);
    }
    pthread_mutex_unlock(&watch->lock);
    return result;
}

void pen_http_watch_gone(struct watch *watch, struct request *request)
{
    pthread_mutex_lock(&watch->lock);
    const bool mine = request->watch != WATCHED_CHECKED; /* else the thread finds it gone */
    request->gone = true;
    for (struct request **link = &watch->list; mine && *link; link = &(*link)->next) {
        if (*link == request) {
            *link = request->next;
            break;
        }
    }
    watch->count -= mine;
    pthread_mutex_unlock(&watch->lock);
    if (mine)
        pass_on(watch, request);
}

enum watch_result pen_http_watch_add_stream(struct watch *watch)
{
    pthread_mutex_lock(&watch->lock);
    enum watch_result result = take_place(watch, watch->streams);
    if (result == WATCH_ACCEPTED && watch->streams++ == 0)
        pthread_cond_signal(&watch->filled);
    pthread_mutex_unlock(&watch->lock);
    return result;
}

void pen_http_watch_remove_stream(struct watch *watch)
{
    pthread_mutex_lock(&watch->lock);
    watch->streams--;
    pthread_mutex_unlock(&watch->lock);
}

void pen_http_watch_stream_opened(struct watch *watch, uint32_t changes)
{
    pthread_mutex_lock(&watch->lock);
    bool late = (int32_t)(watch->seen - changes) > 0;
    pthread_mutex_unlock(&watch->lock);
    if (late)
        pen_http_watch_check_soon(watch);
}

void pen_http_watch_check_soon(struct watch *watch)
{
    pen_store_wake(pen_jobs_store(watch->jobs), PEN_SIGNAL_CHANGES);
}

void pen_http_watch_counts(struct watch *watch, int *polls, int *streams)
{
    pthread_mutex_lock(&watch->lock);
    *polls = watch->count;
    *streams = watch->streams;
    pthread_mutex_unlock(&watch->lock);
}
