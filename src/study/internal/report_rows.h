/* SPDX-License-Identifier: MIT */
/* What comparisons and histories read of a report's rows. */
#ifndef PEN_STUDY_INTERNAL_REPORT_ROWS_H
#define PEN_STUDY_INTERNAL_REPORT_ROWS_H

#include <jansson.h>
#include <stdbool.h>

#include "study/verdict.h"

/* The members of `host` that make a host; others are of the build. NULL ends the list. */
extern const char *const pen_bench_host_members[];

/* Whether two objects of settings agree in every member that both have. */
bool pen_bench_settings_agree(const json_t *a, const json_t *b);

/* All settings of a row: those that all rows of its report share, and its own. Owns: the caller
 * json_decref()s. */
json_t *pen_bench_all_settings(const json_t *report, const json_t *row);

/* The interval of the median of a row's runs, which leaves those out of account that are spoiled.
 */
struct pen_confidence pen_bench_row_times(const json_t *row, double alpha);

#endif
