/* SPDX-License-Identifier: MIT */
/* What the formats of a bill have in common. */
#ifndef PEN_STUDY_INTERNAL_BILL_FORMATS_H
#define PEN_STUDY_INTERNAL_BILL_FORMATS_H

#include "study/bill.h"

/* The effect that a row lacks; "all effects". */
const char *pen_bill_name(const struct pen_bill_row *row);

/* What the effect adds. */
struct pen_bill_cost {
    bool known;       /* the times of the row and of the whole are distinguished */
    double ms, share; /* if so: of time, and as a share of the whole */
    double below_ms;  /* if not: what it costs at most; below 0: runs are spoiled, so nothing is
                       * known */
    double rays;
};
struct pen_bill_cost pen_bill_cost_of(const struct pen_bill *bill, const struct pen_bill_row *row);

/* Appends how many runs are spoiled; nothing if none is. */
void pen_bill_write_spoiled(const struct pen_bill *bill, struct pen_buf *out);

/* Appends the page; out->failed tells that memory ran out. */
void pen_bill_write_html(const struct pen_bill *bill, const char *scene, struct pen_buf *out);

#endif
