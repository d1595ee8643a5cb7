/* SPDX-License-Identifier: MIT */
/* The queues, with one lock, which is held for a few instructions at a time. */
#include "http/internal/executor.h"

#include <malloc.h>
#include <pthread.h>
#include <stdlib.h>

#include "http/internal/encoding.h"
#include "http/internal/http.h"
#include "http/internal/pictures.h"
#include "http/internal/request.h"
#include "jobs/jobs.h"

enum {
    QUEUES = QUEUE_COMPUTE + 1, /* the queue of QUEUE_NONE stays empty */
    THREADS = 10,
    WAITING_MOST = 1024, /* most requests in a queue */
    LARGE_BYTES = 1 << 20
};

/* The queue of each thread. */
static const enum queue_id queue_of[THREADS] = {
    QUEUE_STORE,   QUEUE_STORE,   QUEUE_STORE,   QUEUE_STORE,   QUEUE_CHANGES,
    QUEUE_CHANGES, QUEUE_CHANGES, QUEUE_CHANGES, QUEUE_COMPUTE, QUEUE_COMPUTE};

struct queue {
    struct request *first, **last; /* guarded by lock, as is the count */
    int count;
    pthread_cond_t filled;
};

struct thread {
    pthread_t handle;
    struct executor *executor;
    struct queue *queue;
    struct pen_jobs *jobs;
};

struct executor {
    pthread_mutex_t lock;
    struct queue queue[QUEUES];
    bool closed;      /* guarded by lock */
    int thread_count; /* number of started threads */
    struct thread thread[THREADS];
};

/* Waits for the next request of a queue. Returns NULL when the executor is closed and the queue is
 * empty. */
static struct request *next_request(struct executor *executor, struct queue *queue)
{
    pthread_mutex_lock(&executor->lock);
    while (!queue->first && !executor->closed)
        pthread_cond_wait(&queue->filled, &executor->lock);
    struct request *request = queue->first;
    if (request) {
        queue->first = request->next;
        queue->count--;
        if (!queue->first)
            queue->last = &queue->first;
    }
    pthread_mutex_unlock(&executor->lock);
    return request;
}

/* Runs the handler. Answers 503 if there is no memory for the answer. */
static void run(struct request *request, struct pen_jobs *jobs)
{
    struct pen_http *http = request->http;
    struct pen_status st;
    const bool large = request->body.bytes >= LARGE_BYTES;
    if (pen_http_request_decode(request) &&
        request->route->handle(request, jobs) == OUTCOME_WATCHED)
        return;
    pen_http_request_encode(request);
    if (!pen_http_pictures_count(http->pictures, request->reply.body, &st))
        pen_http_request_fail(request, &st);
    pen_http_request_drop_body(request);
    pen_http_resume(request);
    pen_http_check_store(http, jobs);
    if (large)
        malloc_trim(0); /* returns the pages of a parsed body, which is many small blocks */
}

static void *work(void *arg)
{
    struct thread *thread = arg;
    struct request *request;
    while ((request = next_request(thread->executor, thread->queue)) != NULL)
        run(request, thread->jobs);
    return NULL;
}

static bool add_thread(struct executor *executor, const char *store_url,
                       const struct pen_limits *limits, struct pen_status *st)
{
    struct thread *thread = &executor->thread[executor->thread_count];
    thread->executor = executor;
    thread->queue = &executor->queue[queue_of[executor->thread_count]];
    thread->jobs = pen_jobs_open(store_url, limits, st);
    if (!thread->jobs)
        return false;
    if (pthread_create(&thread->handle, NULL, work, thread) != 0) {
        pen_jobs_close(thread->jobs);
        return pen_fail(st, PEN_UNAVAILABLE, "a request thread cannot be started");
    }
    executor->thread_count++;
    return true;
}

struct executor *pen_http_executor_start(const char *store_url, const struct pen_limits *limits,
                                         struct pen_status *st)
{
    struct executor *executor = calloc(1, sizeof *executor);
    if (!executor) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the request threads");
        return NULL;
    }
    pthread_mutex_init(&executor->lock, NULL);
    for (int id = 0; id < QUEUES; id++) {
        executor->queue[id].last = &executor->queue[id].first;
        pthread_cond_init(&executor->queue[id].filled, NULL);
    }
    while (executor->thread_count < THREADS) {
        if (!add_thread(executor, store_url, limits, st)) {
            pen_http_executor_stop(executor);
            pen_http_executor_free(executor);
            return NULL;
        }
    }
    return executor;
}

void pen_http_executor_stop(struct executor *executor)
{
    if (!executor)
        return;
    pthread_mutex_lock(&executor->lock);
    executor->closed = true;
    for (int id = 0; id < QUEUES; id++)
        pthread_cond_broadcast(&executor->queue[id].filled);
    pthread_mutex_unlock(&executor->lock);
    for (int i = 0; i < executor->thread_count; i++) {
        pthread_join(executor->thread[i].handle, NULL);
        pen_jobs_close(executor->thread[i].jobs);
    }
}

void pen_http_executor_free(struct executor *executor)
{
    if (!executor)
        return;
    for (int id = 0; id < QUEUES; id++)
        pthread_cond_destroy(&executor->queue[id].filled);
    pthread_mutex_destroy(&executor->lock);
    free(executor);
}

/* Adds a request to a queue. Returns NULL, or the reason for a refusal. */
static const char *enqueue(struct executor *executor, struct queue *queue, struct request *request)
{
    if (executor->closed)
        return "the daemon is stopping";
    if (queue->count == WAITING_MOST)
        return "too many requests like this one wait; try again later";
    request->next = NULL;
    *queue->last = request;
    queue->last = &request->next;
    queue->count++;
    pthread_cond_signal(&queue->filled);
    return NULL;
}

void pen_http_executor_submit(struct executor *executor, enum queue_id id, struct request *request)
{
    struct pen_status st;
    pthread_mutex_lock(&executor->lock);
    const char *refusal = enqueue(executor, &executor->queue[id], request);
    pthread_mutex_unlock(&executor->lock);
    if (!refusal)
        return;
    pen_fail(&st, PEN_UNAVAILABLE, "%s", refusal);
    pen_http_request_fail(request, &st);
    pen_http_resume(request);
}
