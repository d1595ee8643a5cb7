/* SPDX-License-Identifier: MIT */
/* The error of a job that rendering itself has failed: a problem document that beside the usual
 * members says
 *   batch    {view, first_tile, tile_count, attempt}
 *   pixel    [x, y], where it is known
 *   signal   "SIGSEGV", or exit_code; of a worker that died
 *   log      its last lines
 *   repeat   the command line that does the same again */
#ifndef PEN_JOBS_INTERNAL_FAILURE_H
#define PEN_JOBS_INTERNAL_FAILURE_H

#include "jobs/worker_report.h"
#include "store/store.h"

/* The error of a job beyond its timeout_seconds. Owns: a malloc()ed text; NULL when out of memory.
 */
char *pen_failure_of_time(struct pen_store *store, const struct pen_claim *claim,
                          const struct pen_trace *trace);

/* The error of a job that any other problem has ended. */
char *pen_failure_of(struct pen_store *store, const struct pen_claim *claim,
                     const struct pen_status *why);

/* Ends the claim's job as failed with such an error, and says so in the log: once, however many
 * come to it. Fails: as pen_store_fail. */
bool pen_failure_store(struct pen_store *store, const struct pen_claim *claim, const char *error,
                       struct pen_status *st);

#endif
