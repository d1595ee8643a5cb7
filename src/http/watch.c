/* SPDX-License-Identifier: MIT */
/* The watcher's list is short-lived state: a request is in it from pen_http_watch_add until it is
 * answered. While the thread looks at jobs, the entries in question are in its own hands, not in
 * the list.
 *
 * Why no change is missed: `seen` is raised, under the lock, before the jobs are looked at. An
 * entry that comes with an older counter than `seen` may have missed that look, so its caller has
 * to look again; an entry with the same or a newer one is in the list before the next look. */
#include "http/internal/watch.h"

#include <pthread.h>
#include <stdlib.h>

#include "base/clock.h"
#include "http/internal/adapter.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/snapshots.h"
#include "http/internal/streams.h"
#include "jobs/jobs.h"

enum {
    TICK_MS = 250, /* how late a deadline may be noticed */
    PACE_MS = 20,  /* between two texts of a stream, on average */
    BURST = 4      /* that many may follow each other at once: a small job's whole life */
};
static const int64_t pace_ns = PACE_MS * INT64_C(1000000);
static const int64_t look_anyway_ns = INT64_C(1000000000);

struct watch {
    struct pen_http *http;
    struct pen_jobs *jobs; /* the thread's, but for pen_store_wait */
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t filled;
    struct request *list; /* guarded by lock */
    int count;            /* guarded by lock: in the list or in the thread's hands */
    int places;           /* guarded by lock: streams */
    uint32_t seen;        /* guarded by lock: NEWS at the last look */
    bool closed;          /* guarded by lock */
};

uint32_t pen_http_watch_notify(struct watch *watch)
{
    uint32_t news = 0;
    pen_store_wait(pen_jobs_store(watch->jobs), PEN_SIGNAL_CHANGES, &news, 0);
    return news;
}

/* Answers a request whose job is as it waits for, or whose time is up. False: it waits on. */
static bool answer(struct watch *watch, struct request *request, uint32_t news, bool at_once)
{
    struct snapshot snapshot;
    struct pen_status st;
    if (!pen_http_snapshots_read(watch->http->snapshots, news, watch->jobs, request->job_id,
                                 &snapshot, &st)) {
        pen_http_request_fail(request, &st);
        return true;
    }
    bool due = at_once || pen_http_snapshot_is_due(&snapshot, request);
    if (due)
        pen_http_snapshot_reply(&snapshot, request);
    pen_http_snapshot_release(&snapshot);
    return due;
}

/* Takes out of the list what has to be looked at: all of it, or what has run out of time. */
static struct request *take(struct watch *watch, bool all, int64_t now)
{
    struct request *taken = NULL;
    struct request **link = &watch->list;
    while (*link) {
        struct request *request = *link;
        if (all || request->deadline_ns <= now) {
            *link = request->next;
            request->next = taken;
            taken = request;
        } else {
            link = &request->next;
        }
    }
    return taken;
}

/* Looks at the jobs of these requests; those that wait on go back to the list. */
static void look(struct watch *watch, struct request *taken, uint32_t news, bool closing)
{
    for (struct request *next; taken; taken = next) {
        next = taken->next;
        bool late = closing || taken->deadline_ns <= pen_clock_ns();
        bool answered = answer(watch, taken, news, late);
        pthread_mutex_lock(&watch->lock);
        if (answered) {
            watch->count--;
        } else {
            taken->next = watch->list;
            watch->list = taken;
        }
        pthread_mutex_unlock(&watch->lock);
        if (answered)
            pen_http_adapter_wake(taken);
    }
}

/* One round of the thread, and what it keeps from round to round. */
struct turn {
    uint32_t news;
    int64_t now_ns, looked_ns;
    int64_t tell_ns; /* when streams may be told next; lies back by what was not used */
    bool closing;
    bool all;  /* look at every job, not only where the time is up */
    bool owed; /* streams have not been told of the last look yet */
};

/* Sleeps for good while nobody waits, else until there are news or something else is due. */
static void sleep_until_due(struct watch *watch, struct turn *turn)
{
    pthread_mutex_lock(&watch->lock);
    while (!watch->list && !watch->places && !watch->closed)
        pthread_cond_wait(&watch->filled, &watch->lock);
    turn->news = watch->seen;
    bool closed = watch->closed;
    pthread_mutex_unlock(&watch->lock);
    pen_store_wait(pen_jobs_store(watch->jobs), PEN_SIGNAL_CHANGES, &turn->news,
                   closed       ? 0
                   : turn->owed ? PACE_MS
                                : TICK_MS);
    turn->now_ns = pen_clock_ns();
}

static void attend_polls(struct watch *watch, struct turn *turn)
{
    pthread_mutex_lock(&watch->lock);
    turn->closing = watch->closed;
    turn->all = turn->closing || turn->news != watch->seen ||
                turn->now_ns - turn->looked_ns >= look_anyway_ns;
    watch->seen = turn->news;
    struct request *taken = take(watch, turn->all, turn->now_ns);
    pthread_mutex_unlock(&watch->lock);
    if (turn->all)
        turn->looked_ns = turn->now_ns;
    look(watch, taken, turn->news, turn->closing);
}

/* However fast jobs change, streams are told so many times a second and no more. */
static void attend_streams(struct watch *watch, struct turn *turn)
{
    struct streams *streams = watch->http->streams;
    turn->owed = turn->owed || turn->all;
    if (turn->closing || (turn->owed && turn->now_ns >= turn->tell_ns)) {
        int64_t spare_ns = turn->now_ns - BURST * pace_ns;
        turn->owed = false;
        turn->tell_ns = (turn->tell_ns > spare_ns ? turn->tell_ns : spare_ns) + pace_ns;
        pen_http_streams_look(streams, watch->jobs, turn->news);
    }
    pen_http_streams_beat(streams, turn->now_ns);
    if (turn->closing)
        pen_http_streams_end(streams);
}

static void *run(void *arg)
{
    struct watch *watch = arg;
    struct turn turn = {0};
    while (!turn.closing) {
        sleep_until_due(watch, &turn);
        attend_polls(watch, &turn);
        attend_streams(watch, &turn);
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
    watch->seen = pen_http_watch_notify(watch);
    if (pthread_create(&watch->thread, NULL, run, watch) == 0)
        return watch;
    pen_http_watch_free(watch);
    pen_fail(st, PEN_UNAVAILABLE, "no thread for the watcher");
    return NULL;
}

void pen_http_watch_stop(struct watch *watch)
{
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

enum watch_answer pen_http_watch_add(struct watch *watch, struct request *request, uint32_t news)
{
    enum watch_answer given = WATCH_TAKEN;
    pthread_mutex_lock(&watch->lock);
    if (!watch->count && !watch->places)
        watch->seen = news; /* nobody else waits, so nothing was missed before this */
    if (watch->closed)
        given = WATCH_CLOSED;
    else if (watch->count + watch->places >= WATCH_MAX)
        given = WATCH_FULL;
    else if ((int32_t)(news - watch->seen) < 0)
        given = WATCH_NEWS;
    if (given == WATCH_TAKEN) {
        request->next = watch->list;
        watch->list = request;
        watch->count++;
        pthread_cond_signal(&watch->filled);
    }
    pthread_mutex_unlock(&watch->lock);
    return given;
}

enum watch_answer pen_http_watch_enter(struct watch *watch)
{
    enum watch_answer given = WATCH_TAKEN;
    pthread_mutex_lock(&watch->lock);
    if (watch->closed)
        given = WATCH_CLOSED;
    else if (watch->count + watch->places >= WATCH_MAX)
        given = WATCH_FULL;
    else if (watch->places++ == 0)
        pthread_cond_signal(&watch->filled);
    pthread_mutex_unlock(&watch->lock);
    return given;
}

void pen_http_watch_remove(struct watch *watch)
{
    pthread_mutex_lock(&watch->lock);
    watch->places--;
    pthread_mutex_unlock(&watch->lock);
}

void pen_http_watch_joined(struct watch *watch, uint32_t news)
{
    pthread_mutex_lock(&watch->lock);
    bool late = (int32_t)(watch->seen - news) > 0;
    pthread_mutex_unlock(&watch->lock);
    if (late)
        pen_http_watch_hurry(watch);
}

void pen_http_watch_hurry(struct watch *watch)
{
    pen_store_wake(pen_jobs_store(watch->jobs), PEN_SIGNAL_CHANGES);
}
