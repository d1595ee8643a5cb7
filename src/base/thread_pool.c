/* SPDX-License-Identifier: MIT */
/* Threads sleep until a run begins, and take part in it if their index is below the run's number of
 * threads. The run ends under the lock, so its caller sees everything that the threads wrote. */
#include "base/thread_pool.h"

#include <fenv.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/cpu.h"

struct thread {
    pthread_t id;
    struct pen_thread_pool *pool;
    int index;
    int64_t mark_ns; /* its processor time at the last pen_thread_pool_mark */
};

struct pen_thread_pool {
    int count; /* threads started; fixed once pen_thread_pool_new has returned */
    struct thread *threads;
    pthread_mutex_t lock;
    pthread_cond_t wake; /* a run has begun, or `stop` is set */
    pthread_cond_t idle; /* busy has become 0 */
    /* Guarded by lock. */
    bool stop;
    unsigned run;      /* number of runs begun */
    int active;        /* threads that take part in the run */
    int busy;          /* of these, the number that have not returned from `work` */
    int changed_state; /* of these, the number with a floating-point state that is not the default
                        */
    pen_thread_pool_work *work;
    void *user;
};

/* Waits for the next run in which this thread takes part. Returns false when the pool ends. */
static bool next_run(struct thread *thread, unsigned *seen)
{
    struct pen_thread_pool *pool = thread->pool;
    while (!pool->stop) {
        if (*seen != pool->run) {
            *seen = pool->run;
            if (thread->index < pool->active)
                return true;
            continue;
        }
        pthread_cond_wait(&pool->wake, &pool->lock);
    }
    return false;
}

static void *thread_main(void *argument)
{
    struct thread *thread = argument;
    struct pen_thread_pool *pool = thread->pool;
    unsigned seen = 0;
    pthread_mutex_lock(&pool->lock);
    while (next_run(thread, &seen)) {
        pthread_mutex_unlock(&pool->lock);
        /* A thread inherits its creator's floating-point state, and a library may have changed it
         * since. Subnormals flushed to zero or other rounding would give other results. */
        bool changed_state = !pen_float_is_default();
        fesetenv(FE_DFL_ENV);
        pool->work(pool->user, thread->index);
        changed_state = changed_state || !pen_float_is_default();
        pthread_mutex_lock(&pool->lock);
        pool->changed_state += changed_state;
        if (--pool->busy == 0)
            pthread_cond_signal(&pool->idle);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

static bool start_threads(struct pen_thread_pool *pool, int threads, struct pen_status *st)
{
    for (int i = 0; i < threads; i++) {
        struct thread *thread = &pool->threads[i];
        *thread = (struct thread){.pool = pool, .index = i};
        int error = pthread_create(&thread->id, NULL, thread_main, thread);
        if (error)
            return pen_fail(st, PEN_NO_MEMORY, "cannot start thread %d of %d: %s", i + 1, threads,
                            strerror(error));
        pool->count++;
    }
    return true;
}

struct pen_thread_pool *pen_thread_pool_new(int threads, struct pen_status *st)
{
    if (threads <= 0)
        threads = pen_cpu_count();
    struct pen_thread_pool *pool = calloc(1, sizeof *pool);
    if (pool)
        pool->threads = calloc((size_t)threads, sizeof *pool->threads);
    if (!pool || !pool->threads) {
        free(pool);
        pen_fail(st, PEN_NO_MEMORY, "out of memory for a pool of %d threads", threads);
        return NULL;
    }
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->idle, NULL);
    if (start_threads(pool, threads, st))
        return pool;
    pen_thread_pool_free(pool);
    return NULL;
}

void pen_thread_pool_free(struct pen_thread_pool *pool)
{
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    pool->stop = true;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < pool->count; i++)
        pthread_join(pool->threads[i].id, NULL);
    pthread_cond_destroy(&pool->idle);
    pthread_cond_destroy(&pool->wake);
    pthread_mutex_destroy(&pool->lock);
    free(pool->threads);
    free(pool);
}

int pen_thread_pool_size(const struct pen_thread_pool *pool)
{
    return pool->count;
}

static int64_t used_ns(const struct thread *thread)
{
    clockid_t clock;
    struct timespec used = {0};
    if (pthread_getcpuclockid(thread->id, &clock) == 0)
        clock_gettime(clock, &used);
    return (int64_t)used.tv_sec * 1000000000 + used.tv_nsec;
}

void pen_thread_pool_mark(struct pen_thread_pool *pool)
{
    for (int i = 0; i < pool->count; i++)
        pool->threads[i].mark_ns = used_ns(&pool->threads[i]);
}

int64_t pen_thread_pool_most_ns(const struct pen_thread_pool *pool)
{
    int64_t most = 0;
    for (int i = 0; i < pool->count; i++) {
        const int64_t ns = used_ns(&pool->threads[i]) - pool->threads[i].mark_ns;
        most = ns > most ? ns : most;
    }
    return most;
}

int pen_thread_pool_run(struct pen_thread_pool *pool, int threads, pen_thread_pool_work *work,
                        void *user)
{
    pthread_mutex_lock(&pool->lock);
    pool->work = work;
    pool->user = user;
    pool->active = pool->busy = threads;
    pool->changed_state = 0;
    pool->run++;
    pthread_cond_broadcast(&pool->wake);
    while (pool->busy > 0)
        pthread_cond_wait(&pool->idle, &pool->lock);
    int changed_state = pool->changed_state;
    pthread_mutex_unlock(&pool->lock);
    return changed_state;
}
