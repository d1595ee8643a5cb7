/* SPDX-License-Identifier: MIT */
/* A request is in the watcher's list from pen_http_watch_add until its wait is over, except while
 * the thread checks its job.
 *
 * No change is missed, because a counter is raised, under the lock, before the jobs are read. A
 * request that is added with an older counter may have missed that check, so it wakes the thread
 * for another. A request with the same or a newer counter is in the list before the next check.
 *
 * While a request waits, the guard watches its client. The thread that ends the wait owns the
 * request afterwards. This is the watcher's thread if it can take the request back from the guard,
 * else the thread in pen_http_watch_gone. Order of locks: the watcher's, then libmicrohttpd's or
 * the guard's. */
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
    POLL_MS = 250,   /* longest delay until a deadline is noticed */
    UPDATE_MS = 20,  /* mean shortest time between two updates of streams */
    UPDATE_BURST = 4 /* updates that may follow each other at once: enough for a small job */
};
static const int64_t update_interval_ns = UPDATE_MS * INT64_C(1000000);
static const int64_t check_all_ns = INT64_C(1000000000); /* between checks of all jobs */

struct watch {
    struct pen_http *http;
    struct pen_jobs *jobs; /* used by the thread only, except in pen_store_wait and _wake */
    pthread_t thread;
    pthread_mutex_t lock;
    struct request *list;      /* guarded by lock */
    uint32_t checked;          /* guarded by lock: the change counter at the last check of polls, */
    uint32_t updated;          /* and at the last one of streams */
    bool closed;               /* guarded by lock */
    struct stream_texts texts; /* the thread's */
};

/* Answers a poll if its job has changed, or in any case if `now` is set. Returns whether its wait
 * is over. The text of a job is made only for an answer, since most changes are those of other
 * jobs. */
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

/* Puts a request into the list. Called with the lock held. */
static void enlist(struct watch *watch, struct request *request)
{
    request->watch = WATCHED_LISTED;
    request->next = watch->list;
    watch->list = request;
}

/* Gives a request whose wait is over to its connection or to its handler. */
static void pass_on(struct watch *watch, struct request *request)
{
    if (!request->stream) {
        atomic_fetch_sub_explicit(&watch->http->polls, 1, memory_order_relaxed);
        if (request->route->handle_again && request->reply.status == 0) {
            pen_http_executor_submit(watch->http->executor, request->route->queue, request);
            return;
        }
        pen_http_request_encode(request);
    }
    pen_http_resume(request);
}

/* Ends the check of a request. If its wait is not over, puts it back into the list. Returns whether
 * the wait is over and the caller has the request. */
static bool settle(struct watch *watch, struct request *request, bool over)
{
    bool mine = false;
    pthread_mutex_lock(&watch->lock);
    if (request->gone) {
        mine = true;
    } else if (!over) {
        enlist(watch, request);
    } else {
        mine = pen_guard_unwatch(watch->http->guard, request->fd);
        request->watch = WATCHED_LEFT; /* the caller has it, or pen_http_watch_gone */
    }
    pthread_mutex_unlock(&watch->lock);
    return mine;
}

/* One pass of the thread's loop, and the values that it keeps between passes. */
struct pass {
    uint32_t changes; /* the store's change counter */
    int64_t now_ns;
    int64_t checked_ns; /* when all polls were last checked */
    /* The earliest time of the next update of streams. It lies up to UPDATE_BURST intervals in the
     * past, which allows a burst. */
    int64_t update_ns;
    bool closing;
    bool check;      /* check every poll, not only those past their deadline */
    bool update_due; /* streams have had no update since the last check of all polls */
    bool update;     /* check every stream */
};

/* Sleeps until the store has changed, or a deadline has come. Changes are noticed here for the
 * whole process (pen_store_changes), so the thread does this even if no request waits. */
static void sleep_until_due(struct watch *watch, struct pass *pass)
{
    pthread_mutex_lock(&watch->lock);
    const bool closed = watch->closed;
    pthread_mutex_unlock(&watch->lock);
    const int wait_ms = closed ? 0 : pass->update_due ? UPDATE_MS : POLL_MS;
    pen_store_wait(pen_jobs_store(watch->jobs), &pass->changes, wait_ms);
    pass->now_ns = pen_clock_ns();
}

/* Decides what this pass checks, and raises the counters. Streams are updated every UPDATE_MS at
 * most, on average. Called with the lock held. */
static void plan(struct watch *watch, struct pass *pass)
{
    pass->closing = watch->closed;
    pass->check = pass->closing || pass->changes != watch->checked ||
                  pass->now_ns - pass->checked_ns >= check_all_ns;
    pass->update_due = pass->update_due || pass->check;
    pass->update = pass->closing || (pass->update_due && pass->now_ns >= pass->update_ns);
    if (pass->check) {
        watch->checked = pass->changes;
        pass->checked_ns = pass->now_ns;
    }
    if (pass->update) {
        const int64_t earliest_ns = pass->now_ns - UPDATE_BURST * update_interval_ns;
        watch->updated = pass->changes;
        pass->update_due = false;
        pass->update_ns =
            (pass->update_ns > earliest_ns ? pass->update_ns : earliest_ns) + update_interval_ns;
    }
}

/* Takes the requests that are to be checked out of the list. */
static struct request *take_requests(struct watch *watch, struct pass *pass)
{
    struct request *taken = NULL;
    pthread_mutex_lock(&watch->lock);
    plan(watch, pass);
    for (struct request **link = &watch->list; *link;) {
        struct request *request = *link;
        const bool all = request->stream ? pass->update : pass->check;
        if (all || request->deadline_ns <= pass->now_ns) {
            *link = request->next;
            request->watch = WATCHED_CHECKED;
            request->next = taken;
            taken = request;
        } else {
            link = &request->next;
        }
    }
    pthread_mutex_unlock(&watch->lock);
    return taken;
}

/* Checks the job of a request. Returns whether the wait is over. */
static bool check(struct watch *watch, struct request *request, const struct pass *pass)
{
    if (!request->stream)
        return answer(watch, request, pass->changes,
                      pass->closing || request->deadline_ns <= pen_clock_ns());
    const bool over = pen_http_stream_advance(request, watch->jobs, pass->changes, &watch->texts);
    if (pass->closing)
        pen_http_stream_end(request->stream);
    return over || pass->closing;
}

static void *run(void *arg)
{
    struct watch *watch = arg;
    struct pass pass = {0};
    while (!pass.closing) {
        sleep_until_due(watch, &pass);
        for (struct request *request = take_requests(watch, &pass), *next; request;
             request = next) {
            next = request->next;
            if (settle(watch, request, check(watch, request, &pass)))
                pass_on(watch, request);
        }
        pen_http_stream_texts_release(&watch->texts);
        pen_http_check_store(watch->http, watch->jobs);
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
    pthread_mutex_unlock(&watch->lock);
    pthread_join(watch->thread, NULL);
}

void pen_http_watch_free(struct watch *watch)
{
    if (!watch)
        return;
    pen_jobs_close(watch->jobs);
    pthread_mutex_destroy(&watch->lock);
    free(watch);
}

/* Puts a request into the list, if there is a place. Sets *late if it needs the thread at once.
 * Called with the lock held. */
static enum watch_result add(struct watch *watch, struct request *request, uint32_t changes,
                             bool *late)
{
    atomic_int *polls = &watch->http->polls;
    if (watch->closed || request->gone)
        return WATCH_CLOSED;
    if (request->stream) {
        pen_http_suspend(request);
    } else if (atomic_fetch_add_explicit(polls, 1, memory_order_relaxed) >= WATCH_MAX) {
        atomic_fetch_sub_explicit(polls, 1, memory_order_relaxed);
        return WATCH_FULL;
    }
    *late = (int32_t)((request->stream ? watch->updated : watch->checked) - changes) > 0 ||
            request->deadline_ns == 0;
    enlist(watch, request);
    pen_guard_watch(watch->http->guard, request->fd, request);
    return WATCH_ACCEPTED;
}

enum watch_result pen_http_watch_add(struct watch *watch, struct request *request, uint32_t changes)
{
    bool late = false;
    pthread_mutex_lock(&watch->lock);
    const enum watch_result result = add(watch, request, changes, &late);
    pthread_mutex_unlock(&watch->lock);
    if (late)
        pen_store_wake(pen_jobs_store(watch->jobs));
    return result;
}

void pen_http_watch_gone(struct watch *watch, struct request *request)
{
    pthread_mutex_lock(&watch->lock);
    const bool mine =
        request->watch != WATCHED_CHECKED; /* otherwise the thread finds that it has gone */
    request->gone = true;
    for (struct request **link = &watch->list; mine && *link; link = &(*link)->next) {
        if (*link == request) {
            *link = request->next;
            break;
        }
    }
    pthread_mutex_unlock(&watch->lock);
    if (mine)
        pass_on(watch, request);
}
