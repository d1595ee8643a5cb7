/* SPDX-License-Identifier: MIT */
/* Computes medians, ratios and verdicts from the times of a benchmark's runs. */
#ifndef PEN_STUDY_INTERNAL_BENCH_SUMMARY_H
#define PEN_STUDY_INTERNAL_BENCH_SUMMARY_H

#include "study/bench.h"

/* Sets the ratios of all rows and of the twin, from the repeats so far.
 * Shape: `values` is scratch space for one number per repeat, also below. */
void pen_bench_find_ratios(const struct pen_bench *bench, struct pen_bench_result *result,
                           double *values);

/* Whether the interval of every row's ratio is as narrow as requested. If there is one row, the
 * interval of the twin's ratio. */
bool pen_bench_narrow(const struct pen_bench *bench, const struct pen_bench_result *result);

/* Sets medians, ratios and speed-ups. */
void pen_bench_summarize(const struct pen_bench *bench, struct pen_bench_result *result,
                         double *values);

/* Sets the verdicts and their reasons, from ratios and picture hashes. */
void pen_bench_judge(const struct pen_bench *bench, struct pen_bench_result *result);

#endif
