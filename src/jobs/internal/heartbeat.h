/* SPDX-License-Identifier: MIT */
/* The heartbeat: a thread that extends a worker's lease while its render threads work. It stops
 * them when the job was cancelled, the batch was leased to another worker, or the job's time is up.
 * It measures the working time on the claim, and stores it with each extension. It fails a job on
 * which all workers together have worked longer than its timeout.
 *
 * Render threads that do not stop are reported as stuck, because a single pixel may take without
 * end. A thread that gets no processor is not stuck. So the processor time of the thread that used
 * most of it decides; after ten seconds by the clock the threads are stuck in any case.
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
    PEN_CLAIM_LOST,      /* the job was cancelled, or the batch was leased to another worker */
    PEN_CLAIM_TIMED_OUT, /* the job's time is up */
    PEN_CLAIM_STOPPED    /* the worker is stopping and gives this batch back */
};

/* Returns the part of the job's work that the active claim has done after spent_ms, and sets
 * *per_ms to the work of a millisecond. *per_ms 0: not known; readers then get no report. The
 * heartbeat's thread calls it once a second while the claim's clock runs. It holds the heartbeat's
 * lock, so the function must not call the heartbeat. */
typedef double pen_heartbeat_work_fn(void *user, double spent_ms, double *per_ms);

/* Starts the thread, with its own store handle. `pool` has the render threads; `work` may be NULL.
 * Owns: free with pen_heartbeat_free; options and pool must live until then.
 * Fails: as pen_store_open; PEN_NO_MEMORY. */
struct pen_heartbeat *pen_heartbeat_new(const struct pen_worker_options *options,
                                        struct pen_thread_pool *pool, int64_t lease_ms,
                                        pen_heartbeat_work_fn *work, void *user,
                                        struct pen_status *st);
void pen_heartbeat_free(struct pen_heartbeat *heart);

/* Makes a claim the active one, starts its clock, and clears the cancel flag. The flag becomes true
 * when the claim ends. The claim also ends when *stop (may be NULL) becomes true. */
void pen_heartbeat_begin(struct pen_heartbeat *heart, const struct pen_claim *claim,
                         const atomic_bool *stop);

/* Returns the flag that stops the render threads. Its address never changes. */
const atomic_bool *pen_heartbeat_cancel_flag(struct pen_heartbeat *heart);

/* Sets the cancel flag. Threads: any. */
void pen_heartbeat_cancel(struct pen_heartbeat *heart);

/* Stop and start the clock of the active claim around a wait for the store. Render threads must not
 * work meanwhile, so none are reported as stuck. */
void pen_heartbeat_pause(struct pen_heartbeat *heart);
void pen_heartbeat_resume(struct pen_heartbeat *heart);

/* Returns the working time on the active claim. */
int64_t pen_heartbeat_spent_us(struct pen_heartbeat *heart);

/* Returns true if the job's time is up now. (A short batch may end between two checks of the
 * thread.) */
bool pen_heartbeat_is_late(struct pen_heartbeat *heart);

/* Ends the active claim. Returns the reason if the heartbeat has ended it before, else
 * PEN_CLAIM_HELD. */
enum pen_claim_end pen_heartbeat_end(struct pen_heartbeat *heart);

#endif
