/* SPDX-License-Identifier: MIT */
/* Reads the rows of a report, for comparisons and histories. */
#ifndef PEN_STUDY_INTERNAL_REPORT_ROWS_H
#define PEN_STUDY_INTERNAL_REPORT_ROWS_H

#include <jansson.h>
#include <stdbool.h>

#include "study/verdict.h"

/* The members of `host` that identify a host. Other members describe the build. NULL ends the list.
 */
extern const char *const pen_bench_host_members[];

/* Whether two settings objects have equal values for all members that both have. */
bool pen_bench_settings_agree(const json_t *a, const json_t *b);

/* All settings of a row: its own, and those that all rows of its report share.
 * Owns: the caller json_decref()s. */
json_t *pen_bench_all_settings(const json_t *report, const json_t *row);

/* The confidence interval of the median of a row's runs. Spoiled runs widen it. */
struct pen_confidence pen_bench_row_times(const json_t *row, double alpha);

#endif
