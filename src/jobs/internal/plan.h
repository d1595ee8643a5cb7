/* SPDX-License-Identifier: MIT */
/* How a job's views are cut into batches. */
#ifndef PEN_JOBS_INTERNAL_PLAN_H
#define PEN_JOBS_INTERNAL_PLAN_H

#include "jobs/internal/request.h"
#include "store/store.h"

/* A benchmark is one batch, of its first view, whatever it renders: what it measures is worth
 * something only as a whole. Owns: *batches is malloc()ed. Fails: PEN_NO_MEMORY. */
bool pen_plan_batches(const struct pen_request *request, struct pen_batch_new **batches, int *count,
                      struct pen_status *st);

#endif
