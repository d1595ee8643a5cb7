/* SPDX-License-Identifier: MIT */
/* Dividing the views of a job into batches. */
#ifndef PEN_JOBS_INTERNAL_BATCH_LAYOUT_H
#define PEN_JOBS_INTERNAL_BATCH_LAYOUT_H

#include "jobs/internal/request.h"
#include "store/store.h"

/* The edge of the tiles in which a job is rendered, in pixels: that of its settings, or less, since
 * batches end, give way and are bounded between two tiles. The picture is the same. Studies that
 * measure keep that of their settings, and are divided into runs; of these, 0. */
int pen_batch_tile(const struct pen_request *request);

/* The bound of the job's primary and shadow rays, and of what blur multiplies. */
double pen_batch_bound_rays(const struct pen_request *request);

/* The workers that are listed, and the mean of the rates that they told last. */
struct pen_batch_workers {
    int count;
    double rays_per_s; /* 0: not known */
};

/* Whether the batches of a job depend on them; the others take less than two seconds at any rate.
 */
bool pen_batch_needs_rate(const struct pen_request *request);

/* The batches of a job. A benchmark is always one batch, stored with the first view: its times are
 * comparable only if one worker takes all of them. Owns: *batches is malloc()ed. Fails:
 * PEN_NO_MEMORY. */
bool pen_batch_layout(const struct pen_request *request, const struct pen_batch_workers *workers,
                      struct pen_batch_new **batches, int *count, struct pen_status *st);

#endif
