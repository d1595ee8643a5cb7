/* SPDX-License-Identifier: MIT */
/* Adds a time of a transaction or a batch, for monitoring.
 * Threads: any. */
#ifndef PEN_STORE_INTERNAL_COUNTERS_H
#define PEN_STORE_INTERNAL_COUNTERS_H

#include "store/store.h"

void pen_timing_add(enum pen_timing timing, int64_t us);

/* Reads the counts of this process; subtracts counts that were moved to the store. */
void pen_counters_own(struct pen_counters *counters);
void pen_counters_take(const struct pen_counters *counters);

#endif
