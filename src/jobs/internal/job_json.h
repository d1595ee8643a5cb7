/* SPDX-License-Identifier: MIT */
/* The job object of the API (api/http-api.md). */
#ifndef PEN_JOBS_INTERNAL_JOB_JSON_H
#define PEN_JOBS_INTERNAL_JOB_JSON_H

#include <jansson.h>

#include "base/status.h"
#include "store/store.h"

/* The job object of a stored job: its stored request, and around it its state. Fails: PEN_STORAGE
 * (the stored request is no JSON), PEN_NO_MEMORY. */
json_t *pen_job_json(const struct pen_job_record *job, struct pen_status *st);

/* The same from a request that is not stored yet; job->request is not read. */
json_t *pen_job_json_of(const struct pen_job_record *job, json_t *request, struct pen_status *st);

/* A time as the API writes it, null for 0. */
json_t *pen_time_json(int64_t wall_ms);

/* problems.c: {pointer, detail}, or {line, column, detail} where the text has lines. */
json_t *pen_problem_place(const struct pen_status *st);

#endif
