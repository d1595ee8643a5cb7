/* SPDX-License-Identifier: MIT */
/* The queues and one lock, which is held for a few instructions at a time; longer only where a
 * queue by turns chooses among some hundred requests. */
#include "http/internal/executor.h"

#include <malloc.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "http/internal/answers.h"
#include "http/internal/encoding.h"
#include "http/internal/http.h"
#include "http/internal/loop.h"
#include "http/internal/request.h"
#include "http/internal/waiting.h"
#include "jobs/jobs.h"

enum {
    QUEUES = QUEUE_LARGE + 1, /* that of QUEUE_NONE stays empty */
    THREADS_MAX = 64,
    LARGE_BYTES = 256 << 10,      /* from here on a body counts as large, see trim_memory */
    ENCODED_ANYWHERE = 64 << 10,  /* answers up to here are compressed where they are made */
    ENCODED_BY_COMPUTE = 4 << 20, /* and these by a compute thread; it takes up to 0.1 s */
    GROWN_BYTES = 64 << 20,       /* bodies in memory, up to which decoded ones may wait again */
    WAITING_LEAST = 64            /* new requests that may wait in any queue, however few
                                   * connections there are, and no more in QUEUE_LARGE */
};
_Static_assert(QUEUE_NONE == 0 && QUEUE_STORE == 1 && QUEUE_CHANGES == 2 && QUEUE_SUBMIT == 3 &&
                   QUEUE_LISTS == 4 && QUEUE_COMPUTE == 5 && QUEUE_INTAKE == 6 && QUEUE_LARGE == 7,
               "queues are indexed by enum queue_id");

/* One part in so many of the connections is how many new requests may wait in a queue. Together
 * they leave connections to others, however slow the threads are. */
static const int waiting_part[QUEUES] = {
    [QUEUE_STORE] = 4, [QUEUE_CHANGES] = 16, [QUEUE_SUBMIT] = 8,
    [QUEUE_LISTS] = 8, [QUEUE_COMPUTE] = 8,  [QUEUE_INTAKE] = 8};

struct queue {
    struct waiting waiting; /* guarded by lock */
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
static struct request *next_request(struct executor *executor, enum queue_id id, bool *oldest)
{
    struct queue *queue = &executor->queue[id];
    struct request *request;
    pthread_mutex_lock(&executor->lock);
    while (!(request = pen_http_waiting_take(&queue->waiting, oldest)) && !executor->closed) {
        if (!trim_memory(executor, id))
            pthread_cond_wait(&queue->filled, &executor->lock);
    }
    pthread_mutex_unlock(&executor->lock);
    return request;
}

static void finish_request(struct executor *executor, enum queue_id id, bool oldest, int64_t ns,
                           bool large)
{
    pthread_mutex_lock(&executor->lock);
    executor->trim = executor->trim || large;
    pen_http_waiting_spent(&executor->queue[id].waiting, oldest, ns);
    pthread_mutex_unlock(&executor->lock);
}

/* Whether nobody waits for the answer, and nothing else comes of the request. */
static bool is_unwanted(const struct request *request)
{
    return pen_http_request_only_answers(request) &&
           !(request->route->only_answers && request->job_id[0]) &&
           atomic_load_explicit(&request->unwanted, memory_order_relaxed);
}

static void answer_unavailable(struct request *request, const char *why)
{
    struct pen_status st;
    pen_fail(&st, PEN_UNAVAILABLE, "%s", why);
    pen_http_request_fail(request, &st);
}

/* Whether a body has turned out to be larger than was known: it had several members. Then it has
 * another place in the queue, unless such bodies take too much memory. */
static bool has_grown(struct request *request)
{
    const size_t known = request->work_bytes;
    request->work_bytes = request->body.bytes;
    return request->body.bytes > known &&
           atomic_load_explicit(&request->http->intake_bytes, memory_order_relaxed) < GROWN_BYTES;
}

/* Decodes the body, and runs the handler. Returns the queue to which the request goes on, or
 * QUEUE_NONE if this thread is done with it; *outcome is then set. */
static enum queue_id handle(struct request *request, struct thread *thread, enum outcome *outcome)
{
    *outcome = OUTCOME_ANSWERED;
    if (request->is_handled)
        return QUEUE_NONE;
    if (thread->id == QUEUE_LARGE &&
        atomic_load_explicit(&request->http->stopping, memory_order_relaxed)) {
        answer_unavailable(request, "the daemon is stopping");
        return QUEUE_NONE;
    }
    if (is_unwanted(request)) {
        answer_unavailable(request, "the client has gone");
        return QUEUE_NONE;
    }
    if (pen_http_request_decode(request)) {
        if (thread->id == QUEUE_INTAKE && has_grown(request))
            return QUEUE_INTAKE;
        *outcome = request->route->handle(request, thread->jobs);
    }
    if (*outcome == OUTCOME_MOVED)
        return request->queue;
    if (*outcome == OUTCOME_ANSWERED) {
        pen_http_answers_count(request);
        pen_http_request_drop_body(request);
        request->is_handled = true;
        request->work_bytes = request->reply.bytes;
        return pen_http_executor_encodes(request, thread->id);
    }
    return QUEUE_NONE;
}

/* Gives a request on to another queue. Returns false if it is answered now: the executor is
 * closed, or the queue is full of such as this one. */
static bool pass_on(struct request *request, struct executor *executor, enum queue_id to)
{
    const bool handled = request->is_handled;
    if (pen_http_executor_submit(executor, to, !handled && to != QUEUE_INTAKE, request))
        return true;
    if (!handled)
        pen_http_executor_refuse(executor, request);
    return false;
}

static void run(struct request *request, struct thread *thread)
{
    enum outcome outcome;
    const enum queue_id to = handle(request, thread, &outcome);
    if (to != QUEUE_NONE && pass_on(request, thread->executor, to))
        return;
    if (outcome == OUTCOME_WATCHED)
        return;
    if (to == QUEUE_NONE && !atomic_load_explicit(&request->unwanted, memory_order_relaxed))
        pen_http_request_encode(request);
    pen_http_request_drop_body(request);
    pen_http_resume(request);
}

static void *work(void *arg)
{
    struct thread *thread = arg;
    struct request *request;
    bool oldest = false;
    while ((request = next_request(thread->executor, thread->id, &oldest)) != NULL) {
        const bool large = request->work_bytes >= LARGE_BYTES;
        const int64_t begun_ns = pen_clock_ns();
        run(request, thread);
        finish_request(thread->executor, thread->id, oldest, pen_clock_ns() - begun_ns, large);
    }
    return NULL;
}

enum queue_id pen_http_executor_encodes(const struct request *request, enum queue_id here)
{
    const size_t bytes = pen_http_request_encodes(request);
    if (bytes <= ENCODED_ANYWHERE || here == QUEUE_LARGE)
        return QUEUE_NONE;
    if (bytes > ENCODED_BY_COMPUTE)
        return QUEUE_LARGE;
    return here == QUEUE_COMPUTE ? QUEUE_NONE : QUEUE_COMPUTE;
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
                               [QUEUE_CHANGES] = 1,
                               [QUEUE_SUBMIT] = options->submit_threads,
                               [QUEUE_LISTS] = options->list_threads,
                               [QUEUE_COMPUTE] = options->compute_threads,
                               [QUEUE_INTAKE] = options->intake_threads,
                               [QUEUE_LARGE] = 1};
    int threads = 0;
    for (int id = 0; id < QUEUES; id++)
        threads += count[id];
    struct executor *executor = threads <= THREADS_MAX ? calloc(1, sizeof *executor) : NULL;
    if (!executor) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for %d request threads", threads);
        return NULL;
    }
    pthread_mutex_init(&executor->lock, NULL);
    for (int id = 0; id < QUEUES; id++) {
        pen_http_waiting_init(&executor->queue[id].waiting, id != QUEUE_STORE);
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

/* How many new requests may wait in a queue. */
static int waiting_max(const struct pen_http *http, enum queue_id id)
{
    const int part = waiting_part[id] > 0 ? http->connection_max / waiting_part[id] : 0;
    return part > WAITING_LEAST ? part : WAITING_LEAST;
}

bool pen_http_executor_submit(struct executor *executor, enum queue_id id, bool is_new,
                              struct request *request)
{
    struct queue *queue = &executor->queue[id];
    if (request->work_bytes == 0)
        request->work_bytes =
            request->is_handled ? request->reply.bytes : pen_http_request_work(request);
    pthread_mutex_lock(&executor->lock);
    const bool taken =
        !executor->closed && (!is_new || queue->waiting.count < waiting_max(request->http, id));
    if (taken) {
        request->queue = id;
        pen_http_waiting_add(&queue->waiting, request);
        pthread_cond_signal(&queue->filled);
    }
    pthread_mutex_unlock(&executor->lock);
    return taken;
}

void pen_http_executor_refuse(struct executor *executor, struct request *request)
{
    pthread_mutex_lock(&executor->lock);
    const bool closed = executor->closed;
    pthread_mutex_unlock(&executor->lock);
    answer_unavailable(request, closed ? "the daemon is stopping"
                                       : "too many requests like this one wait; try again later");
}
