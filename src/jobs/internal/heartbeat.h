/* SPDX-License-Identifier: MIT */
/* The heartbeat: a thread that keeps a worker's lease while its render threads work, and tells them
 * to stop when the batch was cancelled or leased to another worker, or when the job's time is up.
 * It fails a job whose time is up, and reports render threads that do not stop as stuck, since one
 * pixel may take for ever. */
#ifndef PEN_JOBS_INTERNAL_HEARTBEAT_H
#define PEN_JOBS_INTERNAL_HEARTBEAT_H

#include <stdatomic.h>

#include "jobs/worker.h"
#include "store/store.h"

struct pen_heartbeat;

enum pen_claim_end {
    PEN_CLAIM_HELD,      /* it has not ended */
    PEN_CLAIM_LOST,      /* cancelled, or leased to another worker */
    PEN_CLAIM_TIMED_OUT, /* the job's timeout */
    PEN_CLAIM_STOPPED    /* the worker is stopping and gives this batch back */
};

/* Starts the thread, with a store handle of its own. Owns: free with pen_heartbeat_free; options
 * must stay until then. */
struct pen_heartbeat *pen_heartbeat_new(const struct pen_worker_options *options, int64_t lease_ms,
                                        struct pen_status *st);
void pen_heartbeat_free(struct pen_heartbeat *heart);

/* Makes a claim the active one. From now on the flag becomes true when the claim ends, which it
 * also does once *stop is true; stop may be NULL. */
void pen_heartbeat_begin(struct pen_heartbeat *heart, const struct pen_claim *claim,
                         const atomic_bool *stop);
const atomic_bool *pen_heartbeat_flag(struct pen_heartbeat *heart);

/* Makes the flag true. Threads: any. */
void pen_heartbeat_stop(struct pen_heartbeat *heart);

/* Has the store settled, see pen_store_checkpoint, by the thread, when it next looks. */
void pen_heartbeat_settle(struct pen_heartbeat *heart);

/* Whether the job's time is up by the clock now: a short batch may end between two checks. */
bool pen_heartbeat_is_late(struct pen_heartbeat *heart);

/* Ends the active claim. Returns what the heartbeat has noticed meanwhile. */
enum pen_claim_end pen_heartbeat_end(struct pen_heartbeat *heart);

#endif
