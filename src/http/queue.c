/* SPDX-License-Identifier: MIT */
#include "http/internal/queue.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/buf.h"
#include "base/clock.h"
#include "store/store.h"

/* How long a queue is kept, in units of the time that it took to read. */
enum { KEPT_TIMES = 20 };

struct entry {
    char id[PEN_ID_BYTES];
    int64_t place;
};

struct queue {
    pthread_mutex_t lock;
    struct entry *entry;    /* guarded by lock, sorted by id */
    size_t count;           /* guarded by lock */
    struct pen_queue facts; /* guarded by lock: of the queue, without its ids */
    int64_t until_ns;       /* guarded by lock: when it has to be read again */
    bool reading;           /* guarded by lock: a thread is reading it */
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
    free(queue->entry);
    free(queue);
}

static int by_id(const void *a, const void *b)
{
    return strcmp(((const struct entry *)a)->id, ((const struct entry *)b)->id);
}

/* The entries of a queue. *count is 0 if there is no memory. Owns: the caller frees them. */
static struct entry *make_entries(const struct pen_queue *queue, size_t *count)
{
    *count = queue->ids.bytes / PEN_ID_BYTES;
    struct entry *entry = *count ? malloc(*count * sizeof *entry) : NULL;
    if (!entry)
        *count = 0;
    for (size_t i = 0; i < *count; i++) {
        memcpy(entry[i].id, queue->ids.data + i * PEN_ID_BYTES, PEN_ID_BYTES);
        entry[i].place = (int64_t)i + 1;
    }
    if (*count)
        qsort(entry, *count, sizeof *entry, by_id);
    return entry;
}

/* Called with the lock held, which is given up meanwhile: others use what was read last. */
static void read_again(struct queue *queue, struct pen_jobs *jobs)
{
    size_t count = 0;
    struct entry *entry = NULL;
    struct pen_queue read;
    struct pen_status ignored;
    queue->reading = true;
    pthread_mutex_unlock(&queue->lock);
    const int64_t begun_ns = pen_clock_ns();
    if (pen_store_queue(pen_jobs_store(jobs), &read, &ignored))
        entry = make_entries(&read, &count);
    pen_buf_release(&read.ids);
    const int64_t now_ns = pen_clock_ns();
    pthread_mutex_lock(&queue->lock);
    free(queue->entry);
    queue->entry = entry;
    queue->count = count;
    queue->facts = read;
    queue->facts.ids = (struct pen_buf){0};
    queue->until_ns = now_ns + KEPT_TIMES * (now_ns - begun_ns);
    queue->reading = false;
}

/* The jobs before a place, and the one there, take a worker's time each, once the batches in hand
 * are done. The last one takes that long, however many workers there are. */
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
    struct entry key = {.place = 0};
    strncpy(key.id, id, sizeof key.id - 1);
    pthread_mutex_lock(&queue->lock);
    if (!queue->reading && pen_clock_ns() >= queue->until_ns)
        read_again(queue, jobs);
    const struct entry *found =
        queue->count ? bsearch(&key, queue->entry, queue->count, sizeof key, by_id) : NULL;
    if (found) {
        place.number = found->place;
        place.eta_seconds = eta_seconds(&queue->facts, found->place);
    }
    pthread_mutex_unlock(&queue->lock);
    return place;
}
