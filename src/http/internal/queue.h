/* SPDX-License-Identifier: MIT */
/* The places of queued jobs, and how long they wait. The front of the queue is read at once. It is
 * kept for twenty times as long as the reading took. So reading takes a twentieth of a thread at
 * most, however many requests ask for places.
 *
 * Threads: any. */
#ifndef PEN_HTTP_INTERNAL_QUEUE_H
#define PEN_HTTP_INTERNAL_QUEUE_H

#include <stdint.h>

#include "jobs/jobs.h"

struct queue;

/* Fails: NULL when out of memory. */
struct queue *pen_http_queue_new(void);
void pen_http_queue_free(struct queue *queue); /* NULL is allowed */

struct queue_place {
    int64_t number; /* 1 for the job that begins next; 0: not known */
    /* The time until the job ends: first the rest of the running jobs, then the queued ones up to
     * this one, each as long as the mean of the jobs that ended last. 0: not known. */
    double eta_seconds;
};

/* The place of a job when the queue was read last. It is not known if the job was not in the queue
 * then, or the queue cannot be read. */
struct queue_place pen_http_queue_place(struct queue *queue, struct pen_jobs *jobs, const char *id);

#endif
