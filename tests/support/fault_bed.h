/* SPDX-License-Identifier: MIT */
/* A store with a job in every situation, over a disk that can fail: opened anew from the same
 * template as often as a test likes. Also the ways to fail that tests go through. */
#ifndef TESTS_SUPPORT_FAULT_BED_H
#define TESTS_SUPPORT_FAULT_BED_H

#include "support/faults.h"
#include "support/store.h"

/* Numbers of the jobs in the template, for fault_bed_id; the last one is in none. */
enum { FAULT_QUEUED = 1, FAULT_HALF = 2, FAULT_LAST = 3, FAULT_ENDED = 4, FAULT_FRESH = 5 };

struct fault_bed {
    struct store_bed bed;
    char template[128];
    struct pen_claim held[3]; /* leased in the template: FAULT_HALF's two batches, the assemble
                                 batch of FAULT_LAST */
};

/* Installs the disk, and makes the template; the log is silent but for worse than errors. */
void fault_bed_open(struct fault_bed *b);
void fault_bed_close(struct fault_bed *b);

/* Puts the template in the store's place, which nobody may have open. */
void fault_bed_renew(struct fault_bed *b);

/* Owns: static, until the next call. */
const char *fault_bed_id(int number);

/* To be tried for n = 1, 2 and on. */
enum { FAULT_PLANS = 12 };
extern const struct fault_plan fault_plans[FAULT_PLANS];

/* Fails the test unless a call that failed under a plan says so: by its code, with the store. */
void fault_bed_check_refusal(const struct fault_bed *b, const struct fault_plan *plan,
                             const struct pen_status *st, const char *what);

#endif
