/* SPDX-License-Identifier: MIT */
/* The statistics that a batch stores, and the statistics of a job, which are made from them.
 *
 * A batch stores the object of pen_stats_json with two more members, which a job's statistics do
 * not show:
 *   tile_ms          the times of the batch's tiles, sorted. Of more than PEN_TILE_TIMES tiles,
 * that many times are stored, evenly spaced; the largest is included store_before_ms  how long the
 * worker has waited for the store since its previous batch of this job: for that batch's commit,
 * and to read pixels */
#ifndef PEN_JOBS_INTERNAL_STATS_H
#define PEN_JOBS_INTERNAL_STATS_H

#include <jansson.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "store/store.h"

enum { PEN_TILE_TIMES = 2048 };

/* stats_merge.c: makes the statistics of a job from those of all its committed batches.
 * Owns: the caller.
 * Fails: as pen_store_stats; PEN_STORAGE (damaged statistics), PEN_NO_MEMORY. */
json_t *pen_stats_of_job(struct pen_store *store, const struct pen_job_record *job,
                         struct pen_status *st);

/* Makes them from a list of batches. */
json_t *pen_stats_of_batches(const struct pen_batch_stats *batches, size_t count,
                             const struct pen_job_record *job, struct pen_status *st);

#endif
