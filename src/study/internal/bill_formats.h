/* SPDX-License-Identifier: MIT */
/* What the formats of a bill have in common. */
#ifndef PEN_STUDY_INTERNAL_BILL_FORMATS_H
#define PEN_STUDY_INTERNAL_BILL_FORMATS_H

#include "study/bill.h"

/* The effect that a row lacks; "all effects". */
const char *pen_bill_name(const struct pen_bill_row *row);

/* What the effect adds: milliseconds, their share of the whole picture's, rays. */
double pen_bill_cost_ms(const struct pen_bill *bill, const struct pen_bill_row *row);
double pen_bill_share(const struct pen_bill *bill, const struct pen_bill_row *row);
double pen_bill_rays(const struct pen_bill *bill, const struct pen_bill_row *row);

/* Appends the page; out->failed tells that memory ran out. */
void pen_bill_write_html(const struct pen_bill *bill, const char *scene, struct pen_buf *out);

#endif
