/* SPDX-License-Identifier: MIT */
/* Parts of the statistics object, for one render and for a job put together from batches.
 *
 * A batch stores the object of pen_stats_json and, beside its keys,
 *   tile_ms    the times of its tiles, at most PEN_TILE_TIMES of them (evenly picked from the
 *              sorted ones where there are more)
 *   commit_ms  wall clock at which it was handed to the store
 *   store_before_ms  what the worker had waited for the store by then, since its last batch of the
 *              job: for that one's commit, for reading and packing pixels
 * which the job's statistics do not show. */
#ifndef PEN_JOBS_INTERNAL_STATS_H
#define PEN_JOBS_INTERNAL_STATS_H

#include <jansson.h>
#include <stddef.h>
#include <stdint.h>

#include "jobs/worker.h"

enum { PEN_TILE_TIMES = 2048 };

struct pen_percentiles {
    double p50, p95, max;
};

/* Of `count` times, by the nearest rank. Returns false when out of memory. */
bool pen_percentiles_of(const double *ms, size_t count, struct pen_percentiles *out);

/* Times that stand for more tiles than there are of them. */
struct pen_weighted {
    double ms, weight;
};

/* Sorts the times. */
struct pen_percentiles pen_percentiles_weighted(struct pen_weighted *times, size_t count);

/* A batch's times of tiles for storing. */
json_t *pen_tile_times(const double *ms, size_t count);

json_t *pen_stats_tiles(uint64_t count, const struct pen_percentiles *ms);

/* The peak of this process's resident memory since the last reset. */
void pen_peak_reset(void);
int64_t pen_peak_bytes(void);

#endif
