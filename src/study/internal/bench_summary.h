/* SPDX-License-Identifier: MIT */
/* From the times of a benchmark's runs to medians, ratios and verdicts. */
#ifndef PEN_STUDY_INTERNAL_BENCH_SUMMARY_H
#define PEN_STUDY_INTERNAL_BENCH_SUMMARY_H

#include "study/bench.h"

/* Fills the ratios of all rows and of the twin from the repeats made so far. `values` has place for
 * as many numbers as there are repeats; so it has below. */
void pen_bench_find_ratios(const struct pen_bench *bench, struct pen_bench_result *result,
                           double *values);

/* Whether the interval of every row's ratio is as narrow as asked; if there is but one row, that of
 * its twin's. */
bool pen_bench_narrow(const struct pen_bench *bench, const struct pen_bench_result *result);

/* Fills medians, ratios and speed-ups. */
void pen_bench_summarize(const struct pen_bench *bench, struct pen_bench_result *result,
                         double *values);

/* Fills the verdicts and their reasons, from ratios and hashes of pictures. */
void pen_bench_judge(const struct pen_bench *bench, struct pen_bench_result *result);

#endif
