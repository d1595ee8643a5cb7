/* SPDX-License-Identifier: MIT */
/* The heartbeat: a thread that extends a worker's lease while its render threads work, and tells
 * them to stop when the job was cancelled, the batch was leased to another worker, or the job's
 * time is up. It measures how long the worker works on its claim, tells the store with each
 * extension, and fails a job on which all workers together have worked longer than its timeout.
 * Render threads that do not stop are reported as stuck: one pixel may take without end. Threads
 * that got no processor are not stuck, so what counts is the processor time of the thread that
 * used most of it since; after ten seconds they count as stuck anyway.
 *
 * Threads: the worker's own thread makes all calls, except pen_heartbeat_cancel (any thread). */
#ifndef PEN_JOBS_INTERNAL_HEARTBEAT_H
#define PEN_JOBS_INTERNAL_HEARTBEAT_H

#include <stdatomic.h>

#include "base/thread_pool.h"
#include "jobs/worker.h"
#include "store/store.h"

struct pen_heartbeat;

enum pen_claim_end {
    PEN_CLAIM_HELD,      /* it has not ended */
    PEN_CLAIM_LOST,      /* the job was cancelled, or the batch leased to another worker */
    PEN_CLAIM_TIMED_OUT, /* the job's time is up */
    PEN_CLAIM_STOPPED    /* the worker is stopping and gives this batch back */
};

/* Tells what the active claim has done of its job's work, when so many ms were spent on it, and
 * sets *per_ms to the work of a ms; 0: not known, and nothing is told to readers. Called once a
 * second from the heartbeat's thread, while the claim's clock runs, with the heartbeat's lock held:
 * so it makes none of these calls. */
typedef double pen_heartbeat_work_fn(void *user, double spent_ms, double *per_ms);

/* Starts the thread, with a store handle of its own. The pool has the render threads; `work` may be
 * NULL. Owns: free with pen_heartbeat_free; options and pool must stay until then. Fails: as
 * pen_store_open; PEN_NO_MEMORY. */
struct pen_heartbeat *pen_heartbeat_new(const struct pen_worker_options *options,
                                        struct pen_thread_pool *pool, int64_t lease_ms,
                                        pen_heartbeat_work_fn *work, void *user,
                                        struct pen_status *st);
void pen_heartbeat_free(struct pen_heartbeat *heart);

/* Makes a claim the active one, starts its clock, and clears the cancel flag. The flag becomes true
 * when the claim ends; a claim also ends when *stop becomes true. stop may be NULL. */
void pen_heartbeat_begin(struct pen_heartbeat *heart, const struct pen_claim *claim,
                         const atomic_bool *stop);

/* The flag that stops the render threads; it stays at one address. */
const atomic_bool *pen_heartbeat_cancel_flag(struct pen_heartbeat *heart);

/* Sets the cancel flag. Threads: any. */
void pen_heartbeat_cancel(struct pen_heartbeat *heart);

/* Stops the clock of the active claim while the worker waits for the store, and starts it again.
 * Render threads must not work meanwhile: none are reported as stuck. */
void pen_heartbeat_pause(struct pen_heartbeat *heart);
void pen_heartbeat_resume(struct pen_heartbeat *heart);

/* How long the worker has worked on the active claim. */
int64_t pen_heartbeat_spent_us(struct pen_heartbeat *heart);

/* Whether the job's time is up now; a short batch may end between two checks of the thread. */
bool pen_heartbeat_is_late(struct pen_heartbeat *heart);

/* Ends the active claim. Returns why the heartbeat has ended it before, or PEN_CLAIM_HELD. */
enum pen_claim_end pen_heartbeat_end(struct pen_heartbeat *heart);

#endif
