/* SPDX-License-Identifier: MIT */
/* The reports of `make stability`: one set of facts, written in three forms. */
#ifndef TESTS_PROPERTY_REPORT_H
#define TESTS_PROPERTY_REPORT_H

#include <stdio.h>

#include "property/price.h"
#include "property/row.h"

struct report_row {
    const struct row *row;
    bool ran;
    struct row_result result;
};

struct report {
    uint64_t seed;
    int jobs, rows, prices;
    double wall_s;
    struct report_row *row;
    struct price price[PRICE_MAX];
};

/* "passed", "FAILED", "FAILED, a known defect", "not run", "pending", "does not apply". */
const char *report_verdict(const struct report_row *row);
/* Returns true if the row makes the suite fail. */
bool report_failed(const struct report_row *row);

/* Sums over all rows. */
struct report_sums {
    uint64_t tried, failures;
    int tested, failed, pending, inapplicable;
    double cpu_s;
};
struct report_sums report_sum(const struct report *report);

/* Adds the rows of a file of matrix.sh or mutants.sh; `row` must have space for ROWS_MAX.
 * Fails: false if it cannot be read. */
bool report_also(struct report *report, const char *path);

void report_markdown(const struct report *report, FILE *f);
void report_json(const struct report *report, FILE *f);
void report_html(const struct report *report, FILE *f);

#endif
