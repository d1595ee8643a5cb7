/* SPDX-License-Identifier: MIT */
/* The error of a job that has failed in a worker: a problem document with these further members:
 *   batch    {view, first_tile, tile_count, attempt}
 *   pixel    [x, y], if it is known
 *   signal   "SIGSEGV", or exit_code, of a worker that died
 *   log      the last log lines of that worker
 *   repeat   the command line that repeats what failed */
#ifndef PEN_JOBS_INTERNAL_FAILURE_H
#define PEN_JOBS_INTERNAL_FAILURE_H

#include "jobs/worker_report.h"
#include "store/store.h"

/* The error of a job beyond its timeout_seconds. Owns: a malloc()ed text; NULL when out of memory.
 */
char *pen_failure_of_time(struct pen_store *store, const struct pen_claim *claim,
                          const struct pen_trace *trace);

/* The error of a job that has failed for any other reason. */
char *pen_failure_of(struct pen_store *store, const struct pen_claim *claim,
                     const struct pen_status *why);

/* Ends the claim's job as failed with such an error, and logs it, once for each job: the store
 * takes only the first error. Fails: as pen_store_fail. */
bool pen_failure_store(struct pen_store *store, const struct pen_claim *claim, const char *error,
                       struct pen_status *st);

#endif
