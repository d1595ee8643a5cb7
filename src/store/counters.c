/* SPDX-License-Identifier: MIT */
/* The counts of this process that it has not moved to the store yet (workers.c). */
#include <string.h>

#include "store/internal/counters.h"
#include "store/internal/handle.h"

const double pen_timing_bounds_s[PEN_TIMING_BUCKETS] = {1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03,
                                                        0.1,  0.3,  1,    3,    10,   100};

static _Atomic uint64_t own[PEN_COUNTERS];

void pen_store_count(enum pen_counter counter, uint64_t count)
{
    atomic_fetch_add_explicit(&own[counter], count, memory_order_relaxed);
}

void pen_timing_add(enum pen_timing timing, int64_t us)
{
    const unsigned first = PEN_COUNT_TIMINGS + timing * (PEN_TIMING_BUCKETS + 2);
    unsigned bucket = 0;
    while (bucket < PEN_TIMING_BUCKETS && (double)us > pen_timing_bounds_s[bucket] * 1e6)
        bucket++;
    pen_store_count(first + bucket, 1);
    pen_store_count(first + PEN_TIMING_BUCKETS + 1, us > 0 ? (uint64_t)us : 0);
}

void pen_counters_own(struct pen_counters *counters)
{
    for (int i = 0; i < PEN_COUNTERS; i++)
        counters->count[i] = atomic_load_explicit(&own[i], memory_order_relaxed);
}

void pen_counters_take(const struct pen_counters *counters)
{
    for (int i = 0; i < PEN_COUNTERS; i++)
        atomic_fetch_sub_explicit(&own[i], counters->count[i], memory_order_relaxed);
}
