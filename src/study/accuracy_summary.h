/* SPDX-License-Identifier: MIT */
/* What follows from the runs of an accuracy study. */
#ifndef PEN_STUDY_ACCURACY_SUMMARY_H
#define PEN_STUDY_ACCURACY_SUMMARY_H

#include "study/accuracy.h"

/* A median, and the quantiles of 5 and 95 %, between the neighbouring values. */
struct pen_accuracy_spread {
    double median, low, high;
};

/* Of a row that was run: its error by one metric; its times. */
struct pen_accuracy_spread pen_accuracy_error_of(const struct pen_accuracy_row_result *row,
                                                 enum pen_metric metric);
/* What its error is no worse than in 95 % of the runs. */
double pen_accuracy_worst(const struct pen_accuracy_row_result *row, enum pen_metric metric);
struct pen_row_time pen_accuracy_time_of(const struct pen_accuracy_row_result *row);

/* What all runs had of the processors. */
struct pen_runs_use pen_accuracy_use(const struct pen_accuracy *accuracy);

/* The error below which a row is unresolved. */
double pen_accuracy_limit(const struct pen_accuracy *accuracy);

/* Whether the reference can tell the row's error. */
bool pen_accuracy_resolved(const struct pen_accuracy *accuracy,
                           const struct pen_accuracy_row_result *row);

/* Which rows are on the Pareto front: no row is both cheaper (pen_row_cost_compare) and more
 * accurate, by the median of RMSE. Unresolved rows count as equally accurate. Shape: front[] has a
 * value for each row. */
void pen_accuracy_front(const struct pen_accuracy *accuracy, bool *front);

/* The cheapest row whose error meets the target in 95 % of the runs: of those than which no other
 * is surely quicker, the one with the fewest rays. -1: none, or over half of the runs are spoiled.
 */
int pen_accuracy_recommended(const struct pen_accuracy *accuracy);

/* A straight line through points (log x, log y), by least squares. */
struct pen_accuracy_line {
    double slope, low, high; /* with the 95 % interval of Student's t; equal for two points */
    double at_1;             /* y where x is 1 */
    bool known;              /* there are 3 points at least, of different x */
};
struct pen_accuracy_line pen_accuracy_fit(const double *x, const double *y, int count);

/* The settings that are numbers of samples. */
enum pen_sample_kind { PEN_SAMPLE_PIXEL, PEN_SAMPLE_LENS, PEN_SAMPLE_LIGHT, PEN_SAMPLE_BLUR };
enum { PEN_SAMPLE_KINDS = 4 };
extern const char *const pen_sample_keys[PEN_SAMPLE_KINDS];

/* How often a row samples that: camera rays for both PEN_SAMPLE_PIXEL and PEN_SAMPLE_LENS, of which
 * a pixel seen through a lens has as many as the larger setting says. */
double pen_sample_count(const struct pen_accuracy *accuracy, int row, enum pen_sample_kind kind);

/* The rows that differ in one number of samples alone.
 *
 * Squares of independent errors add up: the square of a row's error is a part that falls with N to
 * the power of twice the expected slope, and a floor, which more samples of this kind do not
 * remove. Two rows give both. While the floor is a small part, the slope is that of this kind of
 * samples; where it is most, other settings decide what is left. */
struct pen_accuracy_series {
    enum pen_sample_kind kind;
    int first, count;
    struct {
        int row;
        double samples, rmse;
    } point[PEN_ACCURACY_ROWS_MAX]; /* by samples, the fewest first */
    double expected;                /* slope */
    struct pen_accuracy_line line;
    double floor;    /* its part of the squared error of the last row; below 0: not known */
    bool floored;    /* it is three quarters or more */
    unsigned causes; /* if so: a bit for each kind of samples that the floor may come from */
};

/* The series of all rows that differ from one in a setting alone. Without `all`, only of resolved
 * rows. */
struct pen_accuracy_series pen_accuracy_series_of(const struct pen_accuracy *accuracy, int row,
                                                  enum pen_sample_kind kind, bool all);

/* Whether there is a series of the kind, of which this is the first row. */
bool pen_accuracy_begins_series(const struct pen_accuracy *accuracy, int row,
                                enum pen_sample_kind kind);

/* The setting with which a picture is expected to meet the target, if no row does: the one that
 * takes the shortest time. */
struct pen_accuracy_need {
    const char *setting; /* NULL: none is known */
    double samples, ms;
};
struct pen_accuracy_need pen_accuracy_needed(const struct pen_accuracy *accuracy);

#endif
