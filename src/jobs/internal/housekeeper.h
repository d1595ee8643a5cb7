/* SPDX-License-Identifier: MIT */
/* The worker's housekeeping: a thread of its own, with its own handle on the store, that does what
 * no client waits for. It removes jobs that retention no longer keeps, what deletes have left,
 * forms of pictures that were not used for long, keys and statistics that are too old, and gives
 * free space back. It works in slices and pauses between them, so
 * that submits and commits get their turn. Several workers may do so at the same time; a worker
 * that is killed leaves nothing undone that another one would not go on with. */
#ifndef PEN_JOBS_INTERNAL_HOUSEKEEPER_H
#define PEN_JOBS_INTERNAL_HOUSEKEEPER_H

#include "jobs/worker.h"

struct pen_housekeeper;

/* Starts the thread. Owns: pen_housekeeper_free, which waits for the slice in progress; the options
 * stay the caller's, and are used until then. Fails: as pen_store_open, and PEN_NO_MEMORY. */
struct pen_housekeeper *pen_housekeeper_new(const struct pen_worker_options *options,
                                            struct pen_status *st);
void pen_housekeeper_free(struct pen_housekeeper *keeper);

#endif
