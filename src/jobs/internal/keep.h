/* SPDX-License-Identifier: MIT */
/* When a batch that takes long keeps its state in the store, so that a worker that ends loses
 * little of it, and when it gives way to a batch of higher priority: only once its state is kept.
 *
 * A state is kept no more often than asked, and not for more than a twentieth of the time. */
#ifndef PEN_JOBS_INTERNAL_KEEP_H
#define PEN_JOBS_INTERNAL_KEEP_H

#include "jobs/internal/batch_context.h"

struct pen_keeper {
    struct pen_batch_context *context;
    const struct pen_claim *claim;
    int64_t wait_ms;          /* the shortest time between two states */
    int times;                /* and how many times as long as keeping one takes */
    int64_t ask_ms;           /* the shortest time between questions for a higher priority */
    int64_t asked_ns;         /* when it was last asked whether a batch of higher priority waits */
    int64_t kept_ns, took_ns; /* when the state was last kept, and how long that took */
};

/* Both times are those of the kind of batch; the worker's options may have another `wait_ms`
 * (keep_ms). */
struct pen_keeper pen_keeper_make(struct pen_batch_context *context, const struct pen_claim *claim,
                                  int64_t wait_ms, int64_t ask_ms);

/* Whether the state is to be kept now: its time has come, or a batch of higher priority waits. */
bool pen_keeper_is_due(struct pen_keeper *keeper, bool *outranked);

/* Keeps the state, which the caller has begun to make at `begun_ns`. Returns whether it is kept. A
 * failure may be ignored: the next time may succeed, and the heartbeat notices a lost lease. */
bool pen_keeper_keep(struct pen_keeper *keeper, const struct pen_kept *kept, int64_t begun_ns,
                     bool *outranked);

#endif
