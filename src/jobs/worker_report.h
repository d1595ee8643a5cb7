/* SPDX-License-Identifier: MIT */
/* What whoever watches over a worker says when it has ended. */
#ifndef PEN_JOBS_WORKER_REPORT_H
#define PEN_JOBS_WORKER_REPORT_H

#include "jobs/trace.h"
#include "store/store.h"

struct pen_worker_report {
    const char *worker;
    enum pen_worker_end end;
    const char *how;               /* "signal 11 (SIGSEGV)" */
    const struct pen_trace *trace; /* its own; NULL: none */
};

/* Opens what the worker held, and charges and fails jobs as pen_store_worker_ended says. */
bool pen_jobs_worker_ended(struct pen_store *store, const struct pen_worker_report *obituary,
                           int *opened, struct pen_status *st);

#endif
