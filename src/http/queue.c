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
    struct entry *entry; /* guarded by lock, sorted by id */
    size_t count;        /* guarded by lock */
    int64_t until_ns;    /* guarded by lock: when it has to be read again */
    bool reading;        /* guarded by lock: a thread is reading it */
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

/* Reads the queue. *count is 0 if that fails. Owns: the caller frees what is returned. */
static struct entry *read_entries(struct pen_jobs *jobs, size_t *count)
{
    struct pen_buf ids = {0};
    struct pen_status ignored;
    bool ok = pen_store_queue(pen_jobs_store(jobs), &ids, &ignored);
    *count = ok ? ids.bytes / PEN_ID_BYTES : 0;
    struct entry *entry = *count ? malloc(*count * sizeof *entry) : NULL;
    if (!entry)
        *count = 0;
    for (size_t i = 0; i < *count; i++) {
        memcpy(entry[i].id, ids.data + i * PEN_ID_BYTES, PEN_ID_BYTES);
        entry[i].place = (int64_t)i + 1;
    }
    pen_buf_release(&ids);
    if (*count)
        qsort(entry, *count, sizeof *entry, by_id);
    return entry;
}

/* Called with the lock held, which is given up meanwhile: others use what was read last. */
static void read_again(struct queue *queue, struct pen_jobs *jobs)
{
    size_t count;
    queue->reading = true;
    pthread_mutex_unlock(&queue->lock);
    const int64_t begun_ns = pen_clock_ns();
    struct entry *entry = read_entries(jobs, &count);
    const int64_t now_ns = pen_clock_ns();
    pthread_mutex_lock(&queue->lock);
    free(queue->entry);
    queue->entry = entry;
    queue->count = count;
    queue->until_ns = now_ns + KEPT_TIMES * (now_ns - begun_ns);
    queue->reading = false;
}

int64_t pen_http_queue_place(struct queue *queue, struct pen_jobs *jobs, const char *id)
{
    struct entry key = {.place = 0};
    strncpy(key.id, id, sizeof key.id - 1);
    pthread_mutex_lock(&queue->lock);
    if (!queue->reading && pen_clock_ns() >= queue->until_ns)
        read_again(queue, jobs);
    const struct entry *found =
        queue->count ? bsearch(&key, queue->entry, queue->count, sizeof key, by_id) : NULL;
    const int64_t place = found ? found->place : 0;
    pthread_mutex_unlock(&queue->lock);
    return place;
}
