/* SPDX-License-Identifier: MIT */
#include "http/internal/trim.h"

#include <malloc.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <time.h>

enum {
    CLOSED_MANY = 1024, /* connections; fewer hold little but answers, which have their budgets */
    PAUSE_S = 3         /* from many closed connections until memory is given back */
};

struct trim {
    atomic_int closed; /* connections since memory was given back. atomic: relaxed, a sum */
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t changed; /* by CLOCK_MONOTONIC */
    bool due;               /* guarded by lock: many have closed */
    bool stop;              /* guarded by lock */
};

/* Waits for PAUSE_S, so that the connections that close together are all closed. Called with the
 * lock held. */
static void pause_or_stop(struct trim *trim)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_sec += PAUSE_S;
    while (!trim->stop && pthread_cond_timedwait(&trim->changed, &trim->lock, &until) == 0)
        continue;
}

static void *run(void *arg)
{
    struct trim *trim = arg;
    pthread_mutex_lock(&trim->lock);
    while (!trim->stop) {
        if (!trim->due) {
            pthread_cond_wait(&trim->changed, &trim->lock);
            continue;
        }
        pause_or_stop(trim);
        trim->due = false;
        atomic_store_explicit(&trim->closed, 0, memory_order_relaxed);
        pthread_mutex_unlock(&trim->lock);
        malloc_trim(0);
        pthread_mutex_lock(&trim->lock);
    }
    pthread_mutex_unlock(&trim->lock);
    return NULL;
}

static void release(struct trim *trim)
{
    pthread_cond_destroy(&trim->changed);
    pthread_mutex_destroy(&trim->lock);
    free(trim);
}

struct trim *pen_http_trim_start(struct pen_status *st)
{
    struct trim *trim = calloc(1, sizeof *trim);
    if (!trim) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the HTTP server");
        return NULL;
    }
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&trim->changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    pthread_mutex_init(&trim->lock, NULL);
    if (pthread_create(&trim->thread, NULL, run, trim) == 0)
        return trim;
    release(trim);
    pen_fail(st, PEN_UNAVAILABLE, "no thread that gives memory back");
    return NULL;
}

void pen_http_trim_stop(struct trim *trim)
{
    if (!trim)
        return;
    pthread_mutex_lock(&trim->lock);
    trim->stop = true;
    pthread_cond_signal(&trim->changed);
    pthread_mutex_unlock(&trim->lock);
    pthread_join(trim->thread, NULL);
    release(trim);
}

void pen_http_trim_note(struct trim *trim)
{
    if (atomic_fetch_add_explicit(&trim->closed, 1, memory_order_relaxed) + 1 != CLOSED_MANY)
        return;
    pthread_mutex_lock(&trim->lock);
    trim->due = true;
    pthread_cond_signal(&trim->changed);
    pthread_mutex_unlock(&trim->lock);
}
