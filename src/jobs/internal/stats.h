/* SPDX-License-Identifier: MIT */
/* The statistics that a batch stores, and a job's, which are made from those of its batches.
 *
 * A batch stores the object of pen_stats_json with three more members, which a job's statistics do
 * not show:
 *   tile_ms          the times of its tiles, at most PEN_TILE_TIMES of them (evenly picked from the
 *                    sorted ones where there are more)
 *   commit_ms        the wall clock when it was handed to the store
 *   store_before_ms  how long the worker had waited for the store by then, since its last batch of
 *                    the job: for that batch's commit, and for reading and compressing pixels */
#ifndef PEN_JOBS_INTERNAL_STATS_H
#define PEN_JOBS_INTERNAL_STATS_H

#include <jansson.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "store/store.h"

enum { PEN_TILE_TIMES = 2048 };

/* The member tile_ms. Fails: NULL when out of memory. */
json_t *pen_tile_times(const double *ms, size_t count);

/* stats_merge.c: the statistics of a job from those of all its committed batches. Fails: as
 * pen_store_stats; PEN_STORAGE, PEN_NO_MEMORY. */
json_t *pen_stats_of_job(struct pen_store *store, const struct pen_job_record *job,
                         struct pen_status *st);

#endif
