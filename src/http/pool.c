/* SPDX-License-Identifier: MIT */
/* One queue per lane, one lock for both: the lock is held for a few instructions only. */
#include "http/internal/pool.h"

#include <malloc.h>
#include <pthread.h>
#include <stdlib.h>

#include "http/internal/adapter.h"
#include "http/internal/request.h"
#include "jobs/jobs.h"

enum {
    LANES = LANE_SIDE + 1,
    THREADS_MAX = 64,
    LARGE_BYTES = 256 << 10 /* a body whose parsed form leaves much free memory behind */
};

struct queue {
    struct request *head, **tail; /* guarded by lock */
    pthread_cond_t filled;
};

struct thread {
    pthread_t handle;
    struct pool *pool;
    struct pen_jobs *jobs;
    enum lane lane;
};

struct pool {
    pthread_mutex_t lock;
    struct queue queue[LANES];
    bool closed; /* guarded by lock */
    int busy;    /* guarded by lock: threads with a request */
    bool untidy; /* guarded by lock: a large body was worked on since the last tidy */
    int thread_count;
    struct thread thread[THREADS_MAX];
};

/* Gives memory back when the last thread falls idle after a large body: its parsed form was many
 * small pieces, and the allocator would keep their pages. Called and left with the lock held. */
static bool tidy(struct pool *pool)
{
    if (!pool->untidy || pool->busy > 0)
        return false;
    pool->untidy = false;
    pthread_mutex_unlock(&pool->lock);
    malloc_trim(0);
    pthread_mutex_lock(&pool->lock);
    return true;
}

/* The next request of a lane, or NULL when the pool is closed and the queue empty. */
static struct request *next_request(struct pool *pool, enum lane lane)
{
    struct queue *queue = &pool->queue[lane];
    pthread_mutex_lock(&pool->lock);
    while (!queue->head && !pool->closed) {
        if (!tidy(pool))
            pthread_cond_wait(&queue->filled, &pool->lock);
    }
    struct request *request = queue->head;
    if (request) {
        pool->busy++;
        queue->head = request->next;
        if (!queue->head)
            queue->tail = &queue->head;
    }
    pthread_mutex_unlock(&pool->lock);
    return request;
}

static void finish_request(struct pool *pool, bool large)
{
    pthread_mutex_lock(&pool->lock);
    pool->busy--;
    pool->untidy = pool->untidy || large;
    pthread_mutex_unlock(&pool->lock);
}

static void *work(void *arg)
{
    struct thread *thread = arg;
    struct request *request;
    while ((request = next_request(thread->pool, thread->lane)) != NULL) {
        bool large = request->body.bytes >= LARGE_BYTES;
        if (request->route->handle(request, thread->jobs) == OUTCOME_ANSWERED) {
            pen_http_request_drop_body(request);
            pen_http_adapter_wake(request);
        }
        finish_request(thread->pool, large);
    }
    return NULL;
}

static bool add_thread(struct pool *pool, enum lane lane, const struct pool_options *options,
                       struct pen_status *st)
{
    struct thread *thread = &pool->thread[pool->thread_count];
    *thread = (struct thread){.pool = pool, .lane = lane};
    thread->jobs = pen_jobs_open(options->store_url, options->limits, st);
    if (!thread->jobs)
        return false;
    if (pthread_create(&thread->handle, NULL, work, thread) != 0) {
        pen_jobs_close(thread->jobs);
        return pen_fail(st, PEN_UNAVAILABLE, "no thread for the store");
    }
    pool->thread_count++;
    return true;
}

struct pool *pen_http_pool_start(const struct pool_options *options, struct pen_status *st)
{
    int threads = options->store_threads + options->side_threads;
    struct pool *pool = threads <= THREADS_MAX ? calloc(1, sizeof *pool) : NULL;
    if (!pool) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for %d store threads", threads);
        return NULL;
    }
    pthread_mutex_init(&pool->lock, NULL);
    for (int lane = 0; lane < LANES; lane++) {
        pool->queue[lane].tail = &pool->queue[lane].head;
        pthread_cond_init(&pool->queue[lane].filled, NULL);
    }
    for (int i = 0; i < threads; i++) {
        if (!add_thread(pool, i < options->store_threads ? LANE_STORE : LANE_SIDE, options, st)) {
            pen_http_pool_stop(pool);
            pen_http_pool_free(pool);
            return NULL;
        }
    }
    return pool;
}

void pen_http_pool_stop(struct pool *pool)
{
    pthread_mutex_lock(&pool->lock);
    pool->closed = true;
    for (int lane = 0; lane < LANES; lane++)
        pthread_cond_broadcast(&pool->queue[lane].filled);
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < pool->thread_count; i++) {
        pthread_join(pool->thread[i].handle, NULL);
        pen_jobs_close(pool->thread[i].jobs);
    }
}

void pen_http_pool_free(struct pool *pool)
{
    if (!pool)
        return;
    for (int lane = 0; lane < LANES; lane++)
        pthread_cond_destroy(&pool->queue[lane].filled);
    pthread_mutex_destroy(&pool->lock);
    free(pool);
}

bool pen_http_pool_push(struct pool *pool, enum lane lane, struct request *request)
{
    struct queue *queue = &pool->queue[lane];
    request->next = NULL;
    pthread_mutex_lock(&pool->lock);
    bool open = !pool->closed;
    if (open) {
        *queue->tail = request;
        queue->tail = &request->next;
        pthread_cond_signal(&queue->filled);
    }
    pthread_mutex_unlock(&pool->lock);
    return open;
}
