/* SPDX-License-Identifier: MIT */
/* Verdicts on times, from an exact confidence interval of a median.
 *
 * Sort n independent values of one distribution: x(1), ..., x(n). The interval from x(k) to
 * x(n+1-k) misses the median of the distribution only if fewer than k values lie on one side of it.
 * The probability of that is at most 2 P(B < k), where B is binomial with n trials of probability
 * 1/2. The interval is valid for any distribution, and outliers do not move it.
 * Source: David and Nagaraja, "Order Statistics", 3rd ed., section 7.1.
 *
 * A benchmark looks at its intervals several times, until they are narrow enough. Each look is one
 * more chance of an error. So there are few looks, at 10, 20, 40, ... values. Look j, counted from
 * 0, may err with a probability of 0.05 / 2^(j+1). The sum of these is less than 0.05. So the
 * intervals of all looks together contain the median with a probability of 95 %, and any look may
 * be the last (Bonferroni's inequality). The end of a time budget adds one look, which the clock
 * sets and not the values. */
#ifndef PEN_STUDY_VERDICT_H
#define PEN_STUDY_VERDICT_H

#include <stdbool.h>

enum {
    PEN_PAIRS_MIN = 10,
    PEN_PAIRS_MAX = 640
}; /* counts of the first and the last look; each look doubles the count */

/* A confidence interval of a median. */
struct pen_confidence {
    double median, low, high; /* low and high are 0 if there is no interval */
    int count;                /* number of values */
    int spoiled;              /* number of values that may be wrong by any amount */
    bool bounded;             /* there is an interval from low to high */
};

/* The median. Sorts the values. The median of an even number of values is the mean of the middle
 * two.
 * Shape: count is at least 1. */
double pen_median(double *values, int count);

/* The largest k for which the interval from x(k) to x(count + 1 - k) errs with a probability of at
 * most alpha. 0: there is none.
 * Shape: count is 0 .. PEN_PAIRS_MAX. */
int pen_median_rank(int count, double alpha);

/* The probability with which a look may err. The first look is 0. */
double pen_look_alpha(int look);

/* The look that has `count` values: 0 for up to 10 values, 1 for up to 20, 2 for up to 40, ... */
int pen_look_of(int count);

/* The confidence interval of the median. Sorts the values. `spoiled` values may be wrong by any
 * amount. Each of them can shift the rank of a correct value by one, so k is reduced by their
 * number. There is no interval for fewer than PEN_PAIRS_MIN values.
 * Shape: count is 1 .. PEN_PAIRS_MAX. */
struct pen_confidence pen_median_interval(double *values, int count, int spoiled, double alpha);

/* The interval of a / b, where a and b are medians of independent values. If each of their
 * intervals errs with a probability of at most alpha / 2, this one errs with at most alpha. */
struct pen_confidence pen_confidence_quotient(const struct pen_confidence *a,
                                              const struct pen_confidence *b);

enum pen_verdict {
    PEN_VERDICT_UNDECIDED, /* the interval is too wide, or there is none */
    PEN_VERDICT_FASTER,    /* faster by more than the least effect */
    PEN_VERDICT_SLOWER,
    PEN_VERDICT_SAME,              /* the difference is smaller than the least effect */
    PEN_VERDICT_DIFFERENT_PICTURE, /* the times are not of the same work */
    PEN_VERDICT_BASELINE           /* the row is the baseline itself */
};

/* The verdict on a row, from the interval of its time over the baseline's time. With the least
 * effect e, the row is faster if the whole interval is below 1 / (1 + e), and slower if it is above
 * 1 + e. It is the same if the whole interval is between these limits. */
enum pen_verdict pen_verdict_of(const struct pen_confidence *ratio, double least_effect);

/* The name of a verdict: "undecided", "faster", "slower", "same", "different picture", "baseline".
 */
const char *pen_verdict_name(enum pen_verdict verdict);

#endif
