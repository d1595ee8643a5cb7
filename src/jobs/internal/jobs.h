/* SPDX-License-Identifier: MIT */
/* Definitions that most files of this module use. */
#ifndef PEN_JOBS_INTERNAL_JOBS_H
#define PEN_JOBS_INTERNAL_JOBS_H

#include "base/clock.h"
#include "base/log.h"
#include "io/json_build.h"
#include "jobs/jobs.h"
#include "jobs/worker.h"

struct pen_jobs {
    struct pen_store *store;
    struct pen_limits limits;
};

/* The flags with which JSON is written into the store: every double reads back as itself. */
#define PEN_JSON_STORED (JSON_COMPACT | JSON_REAL_PRECISION(17))

/* The job, batch and attempt that a log line about a claim names. */
static inline struct pen_log_about pen_claim_about(const struct pen_claim *claim)
{
    return (struct pen_log_about){
        .job = claim->job_id, .batch = claim->batch, .attempt = claim->attempt};
}

static inline double pen_ms_since(int64_t begun_ns)
{
    return (double)(pen_clock_ns() - begun_ns) * 1e-6;
}

/* Ends the process, as the options say, if the store has an I/O error. */
static inline void pen_worker_check_store(const struct pen_worker_options *options,
                                          const struct pen_store *store)
{
    struct pen_status why;
    if (options->broken && pen_store_is_broken(store, &why))
        options->broken(options->user, &why);
}

/* The layer and format under which a job's report is stored. */
#define PEN_REPORT_LAYER "report"
#define PEN_REPORT_FORMAT "json"

#endif
