/* SPDX-License-Identifier: MIT */
/* The state of a bill in progress. */
#ifndef PEN_STUDY_INTERNAL_BILL_STATE_H
#define PEN_STUDY_INTERNAL_BILL_STATE_H

#include "study/bill.h"
#include "study/internal/making.h"

struct pen_bill_state {
    struct pen_making making; /* counts warm-up runs too */
    struct pen_bill *bill;
};

extern const struct pen_kept_shape pen_bill_shape;

#endif
