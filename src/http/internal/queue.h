/* SPDX-License-Identifier: MIT */
/* The places of queued jobs, and how long they wait. The whole queue is read at once and kept for a
 * time that is twenty times as long as the reading took, so that it costs a twentieth of a thread
 * at most, however many jobs wait and are asked for.
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
    int64_t number;     /* 1 for the job that begins next; 0: not known */
    double eta_seconds; /* until it ends, if it and those before it take as long as the last ones
                         * that have ended, after what is left of those that run: as far as it is
                         * known, else half. 0: not known */
};

/* The place of a job when the queue was read last. It is not known if the job was not in the queue
 * then, or the queue cannot be read. */
struct queue_place pen_http_queue_place(struct queue *queue, struct pen_jobs *jobs, const char *id);

#endif
