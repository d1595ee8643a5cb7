/* SPDX-License-Identifier: MIT */
/* The worker death report: what the supervisor knows of a worker process that has ended. */
#ifndef PEN_JOBS_WORKER_REPORT_H
#define PEN_JOBS_WORKER_REPORT_H

#include "jobs/trace.h"
#include "store/store.h"

struct pen_worker_report {
    const char *worker;
    enum pen_worker_end end;
    const char *how;               /* "signal 11 (SIGSEGV)", "exit code 3" */
    const struct pen_trace *trace; /* of that worker; NULL: none */
};

/* Frees the batches that the worker held, and charges and fails jobs, by the rules of
 * pen_store_worker_ended. *opened becomes the number of batches that are open again. Fails: as
 * pen_store_worker_ended. */
bool pen_jobs_worker_ended(struct pen_store *store, const struct pen_worker_report *report,
                           int *opened, struct pen_status *st);

#endif
