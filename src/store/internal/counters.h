/* SPDX-License-Identifier: MIT */
/* Times of transactions and batches, for monitoring. Threads: any. */
#ifndef PEN_STORE_INTERNAL_COUNTERS_H
#define PEN_STORE_INTERNAL_COUNTERS_H

#include "store/store.h"

void pen_timing_add(enum pen_timing timing, int64_t us);

/* What this process has counted, and takes some of it away. */
void pen_counters_own(struct pen_counters *counters);
void pen_counters_take(const struct pen_counters *counters);

#endif
