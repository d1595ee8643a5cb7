/* SPDX-License-Identifier: MIT */
/* The queues and one lock, which is held for a few instructions at a time. */
#include "http/internal/executor.h"

#include <malloc.h>
#include <poll.h>
#include <pthread.h>
#include <stdlib.h>

#include "base/clock.h"
#include "http/internal/encoding.h"
#include "http/internal/http.h"
#include "http/internal/pictures.h"
#include "http/internal/request.h"
#include "jobs/jobs.h"

enum {
    QUEUES = QUEUE_COMPUTE + 1, /* that of QUEUE_NONE stays empty */
    STORE_THREADS = 4,
    CHANGE_THREADS = 4,
    COMPUTE_THREADS = 2,
    THREADS_MAX = 64,
    WAITING_MOST = 1024,    /* requests in a queue */
    LARGE_BYTES = 256 << 10 /* from here on a body counts as large, see trim_memory */
};
_Static_assert(QUEUE_NONE == 0 && QUEUE_STORE == 1 && QUEUE_CHANGES == 2 && QUEUE_COMPUTE == 3,
               "queues are indexed by enum queue_id");

/* A request that has waited for longer is dropped if its client has gone. */
static const int64_t patience_ns = INT64_C(1000000000);

struct queue {
    struct request *first, **last; /* guarded by lock, as the count */
    int count;
    pthread_cond_t filled;
};

struct thread {
    pthread_t handle;
    struct executor *executor;
    struct pen_jobs *jobs;
    enum queue_id id;
};

struct executor {
    pthread_mutex_t lock;
    struct queue queue[QUEUES];
    bool closed; /* guarded by lock */
    bool trim;   /* guarded by lock: a large body was handled since the last malloc_trim */
    int thread_count;
    struct thread thread[THREADS_MAX];
};

/* Returns free memory to the system when a compute thread has no more to do after a large body: the
 * body's parsed form consisted of many small blocks, and the allocator would keep their pages.
 * Called with the lock held, and releases it meanwhile. Returns whether memory was trimmed. */
static bool trim_memory(struct executor *executor, enum queue_id id)
{
    if (!executor->trim || id != QUEUE_COMPUTE)
        return false;
    executor->trim = false;
    pthread_mutex_unlock(&executor->lock);
    malloc_trim(0);
    pthread_mutex_lock(&executor->lock);
    return true;
}

/* Waits for the next request of a queue. Returns NULL once the executor is closed and the queue
 * empty. */
static struct request *next_request(struct executor *executor, enum queue_id id)
{
    struct queue *queue = &executor->queue[id];
    pthread_mutex_lock(&executor->lock);
    while (!queue->first && !executor->closed) {
        if (!trim_memory(executor, id))
            pthread_cond_wait(&queue->filled, &executor->lock);
    }
    struct request *request = queue->first;
    if (request) {
        queue->first = request->next;
        queue->count--;
        if (!queue->first)
            queue->last = &queue->first;
        executor->trim = executor->trim || request->body.bytes >= LARGE_BYTES;
    }
    pthread_mutex_unlock(&executor->lock);
    return request;
}

/* Whether nothing comes of the request but an answer for which nobody waits any more. A client that
 * has ended its side alone looks the same, so this counts only after a wait. */
static bool is_unwanted(const struct request *request)
{
    struct pollfd client = {.fd = request->fd, .events = POLLRDHUP};
    return pen_http_request_only_answers(request) && !request->job_id[0] &&
           pen_clock_ns() - request->queued_ns > patience_ns && poll(&client, 1, 0) > 0;
}

/* Runs the handler, and answers 503 instead if there is no memory for the answer. */
static void run(struct request *request, struct pen_jobs *jobs)
{
    struct pen_status st;
    if (is_unwanted(request))
        request->gone = true;
    else if (pen_http_request_decode(request) &&
             request->route->handle(request, jobs) == OUTCOME_WATCHED)
        return;
    if (!pen_http_pictures_count(request->http->pictures, request->reply.body, &st))
        pen_http_request_fail(request, &st);
    pen_http_request_encode(request);
    pen_http_request_drop_body(request);
    pen_http_resume(request);
}

static void *work(void *arg)
{
    struct thread *thread = arg;
    struct request *request;
    while ((request = next_request(thread->executor, thread->id)) != NULL)
        run(request, thread->jobs);
    return NULL;
}

static bool add_thread(struct executor *executor, enum queue_id id, const char *store_url,
                       const struct pen_limits *limits, struct pen_status *st)
{
    struct thread *thread = &executor->thread[executor->thread_count];
    *thread = (struct thread){.executor = executor, .id = id};
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
                                         int store_threads, struct pen_status *st)
{
    const int count[QUEUES] = {[QUEUE_STORE] = store_threads > 0 ? store_threads : STORE_THREADS,
                               [QUEUE_CHANGES] = CHANGE_THREADS,
                               [QUEUE_COMPUTE] = COMPUTE_THREADS};
    struct executor *executor =
        count[QUEUE_STORE] <= THREADS_MAX / 2 ? calloc(1, sizeof *executor) : NULL;
    if (!executor) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the request threads");
        return NULL;
    }
    pthread_mutex_init(&executor->lock, NULL);
    for (int id = 0; id < QUEUES; id++) {
        executor->queue[id].last = &executor->queue[id].first;
        pthread_cond_init(&executor->queue[id].filled, NULL);
    }
    bool ok = true;
    for (int id = QUEUE_STORE; ok && id < QUEUES; id++) {
        for (int i = 0; ok && i < count[id]; i++)
            ok = add_thread(executor, (enum queue_id)id, store_url, limits, st);
    }
    if (!ok) {
        pen_http_executor_stop(executor);
        pen_http_executor_free(executor);
        return NULL;
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

bool pen_http_executor_submit(struct executor *executor, enum queue_id id, struct request *request)
{
    struct queue *queue = &executor->queue[id];
    request->queued_ns = pen_clock_ns();
    request->next = NULL;
    pthread_mutex_lock(&executor->lock);
    const bool taken = !executor->closed && queue->count < WAITING_MOST;
    if (taken) {
        *queue->last = request;
        queue->last = &request->next;
        queue->count++;
        pthread_cond_signal(&queue->filled);
    }
    pthread_mutex_unlock(&executor->lock);
    return taken;
}

void pen_http_executor_refuse(struct executor *executor, struct request *request)
{
    struct pen_status st;
    pthread_mutex_lock(&executor->lock);
    const bool closed = executor->closed;
    pthread_mutex_unlock(&executor->lock);
    pen_fail(&st, PEN_UNAVAILABLE, "%s",
             closed ? "the daemon is stopping"
                    : "too many requests like this one wait; try again later");
    pen_http_request_fail(request, &st);
}
