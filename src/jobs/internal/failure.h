/* SPDX-License-Identifier: MIT */
/* The error of a job that has failed in a worker: a problem document with these further members:
 *   batch    {view, first_tile, tile_count, attempt}
 *   pixel    [x, y], if it is known
 *   signal   "SIGSEGV", or exit_code, of a worker that died
 *   log      the last log lines of that worker
 *   repeat   the command line that repeats the failure */
#ifndef PEN_JOBS_INTERNAL_FAILURE_H
#define PEN_JOBS_INTERNAL_FAILURE_H

#include "jobs/worker.h"
#include "store/store.h"

/* Ends the claim's job as failed with such an error, and logs the error. `why` NULL: the job took
 * longer than its timeout_seconds. The trace (may be NULL) gives the pixel. Only the first error of
 * a job is stored and logged.
 * Fails: as pen_store_fail; PEN_STALE (a later error), PEN_NO_MEMORY. */
bool pen_failure_store(struct pen_store *store, const struct pen_claim *claim,
                       const struct pen_status *why, const struct pen_trace *trace,
                       struct pen_status *st);

#endif
