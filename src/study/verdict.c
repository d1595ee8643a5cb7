/* SPDX-License-Identifier: MIT */
#include "study/verdict.h"

#include <math.h>
#include <stdlib.h>

int pen_median_rank(int count, double alpha)
{
    double term = ldexp(1, -count), below = 0; /* P(B = k), P(B < k) */
    int k = 0;
    while (k < count && 2 * (below + term) <= alpha) {
        below += term;
        term *= (double)(count - k) / (k + 1);
        k++;
    }
    return k;
}

double pen_look_alpha(int look)
{
    return ldexp(0.05, -(look + 1));
}

int pen_look_of(int count)
{
    int look = 0;
    for (int pairs = PEN_PAIRS_MIN; pairs < count; pairs *= 2)
        look++;
    return look;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double pen_median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, by_value);
    return (values[(count - 1) / 2] + values[count / 2]) / 2;
}

struct pen_confidence pen_median_interval(double *values, int count, int spoiled, double alpha)
{
    struct pen_confidence out = {
        .median = pen_median(values, count), .count = count, .spoiled = spoiled};
    const int k = pen_median_rank(count, alpha) - spoiled;
    if (count >= PEN_PAIRS_MIN && k > 0) {
        out.bounded = true;
        out.low = values[k - 1];
        out.high = values[count - k];
    }
    return out;
}

struct pen_confidence pen_confidence_quotient(const struct pen_confidence *a,
                                              const struct pen_confidence *b)
{
    struct pen_confidence out = {.count = a->count < b->count ? a->count : b->count,
                                 .spoiled = a->spoiled > b->spoiled ? a->spoiled : b->spoiled};
    if (b->median > 0)
        out.median = a->median / b->median;
    if (a->bounded && b->bounded && b->low > 0) {
        out.bounded = true;
        out.low = a->low / b->high;
        out.high = a->high / b->low;
    }
    return out;
}

enum pen_verdict pen_verdict_of(const struct pen_confidence *ratio, double least_effect)
{
    const double above = 1 + least_effect, below = 1 / above;
    if (!ratio->bounded)
        return PEN_VERDICT_UNDECIDED;
    if (ratio->high < below)
        return PEN_VERDICT_FASTER;
    if (ratio->low > above)
        return PEN_VERDICT_SLOWER;
    return ratio->low >= below && ratio->high <= above ? PEN_VERDICT_SAME : PEN_VERDICT_UNDECIDED;
}

const char *pen_verdict_name(enum pen_verdict verdict)
{
    static const char *const names[] = {"undecided",         "faster",  "slower", "same",
                                        "different picture", "baseline"};
    return names[verdict];
}
