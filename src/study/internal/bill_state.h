/* SPDX-License-Identifier: MIT */
/* A bill while it is made. */
#ifndef PEN_STUDY_INTERNAL_BILL_STATE_H
#define PEN_STUDY_INTERNAL_BILL_STATE_H

#include "study/bill.h"
#include "study/internal/making.h"

struct pen_bill_state {
    struct pen_making making; /* runs are also those to warm up */
    struct pen_bill *bill;
};

extern const struct pen_kept_shape pen_bill_shape;

#endif
