/* SPDX-License-Identifier: MIT */
/* Intervals of medians. Their ranks are compared with sums of binomial coefficients. The intervals
 * are looked at until they are narrow, and the test counts how often they contain the median of
 * simulated times. */
#include <math.h>
#include <string.h>

#include "study/verdict.h"
#include "support/random.h"
#include "support/suite.h"

/* P(B < k) for n trials of 1/2, from Pascal's triangle. */
static long double binomial_below(int n, int k)
{
    static long double row[PEN_PAIRS_MAX + 1];
    long double sum = 0;
    memset(row, 0, sizeof row);
    row[0] = 1;
    for (int i = 1; i <= n; i++)
        for (int j = i; j >= 0; j--)
            row[j] = (row[j] + (j ? row[j - 1] : 0)) / 2;
    for (int j = 0; j < k; j++)
        sum += row[j];
    return sum;
}

START_TEST(test_verdict__ranks_are_the_largest_that_err_rarely_enough)
{
    static const int counts[] = {1, 5, 6, 9, 10, 11, 20, 40, 77, 80, 160, 320, 640};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        for (int look = -1; look < 7; look++) {
            const int n = counts[i], k = pen_median_rank(n, pen_look_alpha(look));
            const long double alpha = 0.05L / powl(2, look + 1);
            ck_assert_int_le(k, n / 2);
            ck_assert_msg(2 * binomial_below(n, k) <= alpha, "%d of %d, look %d", k, n, look);
            ck_assert_msg(2 * binomial_below(n, k + 1) > alpha, "%d of %d, look %d", k, n, look);
        }
    }
    ck_assert_int_eq(pen_median_rank(10, 0.05), 2);
    ck_assert_int_eq(pen_median_rank(5, 0.05), 0);
}
END_TEST

START_TEST(test_verdict__looks_are_doublings_and_err_less_than_five_percent_together)
{
    double sum = 0;
    for (int look = 0, pairs = PEN_PAIRS_MIN; pairs <= PEN_PAIRS_MAX; look++, pairs *= 2) {
        ck_assert_int_eq(pen_look_of(pairs), look);
        ck_assert_int_eq(pen_look_of(pairs + 1), look + 1);
        sum += pen_look_alpha(look);
    }
    ck_assert_int_eq(pen_look_of(PEN_PAIRS_MAX), 6);
    ck_assert(sum + pen_look_alpha(7) < 0.05);
}
END_TEST

START_TEST(test_verdict__interval_is_between_order_statistics)
{
    double values[] = {9, 1, 8, 2, 7, 3, 6, 4, 5, 10};
    struct pen_confidence all = pen_median_interval(values, 10, 0, 0.05);
    ck_assert(all.bounded && all.low == 2 && all.high == 9 && all.median == 5.5);
    struct pen_confidence one = pen_median_interval(values, 10, 1, 0.05);
    ck_assert(one.bounded && one.low == 1 && one.high == 10 && one.spoiled == 1);
    struct pen_confidence two = pen_median_interval(values, 10, 2, 0.05);
    ck_assert(!two.bounded && two.median == 5.5);
    struct pen_confidence few = pen_median_interval(values, 9, 0, 0.05);
    ck_assert(!few.bounded && few.median == 5 && few.count == 9);
}
END_TEST

static struct pen_confidence interval(double low, double high)
{
    return (struct pen_confidence){
        .median = (low + high) / 2, .low = low, .high = high, .count = 10, .bounded = true};
}

START_TEST(test_verdict__follows_from_interval_and_least_effect)
{
    static const struct {
        double low, high;
        enum pen_verdict verdict;
    } cases[] = {{0.90, 0.98, PEN_VERDICT_FASTER},    {0.90, 0.99, PEN_VERDICT_UNDECIDED},
                 {0.99, 1.01, PEN_VERDICT_SAME},      {0.985, 1.02, PEN_VERDICT_SAME},
                 {1.01, 1.03, PEN_VERDICT_UNDECIDED}, {1.0201, 1.09, PEN_VERDICT_SLOWER},
                 {0.9, 1.1, PEN_VERDICT_UNDECIDED}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct pen_confidence ratio = interval(cases[i].low, cases[i].high);
        ck_assert_int_eq(pen_verdict_of(&ratio, 0.02), cases[i].verdict);
        ratio.bounded = false;
        ck_assert_int_eq(pen_verdict_of(&ratio, 0.02), PEN_VERDICT_UNDECIDED);
    }
}
END_TEST

START_TEST(test_verdict__quotient_has_the_extremes_of_both_intervals)
{
    struct pen_confidence a = interval(2, 4), b = interval(1, 2);
    struct pen_confidence q = pen_confidence_quotient(&a, &b);
    ck_assert(q.bounded && q.low == 1 && q.high == 4 && q.median == 2);
    b.bounded = false;
    ck_assert(!pen_confidence_quotient(&a, &b).bounded);
}
END_TEST

/* A ratio of times with median 1 and long tails on both sides, as under a load that comes and goes.
 */
static double noisy_ratio(struct random *random)
{
    const double u = random_unit(random), v = random_unit(random);
    const double side = u < 0.5 ? 1 - 2 * u : 2 * u - 1;
    const double size = 0.01 * side + (v < 0.2 ? 0.5 * side * side : 0);
    return u < 0.5 ? 1 / (1 + size) : 1 + size;
}

/* Measures like a benchmark until the interval is narrower than `width`. The first `spoiled` values
 * are far off. */
static struct pen_confidence measure(struct random *random, double width, int spoiled)
{
    double values[PEN_PAIRS_MAX], sorted[PEN_PAIRS_MAX];
    struct pen_confidence out = {0};
    int count = 0;
    for (int look = 0; look <= pen_look_of(PEN_PAIRS_MAX); look++) {
        for (; count < PEN_PAIRS_MIN << look; count++)
            values[count] = count < spoiled ? 3 : noisy_ratio(random);
        memcpy(sorted, values, (size_t)count * sizeof *sorted);
        out = pen_median_interval(sorted, count, spoiled, pen_look_alpha(look));
        if (out.bounded && out.high - out.low <= width)
            break;
    }
    return out;
}

START_TEST(test_verdict__intervals_cover_the_median_though_one_looks_until_they_are_narrow)
{
    enum { TRIALS = 4000 };
    static const int spoiled[] = {0, 4};
    struct random random = random_begin(20261124);
    for (size_t s = 0; s < 2; s++) {
        int missed = 0, stopped = 0;
        for (int i = 0; i < TRIALS; i++) {
            struct pen_confidence last = measure(&random, 0.01, spoiled[s]);
            missed += last.low > 1 || last.high < 1;
            stopped += last.count < PEN_PAIRS_MAX;
        }
        /* 5 % of 4000 is 200. A count with this mean exceeds 255 once in 20 000 times. */
        ck_assert_msg(missed <= 255, "%d of %d missed, seed %llu", missed, (int)TRIALS,
                      (unsigned long long)random.seed);
        ck_assert_msg(stopped > TRIALS / 2, "%d stopped early", stopped);
    }
}
END_TEST

PEN_SUITE("verdict", test_verdict__ranks_are_the_largest_that_err_rarely_enough,
          test_verdict__looks_are_doublings_and_err_less_than_five_percent_together,
          test_verdict__interval_is_between_order_statistics,
          test_verdict__follows_from_interval_and_least_effect,
          test_verdict__quotient_has_the_extremes_of_both_intervals,
          test_verdict__intervals_cover_the_median_though_one_looks_until_they_are_narrow)
