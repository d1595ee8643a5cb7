/* SPDX-License-Identifier: MIT */
/* The worker's housekeeping: a thread with its own store handle, for work that no client waits for.
 * It removes jobs beyond retention, parts of deleted jobs, unused forms of pictures, and old keys
 * and statistics. It gives free space back. It works in slices and pauses between them, so that
 * submits and commits get their turn. Several workers may do it at once. If a worker is killed,
 * another worker continues. */
#ifndef PEN_JOBS_INTERNAL_HOUSEKEEPER_H
#define PEN_JOBS_INTERNAL_HOUSEKEEPER_H

#include "jobs/worker.h"

struct pen_housekeeper;

/* Starts the thread.
 * Owns: free with pen_housekeeper_free, which waits for the current slice. The options stay the
 * caller's and must live until then.
 * Fails: as pen_store_open, and PEN_NO_MEMORY. */
struct pen_housekeeper *pen_housekeeper_new(const struct pen_worker_options *options,
                                            struct pen_status *st);
void pen_housekeeper_free(struct pen_housekeeper *keeper);

#endif
