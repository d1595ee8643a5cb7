/* SPDX-License-Identifier: MIT */
/* The places of queued jobs, and their waiting times. The front of the queue is read as a whole,
 * and kept for twenty times as long as the reading took. So reading takes at most a twentieth of a
 * thread, for any number of requests.
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
    int64_t number; /* 1 for the job that begins next; 0: unknown */
    /* The time until the job ends. First the running jobs end, then the queued jobs up to this one.
     * Each of these takes the mean time of the jobs that ended last. 0: unknown. */
    double eta_seconds;
};

/* The place of a job when the queue was read last. It is unknown if the job was not in the queue
 * then, or if the queue cannot be read. */
struct queue_place pen_http_queue_place(struct queue *queue, struct pen_jobs *jobs, const char *id);

#endif
