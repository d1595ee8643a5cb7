/* SPDX-License-Identifier: MIT */
/* The results of an accuracy study, computed from its runs. */
#ifndef PEN_STUDY_ACCURACY_SUMMARY_H
#define PEN_STUDY_ACCURACY_SUMMARY_H

#include "study/accuracy.h"

/* A median, and the quantiles of 5 % and 95 %. Quantiles are interpolated between neighbouring
 * values. */
struct pen_accuracy_spread {
    double median, low, high;
};

/* The error of a row by a metric, over the row's runs.
 * Shape: the row has run at least once. */
struct pen_accuracy_spread pen_accuracy_error_of(const struct pen_accuracy_row_result *row,
                                                 enum pen_metric metric);
/* The value of a metric that 95 % of the row's runs meet: an upper bound of errors, a lower bound
 * of PSNR and SSIM. */
double pen_accuracy_worst(const struct pen_accuracy_row_result *row, enum pen_metric metric);
struct pen_row_time pen_accuracy_time_of(const struct pen_accuracy_row_result *row);

/* A summary of how much of the processors all runs got. */
struct pen_runs_use pen_accuracy_use(const struct pen_accuracy *accuracy);

/* The error below which a row is unresolved. */
double pen_accuracy_limit(const struct pen_accuracy *accuracy);

/* Whether the row's error is at least pen_accuracy_limit, so that the reference can show it. */
bool pen_accuracy_resolved(const struct pen_accuracy *accuracy,
                           const struct pen_accuracy_row_result *row);

/* Finds the rows on the Pareto front. For such a row, no other row is both cheaper
 * (pen_row_cost_compare) and more accurate, by the median of RMSE. All unresolved rows count as
 * equally accurate.
 * Shape: front[] has a value for each row. */
void pen_accuracy_front(const struct pen_accuracy *accuracy, bool *front);

/* The recommended row. Its error meets the target in 95 % of the runs, and no other such row is
 * faster (pen_row_time_compare). Of several, it is the row with the fewest rays. -1: there is none,
 * or over half of the runs are spoiled. */
int pen_accuracy_recommended(const struct pen_accuracy *accuracy);

/* A straight line through points (log x, log y), by least squares. */
struct pen_accuracy_line {
    double slope, low, high; /* with the 95 % interval of Student's t */
    double at_1;             /* y where x is 1 */
    bool known;              /* there are at least 3 points, of different x */
};
struct pen_accuracy_line pen_accuracy_fit(const double *x, const double *y, int count);

/* The settings that are numbers of samples. pen_sample_keys has their names. */
enum pen_sample_kind { PEN_SAMPLE_PIXEL, PEN_SAMPLE_LENS, PEN_SAMPLE_LIGHT, PEN_SAMPLE_BLUR };
enum { PEN_SAMPLE_KINDS = 4 };
extern const char *const pen_sample_keys[PEN_SAMPLE_KINDS];

/* A row's number of samples of a kind. PEN_SAMPLE_PIXEL and PEN_SAMPLE_LENS both give the camera
 * rays of a pixel. With depth of field, this is the larger of both settings. */
double pen_sample_count(const struct pen_accuracy *accuracy, int row, enum pen_sample_kind kind);

/* A series: the rows that differ in one number of samples alone.
 *
 * Squares of independent errors add up. So the square of a row's error has two parts. The first
 * falls with N to the power of twice the expected slope. The second is a floor, which more samples
 * of this kind do not remove. Two rows determine both parts. While the floor is small, the fitted
 * slope is that of this kind of samples. Where the floor is most of the error, other settings cause
 * what remains. */
struct pen_accuracy_series {
    enum pen_sample_kind kind;
    int first, count;
    struct {
        int row;
        double samples, rmse;
    } point[PEN_ACCURACY_ROWS_MAX]; /* sorted by samples, the fewest first */
    double expected;                /* the expected slope of log error over log samples */
    struct pen_accuracy_line line;
    double floor;    /* share of the floor in the squared error of the last row; below 0: unknown */
    bool floored;    /* the floor's share is at least 3/4 */
    unsigned causes; /* if floored: a bit for each kind of samples that may cause the floor */
};

/* The series of all rows that differ from a row in one kind of samples alone. Without `all`, it has
 * only resolved rows. */
struct pen_accuracy_series pen_accuracy_series_of(const struct pen_accuracy *accuracy, int row,
                                                  enum pen_sample_kind kind, bool all);

/* Whether a row is the first of a series of this kind. */
bool pen_accuracy_begins_series(const struct pen_accuracy *accuracy, int row,
                                enum pen_sample_kind kind);

/* The setting that is expected to meet the target if no row does. Of several, it is the one with
 * the shortest expected render time. */
struct pen_accuracy_need {
    const char *setting; /* NULL: unknown */
    double samples, ms;
};
struct pen_accuracy_need pen_accuracy_needed(const struct pen_accuracy *accuracy);

#endif
