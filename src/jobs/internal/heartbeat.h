/* SPDX-License-Identifier: MIT */
/* The thread that keeps a worker's lease alive while its render threads work, and tells them to
 * stop: when the batch was taken away or cancelled, or when its job's time is up. A job beyond its
 * time is failed here, and render threads that do not stop are reported as stuck: one pixel may
 * take for ever. */
#ifndef PEN_JOBS_INTERNAL_HEARTBEAT_H
#define PEN_JOBS_INTERNAL_HEARTBEAT_H

#include <stdatomic.h>

#include "jobs/worker.h"
#include "store/store.h"

struct pen_heartbeat;

enum pen_beat_end {
    PEN_BEAT_HELD,    /* nothing happened */
    PEN_BEAT_LOST,    /* cancelled, or leased to another */
    PEN_BEAT_TIME_UP, /* the job's timeout */
    PEN_BEAT_STOPPED  /* the worker is to end and does not wait for this batch */
};

/* Starts the thread, with a handle of its own. Owns: free with pen_heartbeat_free; options must
 * stay until then. */
struct pen_heartbeat *pen_heartbeat_new(const struct pen_worker_options *options, int64_t lease_ms,
                                        struct pen_status *st);
void pen_heartbeat_free(struct pen_heartbeat *heart);

/* Begins to watch over a claim. From now on the flag becomes true when its work is in vain, also
 * once *stop is true; stop may be NULL. */
void pen_heartbeat_begin(struct pen_heartbeat *heart, const struct pen_claim *claim,
                         const atomic_bool *stop);
const atomic_bool *pen_heartbeat_flag(struct pen_heartbeat *heart);

/* Makes the flag true. Threads: any. */
void pen_heartbeat_stop(struct pen_heartbeat *heart);

/* Has the store settled, see pen_store_checkpoint, by the thread, when it next looks. */
void pen_heartbeat_settle(struct pen_heartbeat *heart);

/* Whether the claim's time is up, looking at the clock now: a short batch ends between two looks.
 */
bool pen_heartbeat_is_late(struct pen_heartbeat *heart);

/* Ends watching. Returns what happened meanwhile. */
enum pen_beat_end pen_heartbeat_end(struct pen_heartbeat *heart);

#endif
