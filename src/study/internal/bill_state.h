/* SPDX-License-Identifier: MIT */
/* A bill between two runs: what of it is kept, and read again. */
#ifndef PEN_STUDY_INTERNAL_BILL_STATE_H
#define PEN_STUDY_INTERNAL_BILL_STATE_H

#include "study/bill.h"

/* Lets the caller keep the bill. Fails: PEN_UNAVAILABLE, if the bill is to end here. */
bool pen_bill_between(const struct pen_bill *bill, struct pen_status *st);

/* Takes over what an earlier process has kept, if it is of this bill, host, build and number of
 * threads, and whole; else the bill stays new. Returns whether it did. */
bool pen_bill_state_read(struct pen_bill *bill, const struct pen_kept_study *kept);

#endif
