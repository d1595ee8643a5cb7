/* SPDX-License-Identifier: MIT */
/* When a long batch keeps its state in the store, so that a worker that ends loses little of it.
 * And when it yields to a batch that comes first: as soon as its state is kept.
 *
 * Two states are at least wait_ms apart, and keeping takes at most a twentieth of the time. After a
 * failed try, the next try waits: half a second, a second, two, and so on up to a minute. */
#ifndef PEN_JOBS_INTERNAL_KEEP_H
#define PEN_JOBS_INTERNAL_KEEP_H

#include "jobs/internal/batch_context.h"

struct pen_keeper {
    struct pen_batch_context *context;
    int64_t wait_ms;  /* the shortest time between two states */
    int times;        /* and that time as a multiple of the time that keeping takes */
    int64_t ask_ms;   /* the shortest time between two questions for a batch that comes first */
    int64_t asked_ns; /* when this was last asked */
    bool outranked;   /* the last answer: such a batch waits */
    int64_t tried_ns, took_ns; /* when keeping was last tried, and how long it took */
    int64_t retry_ms;          /* wait of the next try after a failure; else 0 */
};

/* Makes a keeper with the times of a kind of batch. The worker's option keep_ms overrides
 * wait_ms. */
struct pen_keeper pen_keeper_make(struct pen_batch_context *context, int64_t wait_ms,
                                  int64_t ask_ms);

/* Returns true if the state must be kept now: its time has come, or a batch that comes first
 * waits. */
bool pen_keeper_is_due(struct pen_keeper *keeper);

/* Keeps the state, whose making began at begun_ns. `kept` NULL: there was no memory to make it.
 * Returns true if it is kept. A failure may be ignored: a later try may succeed, and the heartbeat
 * notices a lost lease. *gives_way: the batch must be given back now. */
bool pen_keeper_keep(struct pen_keeper *keeper, const struct pen_kept *kept, int64_t begun_ns,
                     bool *gives_way);

#endif
