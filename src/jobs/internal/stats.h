/* SPDX-License-Identifier: MIT */
/* What a batch stores of its statistics.
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

#include "io/stats_json.h"

enum { PEN_TILE_TIMES = 2048 };

/* A batch's times of tiles for storing. */
json_t *pen_tile_times(const double *ms, size_t count);

#endif
