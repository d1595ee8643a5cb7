/* SPDX-License-Identifier: MIT */
/* The queues and one lock, which is held for a few instructions at a time. */
#include "http/internal/executor.h"

#include <malloc.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "http/internal/encoding.h"
#include "http/internal/http.h"
#include "http/internal/loop.h"
#include "http/internal/request.h"
#include "jobs/jobs.h"

enum {
    QUEUES = QUEUE_INTAKE + 1, /* that of QUEUE_NONE stays empty */
    THREADS_MAX = 64,
    LARGE_BYTES = 256 << 10, /* from here on a body counts as large, see trim_memory */
    LARGE_ANSWER = 64 << 10, /* from here on an answer counts for ANSWER_BYTES */
    ANSWER_BYTES = 96 << 20  /* the most of such answers in memory, but pictures */
};
_Static_assert(QUEUE_NONE == 0 && QUEUE_STORE == 1 && QUEUE_COMPUTE == 2 && QUEUE_INTAKE == 3,
               "queues are indexed by enum queue_id");

struct queue {
    struct request *head, **tail; /* guarded by lock */
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

/* Returns free memory to the system when an intake thread has no more to do after a large body: the
 * body's parsed form consisted of many small blocks, and the allocator would keep their pages. The
 * other threads do not do it, as it takes a while. Called with the lock held, and releases it
 * meanwhile. Returns whether memory was trimmed. */
static bool trim_memory(struct executor *executor, enum queue_id id)
{
    if (!executor->trim || id != QUEUE_INTAKE)
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
    while (!queue->head && !executor->closed) {
        if (!trim_memory(executor, id))
            pthread_cond_wait(&queue->filled, &executor->lock);
    }
    struct request *request = queue->head;
    if (request) {
        queue->head = request->next;
        if (!queue->head)
            queue->tail = &queue->head;
    }
    pthread_mutex_unlock(&executor->lock);
    return request;
}

static void finish_request(struct executor *executor, bool large)
{
    pthread_mutex_lock(&executor->lock);
    executor->trim = executor->trim || large;
    pthread_mutex_unlock(&executor->lock);
}

/* Whether nobody waits for the answer, and nothing else comes of the request. */
static bool is_unwanted(const struct request *request)
{
    return (request->head || strcmp(request->method, "GET") == 0) &&
           atomic_load_explicit(&request->unwanted, memory_order_relaxed);
}

/* Answers 503 if the large answers in memory, which wait for their readers, are too many. */
static void count_answer(struct request *request)
{
    struct blob *body = request->reply.body;
    struct pen_status st;
    if (!body || body->total || body->content.bytes < LARGE_ANSWER || atomic_load(&body->refs) > 1)
        return;
    pen_http_blob_count(body, &request->http->answer_bytes);
    if (atomic_load_explicit(&request->http->answer_bytes, memory_order_relaxed) <= ANSWER_BYTES)
        return;
    pen_http_reply_release(&request->reply);
    pen_fail(&st, PEN_UNAVAILABLE,
             "too many large answers wait for their readers; try again later");
    pen_http_request_fail(request, &st);
}

/* Decodes the body, and runs the handler. */
static enum outcome handle(struct request *request, struct pen_jobs *jobs)
{
    enum outcome outcome = OUTCOME_ANSWERED;
    struct pen_status st;
    if (is_unwanted(request)) {
        pen_fail(&st, PEN_UNAVAILABLE, "the client has gone");
        pen_http_request_fail(request, &st);
        return outcome;
    }
    if (pen_http_request_decode(request))
        outcome = request->route->handle(request, jobs);
    if (outcome == OUTCOME_ANSWERED) {
        pen_http_request_encode(request);
        count_answer(request);
    }
    return outcome;
}

static void *work(void *arg)
{
    struct thread *thread = arg;
    struct request *request;
    while ((request = next_request(thread->executor, thread->id)) != NULL) {
        bool large = request->body.bytes >= LARGE_BYTES;
        if (handle(request, thread->jobs) == OUTCOME_ANSWERED) {
            pen_http_request_drop_body(request);
            pen_http_resume(request);
        }
        finish_request(thread->executor, large);
    }
    return NULL;
}

static bool add_thread(struct executor *executor, enum queue_id id,
                       const struct executor_options *options, struct pen_status *st)
{
    struct thread *thread = &executor->thread[executor->thread_count];
    *thread = (struct thread){.executor = executor, .id = id};
    thread->jobs = pen_jobs_open(options->store_url, options->limits, st);
    if (!thread->jobs)
        return false;
    if (pthread_create(&thread->handle, NULL, work, thread) != 0) {
        pen_jobs_close(thread->jobs);
        return pen_fail(st, PEN_UNAVAILABLE, "a request thread cannot be started");
    }
    executor->thread_count++;
    return true;
}

struct executor *pen_http_executor_start(const struct executor_options *options,
                                         struct pen_status *st)
{
    const int count[QUEUES] = {[QUEUE_STORE] = options->store_threads,
                               [QUEUE_COMPUTE] = options->compute_threads,
                               [QUEUE_INTAKE] = options->intake_threads};
    int threads = count[QUEUE_STORE] + count[QUEUE_COMPUTE] + count[QUEUE_INTAKE];
    struct executor *executor = threads <= THREADS_MAX ? calloc(1, sizeof *executor) : NULL;
    if (!executor) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for %d request threads", threads);
        return NULL;
    }
    pthread_mutex_init(&executor->lock, NULL);
    for (int id = 0; id < QUEUES; id++) {
        executor->queue[id].tail = &executor->queue[id].head;
        pthread_cond_init(&executor->queue[id].filled, NULL);
    }
    bool ok = true;
    for (int id = QUEUE_STORE; ok && id < QUEUES; id++) {
        for (int i = 0; ok && i < count[id]; i++)
            ok = add_thread(executor, (enum queue_id)id, options, st);
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
    request->next = NULL;
    pthread_mutex_lock(&executor->lock);
    bool open = !executor->closed;
    if (open) {
        *queue->tail = request;
        queue->tail = &request->next;
        pthread_cond_signal(&queue->filled);
    }
    pthread_mutex_unlock(&executor->lock);
    return open;
}
