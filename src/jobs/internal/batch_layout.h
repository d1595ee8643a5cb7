/* SPDX-License-Identifier: MIT */
/* Divides the views of a job into batches. */
#ifndef PEN_JOBS_INTERNAL_BATCH_LAYOUT_H
#define PEN_JOBS_INTERNAL_BATCH_LAYOUT_H

#include "jobs/internal/request.h"
#include "store/store.h"

/* Returns the edge of the tiles in which a job is rendered, in pixels. It is that of the job's
 * settings or less, because a batch can end, yield and be bounded only between two tiles. The
 * picture is the same. For studies, which measure with the tiles of their settings, it is 0. */
int pen_batch_tile(const struct pen_request *request);

/* Returns a bound of the job's primary and shadow rays, times what blur multiplies. */
double pen_batch_bound_rays(const struct pen_request *request);

/* The listed workers, and the mean of the rates that they last reported. */
struct pen_batch_workers {
    int count;
    double rays_per_s; /* 0: not known */
};

/* Returns true if the batches of a job depend on the workers. The other jobs always take less than
 * two seconds. */
bool pen_batch_needs_rate(const struct pen_request *request);

/* Makes the batches of a job. A benchmark is always one batch, stored with the first view, because
 * its times are comparable only if one worker measures all of them.
 * Owns: *batches is from malloc().
 * Fails: PEN_NO_MEMORY. */
bool pen_batch_layout(const struct pen_request *request, const struct pen_batch_workers *workers,
                      struct pen_batch_new **batches, int *count, struct pen_status *st);

#endif
