/* SPDX-License-Identifier: MIT */
/* Verdicts on times: an exact confidence interval of a median, and what it says.
 *
 * Between the order statistics x(k) and x(n + 1 - k) of n independent values lies the median of
 * their distribution, whatever that distribution is, unless fewer than k values are on one side of
 * it: with a probability of at least 1 - 2 P(B < k), B binomial with n trials of 1/2. No value need
 * be normal, and outliers move nothing. Source: David and Nagaraja, "Order Statistics", 3rd ed.,
 * section 7.1.
 *
 * Who looks at the interval again and again until it pleases errs more often than one look does. So
 * there are few looks, at 10, 20, 40, ... values, and look j (from 0) may err with a probability of
 * 0.05 / 2^(j + 1). These add up to less than 0.05 (Bonferroni's inequality): with a probability of
 * 95 % the intervals of all looks cover the median, whichever of them is the last. The end of a
 * budget of time is one more look, set by the clock and not by the values. */
#ifndef PEN_STUDY_VERDICT_H
#define PEN_STUDY_VERDICT_H

#include <stdbool.h>

enum { PEN_PAIRS_MIN = 10, PEN_PAIRS_MAX = 640 }; /* the first look; the last, a doubling of it */

struct pen_confidence {
    double median, low, high; /* low, high: 0 if there is no interval */
    int count;                /* of values */
    int spoiled;              /* of these, how many the interval leaves out of account */
    bool bounded;             /* low and high are an interval */
};

/* The median of some values, which it sorts: of an even number, the mean of the middle two. Shape:
 * count is at least 1. */
double pen_median(double *values, int count);

/* The largest k for which x(k) and x(count + 1 - k) err with a probability of at most alpha; 0 if
 * there is none. Shape: count is 0 .. PEN_PAIRS_MAX. */
int pen_median_rank(int count, double alpha);

/* The probability with which a look may err; looks count from 0. */
double pen_look_alpha(int look);

/* Which look `count` values are: 0 for 10, 1 for up to 20, 2 for up to 40, ... */
int pen_look_of(int count);

/* The interval of the median of some values, which it sorts. `spoiled` of them may be wrong by any
 * amount: as each can move the rank of a right one by one place, k is smaller by so many. There is
 * no interval of fewer than PEN_PAIRS_MIN values. Shape: count is 1 .. PEN_PAIRS_MAX. */
struct pen_confidence pen_median_interval(double *values, int count, int spoiled, double alpha);

/* The interval of a / b, where a and b are medians of independent values. If each of theirs errs
 * with a probability of at most alpha / 2, this one does with at most alpha. */
struct pen_confidence pen_confidence_quotient(const struct pen_confidence *a,
                                              const struct pen_confidence *b);

enum pen_verdict {
    PEN_VERDICT_UNDECIDED, /* the interval is too wide, or there is none */
    PEN_VERDICT_FASTER,    /* by more than the least effect */
    PEN_VERDICT_SLOWER,
    PEN_VERDICT_SAME,              /* the difference is smaller than the least effect */
    PEN_VERDICT_DIFFERENT_PICTURE, /* the times are not of the same work */
    PEN_VERDICT_BASELINE           /* nothing is to be compared */
};

/* What the interval of a ratio of times says, row's time / baseline's time. With the least effect
 * e: faster if all of it lies below 1 / (1 + e), slower if above 1 + e, the same if between. */
enum pen_verdict pen_verdict_of(const struct pen_confidence *ratio, double least_effect);

/* "undecided", "faster", "slower", "same", "different picture", "baseline". */
const char *pen_verdict_name(enum pen_verdict verdict);

#endif
