/* SPDX-License-Identifier: MIT */
/* Percentiles of tile times by nearest rank: the least time that at least a share p of the tiles
 * did not exceed. */
#ifndef PEN_RENDER_PERCENTILES_H
#define PEN_RENDER_PERCENTILES_H

#include <stdbool.h>
#include <stddef.h>

struct pen_percentiles {
    double p50, p95, max; /* in the unit of the times */
};

/* A time that represents `weight` tiles. */
struct pen_weighted_time {
    double ms, weight;
};

/* The percentiles of `count` times; all 0 if there are none.
 * Fails: returns false when out of memory. */
bool pen_percentiles_of(const double *ms, size_t count, struct pen_percentiles *out);

/* The percentiles of weighted times, which are sorted in place; all 0 if there are none. */
struct pen_percentiles pen_percentiles_weighted(struct pen_weighted_time *times, size_t count);

#endif
