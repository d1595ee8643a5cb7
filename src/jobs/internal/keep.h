/* SPDX-License-Identifier: MIT */
/* When a batch that takes long keeps its state in the store, so that a worker that ends loses
 * little of it, and when it gives way to a batch that comes first: once its state is kept.
 *
 * A state is kept no more often than asked, and not for more than a twentieth of the time. After a
 * try that fails the next one waits: half a second, a second, two, and so on to a minute. */
#ifndef PEN_JOBS_INTERNAL_KEEP_H
#define PEN_JOBS_INTERNAL_KEEP_H

#include "jobs/internal/batch_context.h"

struct pen_keeper {
    struct pen_batch_context *context;
    int64_t wait_ms;           /* the shortest time between two states */
    int times;                 /* and how many times as long as keeping one takes */
    int64_t ask_ms;            /* the shortest time between questions for a higher priority */
    int64_t asked_ns;          /* when it was last asked whether a batch that comes first waits */
    bool outranked;            /* one does */
    int64_t tried_ns, took_ns; /* when keeping it was last tried, and how long that took */
    int64_t retry_ms; /* how long the next try waits, since the last one has failed; else 0 */
};

/* Both times are those of the kind of batch; the worker's options may have another `wait_ms`
 * (keep_ms). */
struct pen_keeper pen_keeper_make(struct pen_batch_context *context, int64_t wait_ms,
                                  int64_t ask_ms);

/* Whether the state is to be kept now: its time has come, or a batch that comes first waits. */
bool pen_keeper_is_due(struct pen_keeper *keeper);

/* Keeps the state, which the caller has begun to make at `begun_ns`; NULL: there was no memory to
 * make it. Returns whether it is kept. A failure may be ignored: the next time may succeed, and the
 * heartbeat notices a lost lease. *gives_way: the batch is to be given back now. */
bool pen_keeper_keep(struct pen_keeper *keeper, const struct pen_kept *kept, int64_t begun_ns,
                     bool *gives_way);

#endif
