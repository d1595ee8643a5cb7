/* SPDX-License-Identifier: MIT */
/* A store with jobs in every state, on a disk that can fail. A test can restore it from the same
 * template any number of times. Also the fault plans of the tests. */
#ifndef TESTS_SUPPORT_FAULT_BED_H
#define TESTS_SUPPORT_FAULT_BED_H

#include "support/faults.h"
#include "support/store.h"

/* Numbers of the jobs in the template, for fault_bed_id. FAULT_FRESH is not in the template. */
enum { FAULT_QUEUED = 1, FAULT_HALF = 2, FAULT_LAST = 3, FAULT_ENDED = 4, FAULT_FRESH = 5 };

struct fault_bed {
    struct store_bed bed;
    char template[128];
    struct pen_claim held[3]; /* leased in the template: FAULT_HALF's two batches, the assemble
                                 batch of FAULT_LAST */
};

/* Installs the disk, makes the template, and turns the log off. */
void fault_bed_open(struct fault_bed *b);
void fault_bed_close(struct fault_bed *b);

/* Replaces the store by the template. No handle may have the store open. */
void fault_bed_renew(struct fault_bed *b);

/* Returns the id of a job.
 * Owns: static, valid until the next call. */
const char *fault_bed_id(int number);

/* The plans, to be tried with n = 1, 2, 3, … */
enum { FAULT_PLANS = 12 };
extern const struct fault_plan fault_plans[FAULT_PLANS];

/* Returns the call that fails after call n under plan k: the next call or, beyond the first few,
 * the seventh from there, unless all cases are asked for. The plans begin these steps at different
 * calls, so together they cover more calls. */
long fault_next(long n, int k);

/* Fails the test unless the status of a call that failed under a plan fits the plan: its code, and
 * a text with the name of the store. */
void fault_bed_check_refusal(const struct fault_bed *b, const struct fault_plan *plan,
                             const struct pen_status *st, const char *what);

#endif
