/* SPDX-License-Identifier: MIT */
/* Dividing the views of a job into batches. */
#ifndef PEN_JOBS_INTERNAL_BATCH_LAYOUT_H
#define PEN_JOBS_INTERNAL_BATCH_LAYOUT_H

#include "jobs/internal/request.h"
#include "store/store.h"

/* The batches of a job. A benchmark is always one batch, stored with the first view: its times are
 * comparable only if one worker takes all of them. Owns: *batches is malloc()ed. Fails:
 * PEN_NO_MEMORY. */
bool pen_batch_layout(const struct pen_request *request, struct pen_batch_new **batches, int *count,
                      struct pen_status *st);

#endif
