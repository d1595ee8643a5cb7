/* SPDX-License-Identifier: MIT */
#include "http/internal/queue.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/buf.h"
#include "base/clock.h"
#include "store/store.h"

/* How long a queue is kept, in units of its reading time. */
enum { KEPT_TIMES = 20 };

struct queue {
    pthread_mutex_t lock;
    struct pen_queue last; /* guarded by lock: the queue at the last reading */
    int64_t until_ns;      /* guarded by lock: the time of the next reading */
    bool reading;          /* guarded by lock: a thread is reading it */
};

struct queue *pen_http_queue_new(void)
{
    struct queue *queue = calloc(1, sizeof *queue);
    if (queue)
        pthread_mutex_init(&queue->lock, NULL);
    return queue;
}

void pen_http_queue_free(struct queue *queue)
{
    if (!queue)
        return;
    pthread_mutex_destroy(&queue->lock);
    pen_buf_release(&queue->last.ids);
    free(queue);
}

/* Reads the queue again. Called with the lock held, which is released meanwhile, so that other
 * threads use the last reading. */
static void read_again(struct queue *queue, struct pen_jobs *jobs)
{
    struct pen_queue read;
    struct pen_status ignored;
    queue->reading = true;
    pthread_mutex_unlock(&queue->lock);
    const int64_t begun_ns = pen_clock_ns();
    if (!pen_store_queue(pen_jobs_store(jobs), &read, &ignored))
        pen_buf_release(&read.ids);
    const int64_t now_ns = pen_clock_ns();
    pthread_mutex_lock(&queue->lock);
    pen_buf_release(&queue->last.ids);
    queue->last = read;
    queue->until_ns = now_ns + KEPT_TIMES * (now_ns - begun_ns);
    queue->reading = false;
}

/* The expected time until the job at a place ends. After the batches in progress, the jobs up to
 * this place take a worker's time each. The last job takes that long for any number of workers. */
static double eta_seconds(const struct pen_queue *queue, int64_t place)
{
    if (queue->workers == 0 || queue->job_us == 0)
        return 0;
    const double turns = (double)place / (double)queue->workers;
    const double hand_us = (double)queue->hand_us / (double)queue->workers;
    return ((turns < 1 ? 1 : turns) * (double)queue->job_us + hand_us) * 1e-6;
}

struct queue_place pen_http_queue_place(struct queue *queue, struct pen_jobs *jobs, const char *id)
{
    struct queue_place place = {0};
    pthread_mutex_lock(&queue->lock);
    if (!queue->reading && pen_clock_ns() >= queue->until_ns)
        read_again(queue, jobs);
    const struct pen_buf *ids = &queue->last.ids;
    for (size_t at = 0; at < ids->bytes && place.number == 0; at += PEN_ID_BYTES) {
        if (strcmp((const char *)ids->data + at, id) == 0)
            place.number = (int64_t)(at / PEN_ID_BYTES) + 1;
    }
    if (place.number > 0)
        place.eta_seconds = eta_seconds(&queue->last, place.number);
    pthread_mutex_unlock(&queue->lock);
    return place;
}
