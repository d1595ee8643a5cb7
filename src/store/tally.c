/* SPDX-License-Identifier: MIT */
/* Counters of what all processes of a store have done, for its readers. They are sums in shared
 * memory, not in the database: a commit costs nothing more, and a crash may lose the last ones. */
#include "store/internal/policy.h"

/* The upper bounds of the buckets of batch times. */
static const double bucket_seconds[PEN_TALLY_BUCKETS] = {0.01, 0.03, 0.1, 0.3, 1,    3,
                                                         10,   30,   100, 300, 1000, 10000};

double pen_tally_bucket_seconds(int bucket)
{
    return bucket_seconds[bucket];
}

void pen_store_tally_add(struct pen_store *store, enum pen_tally tally, uint64_t count)
{
    atomic_fetch_add_explicit(&store->driver->ops->tallies(store->driver)[tally], count,
                              memory_order_relaxed);
}

uint64_t pen_store_tally(struct pen_store *store, enum pen_tally tally)
{
    return atomic_load_explicit(&store->driver->ops->tallies(store->driver)[tally],
                                memory_order_relaxed);
}

void pen_tally_batch(struct pen_store *store, int64_t spent_us)
{
    int bucket = 0;
    while (bucket < PEN_TALLY_BUCKETS && (double)spent_us > bucket_seconds[bucket] * 1e6)
        bucket++;
    pen_store_tally_add(store, (enum pen_tally)(PEN_TALLY_BATCH_BUCKET + bucket), 1);
    pen_store_tally_add(store, PEN_TALLY_BATCH_US, spent_us > 0 ? (uint64_t)spent_us : 0);
}
