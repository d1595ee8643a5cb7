/* SPDX-License-Identifier: MIT */
/* The job object of the API (api/http-api.md). */
#ifndef PEN_JOBS_INTERNAL_JOB_JSON_H
#define PEN_JOBS_INTERNAL_JOB_JSON_H

#include <jansson.h>

#include "base/status.h"
#include "store/store.h"

/* Makes the job object of a stored job from its request and its state.
 * Owns: the caller.
 * Fails: PEN_STORAGE (the stored request is damaged), PEN_NO_MEMORY. */
json_t *pen_job_json(const struct pen_job_record *job, struct pen_status *st);

/* As pen_job_json, but with `request` instead of job->request. */
json_t *pen_job_json_with(const struct pen_job_record *job, json_t *request, struct pen_status *st);

/* A time as the API writes it; null for 0. */
json_t *pen_time_json(int64_t wall_ms);

#endif
