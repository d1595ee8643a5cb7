/* SPDX-License-Identifier: MIT */
/* What follows from the runs of an accuracy study. */
#ifndef PEN_STUDY_ACCURACY_SUMMARY_H
#define PEN_STUDY_ACCURACY_SUMMARY_H

#include "study/accuracy.h"

/* A median, and the quantiles of 5 and 95 %, between the neighbouring values. */
struct pen_accuracy_spread {
    double median, low, high;
};

/* Of a row that was run: its error by one metric; its times, with the least and the largest. */
struct pen_accuracy_spread pen_accuracy_error_of(const struct pen_accuracy_row_result *row,
                                                 enum pen_accuracy_metric metric);
struct pen_accuracy_spread pen_accuracy_time_of(const struct pen_accuracy_row_result *row);

/* The error below which a row is unresolved. */
double pen_accuracy_limit(const struct pen_accuracy *accuracy);

/* Whether the reference can tell the row's error. */
bool pen_accuracy_resolved(const struct pen_accuracy *accuracy,
                           const struct pen_accuracy_row_result *row);

/* Which rows are on the Pareto front: no row is both faster and more accurate, by the medians of
 * time and RMSE. Unresolved rows count as equally accurate. Shape: front[] has a value for each
 * row. */
void pen_accuracy_front(const struct pen_accuracy *accuracy, bool *front);

/* The row with the shortest time whose error meets the target in 95 % of the runs; -1: none. */
int pen_accuracy_recommended(const struct pen_accuracy *accuracy);

/* A straight line through points (log x, log y), by least squares. */
struct pen_accuracy_line {
    double slope, low, high; /* with the 95 % interval of Student's t; equal for two points */
    double at_1;             /* y where x is 1 */
    bool known;              /* there are 3 points at least, of different x */
};
struct pen_accuracy_line pen_accuracy_fit(const double *x, const double *y, int count);

#endif
