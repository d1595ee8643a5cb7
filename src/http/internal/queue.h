/* SPDX-License-Identifier: MIT */
/* The places of queued jobs. The whole queue is read at once and kept for a time that is twenty
 * times as long as the reading took, so that it costs a twentieth of a thread at most, however many
 * jobs wait and are asked for.
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

/* The place of a job when the queue was read last: 1 for the one that begins next, 0 if it was not
 * in the queue then, or the queue cannot be read. */
int64_t pen_http_queue_place(struct queue *queue, struct pen_jobs *jobs, const char *id);

#endif
