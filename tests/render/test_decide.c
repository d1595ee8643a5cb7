/* SPDX-License-Identifier: MIT */
/* Estimates and decisions of adaptive rendering, without rays. Samples are drawn from distributions
 * with known means and variances, so the true errors are known. */
#include <math.h>
#include <string.h>

#include "render/adaptive.h"
#include "support/random.h"
#include "support/suite.h"

static struct pen_settings settings;
static struct pen_thread_pool *pool;

static struct pen_adaptive *begin(int width, int height, enum pen_transfer_name transfer)
{
    struct pen_status st;
    settings = pen_settings_default();
    settings.width = width;
    settings.height = height;
    settings.transfer = (int)transfer;
    settings.max_samples = 1 << 20;
    struct pen_adaptive *a = pen_adaptive_new(&settings, &st);
    pool = pen_thread_pool_new(2, &st);
    ck_assert(a && pool);
    return a;
}

static void end(struct pen_adaptive *a)
{
    pen_thread_pool_free(pool);
    pen_adaptive_free(a);
}

/* Sets a half of a pixel's samples to so many of one grey value. */
static void set_grey(struct pen_pixel_sums *sums, int half, double value, uint32_t samples)
{
    sums->kept[half] = samples;
    sums->samples = 2 * samples;
    for (int c = 0; c < 3; c++)
        sums->sum[half][c] = value * samples;
}

/* The sRGB curve as IEC 61966-2-1 has it. */
static double srgb(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

/* If each half is one of two values with equal probability, whatever the other is, the mean of the
 * two is right when they differ, and off to either side when they agree: the estimates are right in
 * the mean over all cases. With the sRGB curve that takes both the halves' difference and what the
 * curve adds. */
START_TEST(test_decide__estimates_are_right_in_the_mean_over_all_cases)
{
    static const double values[][2] = {{0, 1}, {0.1, 0.6}, {0, 0.02}};
    enum { CASES = 4 };
    struct pen_adaptive *a = begin(1, 1, PEN_SETTING_SRGB);
    for (size_t v = 0; v < sizeof values / sizeof values[0]; v++) {
        const double right = srgb((values[v][0] + values[v][1]) / 2);
        double estimated = 0, truth = 0;
        for (int i = 0; i < CASES; i++) {
            double mean = 0;
            for (int half = 0; half < 2; half++) {
                set_grey(a->sums, half, values[v][i >> half & 1], 4);
                mean += values[v][i >> half & 1] / 2;
            }
            pen_adaptive_estimate(a, 0, (float[3]){0});
            ck_assert_double_eq_tol((double)a->estimates[0].value[0], srgb(mean), 1e-6);
            estimated += (double)a->estimates[0].error / CASES;
            truth += (srgb(mean) - right) * (srgb(mean) - right) / CASES;
        }
        ck_assert_msg(truth > 0 && fabs(estimated / truth - 1) < 1e-5, "%g, %g: %g instead of %g",
                      values[v][0], values[v][1], estimated, truth);
    }
    end(a);
}
END_TEST

START_TEST(test_decide__what_is_brighter_than_white_is_white)
{
    struct pen_adaptive *a = begin(1, 1, PEN_SETTING_LINEAR);
    set_grey(a->sums, 0, 2, 4);
    set_grey(a->sums, 1, 4, 4);
    pen_adaptive_estimate(a, 0, (float[3]){0});
    ck_assert(a->estimates[0].value[1] == 1 && a->estimates[0].error == 0);
    set_grey(a->sums, 0, 0.5,
             4); /* the mean is white, this is off by a half, the other by nothing */
    pen_adaptive_estimate(a, 0, (float[3]){0});
    ck_assert(a->estimates[0].value[1] == 1);
    ck_assert_double_eq_tol((double)a->estimates[0].error, 0.125, 1e-6);
    end(a);
}
END_TEST

static struct pen_decision decide(struct pen_adaptive *a, double target)
{
    struct pen_status st;
    struct pen_decision d;
    const struct pen_goal goal = {target, UINT64_MAX};
    ck_assert(pen_adaptive_decide(a, pool, &goal, &d, &st));
    return d;
}

/* All samples of the left half are 0.1, all of the right 0.9. An edge that none of n samples of a
 * pixel has seen cuts off a strip at most about 2 / n wide; if n are as even as can be, 1 / n. It
 * may be in the pixels on either side, so the mean square error of these two columns is between
 * (0.8 / n)^2 / 6 and (1.6 / n)^2 / 6. */
START_TEST(test_decide__an_edge_between_pixels_is_as_uncertain_as_what_samples_can_miss)
{
    enum { SIDE = 12 };
    struct pen_adaptive *a = begin(SIDE, SIDE, PEN_SETTING_LINEAR);
    for (uint32_t each = 2; each <= 512; each *= 4) {
        for (int i = 0; i < SIDE * SIDE; i++) {
            for (int half = 0; half < 2; half++)
                set_grey(&a->sums[i], half, i % SIDE < SIDE / 2 ? 0.1 : 0.9, each);
            pen_adaptive_estimate(a, (size_t)i, (float[3]){0});
        }
        const double n = 2 * each, least = sqrt(0.64 / (n * n) / 6 * 2 / SIDE);
        struct pen_decision d = decide(a, least);
        ck_assert_msg(d.error >= least && d.error <= 2 * least, "%g: %g, not %g to %g", n, d.error,
                      least, 2 * least);
        ck_assert(!d.met && !d.done);
        ck_assert_uint_gt(pen_adaptive_select(a, d.level), 0);
        for (int i = 0; i < SIDE * SIDE; i++) /* at least both columns; nothing that is far away */
            ck_assert(i % SIDE == SIDE / 2 - 1 || i % SIDE == SIDE / 2
                          ? a->wanted[i]
                          : abs(2 * (i % SIDE) + 1 - SIDE) <= 5 || !a->wanted[i]);
    }
    end(a);
}
END_TEST

/* The standard deviation of a sample at a place. */
typedef double deviation_fn(int x, int y);

static double normal(struct random *random)
{
    const double radius = sqrt(-2 * log(1 - random_unit(random)));
    return radius * cos(2 * acos(-1) * random_unit(random));
}

/* Takes the samples of a round: normal, around 0.5. The sum of n has n times the variance of
 * one. */
static void take_samples(struct pen_adaptive *a, struct random *random, deviation_fn *deviation)
{
    const int width = a->settings->width;
    for (int i = 0; i < width * a->settings->height; i++) {
        struct pen_pixel_sums *sums = &a->sums[i];
        if (!a->wanted[i])
            continue;
        sums->samples += pen_adaptive_begin_pixel(a, (size_t)i);
        pen_pixel_double(sums);
        for (int half = 0; half < 2; half++) {
            const double more = sums->samples / 2 - sums->kept[half];
            const double noise = deviation(i % width, i / width) * sqrt(more) * normal(random);
            sums->kept[half] += more;
            for (int c = 0; c < 3; c++)
                sums->sum[half][c] += 0.5 * more + noise;
        }
        pen_adaptive_estimate(a, (size_t)i, (float[3]){0});
    }
}

static int rounds; /* that the last refine took */

/* Goes on until nothing is left to be done. */
static struct pen_decision refine(struct pen_adaptive *a, struct random *random,
                                  deviation_fn *deviation, double target)
{
    struct pen_decision d;
    for (rounds = 1;; rounds++) {
        ck_assert_int_lt(rounds, 100);
        take_samples(a, random, deviation);
        d = decide(a, target);
        if (d.done)
            return d;
        ck_assert_uint_gt(pen_adaptive_select(a, d.level), 0);
    }
}

static double even(int x, int y)
{
    (void)x;
    (void)y;
    return 0.01;
}

/* The intervals are promised to cover the error with PEN_ADAPTIVE_CONFIDENCE. */
START_TEST(test_decide__intervals_cover_the_true_error)
{
    enum { PICTURES = 400 };
    struct random random = random_begin(20261124);
    int missed = 0;
    for (int i = 0; i < PICTURES; i++) {
        struct pen_adaptive *a = begin(16, 16, PEN_SETTING_LINEAR);
        take_samples(a, &random, even);
        const double truth = 0.01 / sqrt(a->sums[0].samples);
        const struct pen_decision d = decide(a, truth);
        missed += truth < d.low || truth > d.high;
        ck_assert(d.met == (d.high <= truth));
        end(a);
    }
    /* Less three standard deviations. */
    const double share = 1 - PEN_ADAPTIVE_CONFIDENCE, mean = PICTURES * share;
    ck_assert_msg(missed <= mean + 3 * sqrt(mean * (1 - share)), "%d of %d, seed %llu", missed,
                  (int)PICTURES, (unsigned long long)random.seed);
}
END_TEST

/* Gives pixels eight samples whose halves differ by normal numbers, such that they tell a mean
 * square error of `told` in the mean; with half of them they told `factors` times that, the first
 * of these for every second pixel. */
static void set_doubled(struct pen_adaptive *a, struct random *random, double told,
                        const double factors[2])
{
    for (int i = 0; i < a->settings->width * a->settings->height; i++) {
        struct pen_pixel_sums *sums = &a->sums[i];
        const double earlier = normal(random), apart = sqrt(told) * normal(random);
        sums->before = (float)(factors[i % 2] * told * earlier * earlier);
        for (int half = 0; half < 2; half++)
            set_grey(sums, half, half == 0 ? 0.5 - apart : 0.5 + apart, 4);
        pen_adaptive_estimate(a, (size_t)i, (float[3]){0});
    }
    pen_adaptive_select(a, 0); /* the pilot has been refined */
}

/* If errors fall by a factor R from doubling to doubling, and halves of 2n samples tell what n are
 * worse than 2n, the error is 1 / (R - 1) of what they tell: the sum of all that doublings without
 * end would still bring. In a mixture of pixels with R from 2 to 4 it is at most what the line from
 * 1 at 2 to 1/3 at 4 has at the mean of R. That is what is taken, as far as the R of an edge. */
START_TEST(test_decide__what_halves_tell_too_much_is_known_from_the_doubling_before)
{
    static const double factors[][2] = {{0.5, 0.5}, {1, 1},   {2, 2}, {2.3, 2.3}, {2.6, 2.6},
                                        {3, 3},     {16, 16}, {2, 3}, {2, 4}};
    const double told = 1e-6, edge = pow(2, 1.5);
    struct random random = random_begin(20261129);
    for (size_t i = 0; i < sizeof factors / sizeof factors[0]; i++) {
        const double *f = factors[i], mean = (f[0] + f[1]) / 2;
        const double part = 1 - (fmin(fmax(mean, 2), edge) - 2) / 3;
        const double truth = (1 / (fmax(f[0], 2) - 1) + 1 / (fmax(f[1], 2) - 1)) / 2;
        struct pen_adaptive *a = begin(256, 256, PEN_SETTING_LINEAR);
        set_doubled(a, &random, told, f);
        const struct pen_decision d = decide(a, 1);
        const double error = d.error * d.error / told, low = d.low * d.low / told;
        ck_assert_msg(error > 0.98 * part && error < 1.06 * part,
                      "%g and %g: %g of what halves tell instead of %g, seed %llu", f[0], f[1],
                      error, part, (unsigned long long)random.seed);
        ck_assert_msg(error > 0.98 * truth, "%g and %g: %g, the truth is %g", f[0], f[1], error,
                      truth);
        ck_assert(low > 0.9 / (edge - 1) && low < 1 / (edge - 1) && d.high > d.error);
        end(a);
    }
}
END_TEST

/* Few pixels tell no ratio: then nothing is taken off. */
START_TEST(test_decide__few_pixels_do_not_tell_what_halves_tell_too_much)
{
    enum { PICTURES = 60 };
    const double told = 1e-6, factors[2] = {2.6, 2.6};
    struct random random = random_begin(20261130);
    double mean = 0;
    for (int i = 0; i < PICTURES; i++) {
        struct pen_adaptive *a = begin(16, 16, PEN_SETTING_LINEAR);
        set_doubled(a, &random, told, factors);
        const struct pen_decision d = decide(a, 1);
        mean += d.error * d.error / told / PICTURES;
        end(a);
    }
    ck_assert_msg(mean > 0.92, "%g, seed %llu", mean, (unsigned long long)random.seed);
}
END_TEST

/* From 0.3 to 0.3e-7: sums of so different errors are rounded, so that their order shows. */
static double of_all_sizes(int x, int y)
{
    return 0.3 * pow(10, -((x * 5 + y * 3) % 8));
}

START_TEST(test_decide__is_the_same_to_the_bit_for_any_number_of_threads)
{
    struct pen_status st;
    struct random random = random_begin(20261125);
    struct pen_adaptive *a = begin(128, 128, PEN_SETTING_SRGB);
    for (int picture = 0; picture < 30; picture++) {
        struct pen_decision want = {.level = 0};
        uint64_t first = 0;
        memset(a->wanted, 1, 128 * 128);
        take_samples(a, &random, of_all_sizes);
        take_samples(a, &random, of_all_sizes); /* with what was told before */
        pen_adaptive_select(a, 0);              /* the pilot has been refined */
        for (int threads = 1; threads <= 5; threads += 2) {
            pen_thread_pool_free(pool);
            pool = pen_thread_pool_new(threads, &st);
            const struct pen_decision d = decide(a, 1e-3);
            const uint64_t selected = pen_adaptive_select(a, d.level);
            if (threads == 1) {
                want = d;
                first = selected;
            }
            ck_assert(d.error == want.error && d.low == want.low && d.high == want.high);
            ck_assert(d.level == want.level && selected == first);
        }
        for (int i = 0; i < 128 * 128; i++)
            a->sums[i] = (struct pen_pixel_sums){.samples = 0};
    }
    end(a);
}
END_TEST

/* An eighth of the picture, all of whose samples are soon taken. */
static double noisy_edge(int x, int y)
{
    (void)y;
    return x < 8 ? 0.32 : 0.04;
}

/* With all 64 samples everywhere the mean square error is 0.00022, three quarters of the target's.
 * Of this the eighth leaves 0.0002, so that the rest must get better than a picture of that
 * error. */
START_TEST(test_decide__what_capped_pixels_leave_is_made_up_for_by_others)
{
    struct random random = random_begin(20261126);
    struct pen_adaptive *a = begin(64, 64, PEN_SETTING_LINEAR);
    settings.max_samples = 64;
    const struct pen_decision d = refine(a, &random, noisy_edge, sqrt(0.0003));
    ck_assert_int_le(rounds, 14); /* else each takes the least */
    ck_assert_msg(d.met && d.capped == 0, "%g, seed %llu", d.high, (unsigned long long)random.seed);
    ck_assert_uint_eq(pen_adaptive_spread(a).most, 64);
    end(a);
    a = begin(64, 64, PEN_SETTING_LINEAR);
    settings.max_samples = 64;
    const struct pen_decision more = refine(a, &random, noisy_edge, 1e-4);
    ck_assert(more.done && !more.met && more.capped == 64 * 64);
    ck_assert(pen_adaptive_spread(a).least == 64 && pen_adaptive_spread(a).most == 64);
    end(a);
}
END_TEST

static double noisy_quarter(int x, int y)
{
    (void)y;
    return x < 8 ? 0.2 : 0.02;
}

/* Of independent samples with deviations s, N for each pixel in the mean, the least error is
 * mean(s) / sqrt(N), which numbers that are proportional to s have (Neyman, 1934). With
 * equal numbers everywhere N would be 2.4 times that. Powers of two, and the margin by which the
 * target is met, take the rest. */
START_TEST(test_decide__samples_go_where_they_lower_the_error_most)
{
    enum { PICTURES = 5 };
    const double target = 0.003, best = pow((0.25 * 0.2 + 0.75 * 0.02) / target, 2);
    struct random random = random_begin(20261127);
    double mean = 0;
    for (int i = 0; i < PICTURES; i++) {
        struct pen_adaptive *a = begin(32, 32, PEN_SETTING_LINEAR);
        ck_assert(refine(a, &random, noisy_quarter, target).met);
        mean += pen_adaptive_spread(a).mean / PICTURES;
        end(a);
    }
    ck_assert_msg(mean > 0.9 * best && mean < 1.8 * best, "%g, the least is %g, seed %llu", mean,
                  best, (unsigned long long)random.seed);
}
END_TEST

static double noisy_spot(int x, int y)
{
    return x == 32 && y == 32 ? 0.5 : 0.001;
}

/* One pixel and its neighbours would do, round after round. A round costs a pass over the picture,
 * so it takes a thirty-second of the samples at least. */
START_TEST(test_decide__rounds_have_a_least_size)
{
    struct random random = random_begin(20261128);
    struct pen_adaptive *a = begin(64, 64, PEN_SETTING_LINEAR);
    take_samples(a, &random, noisy_spot);
    const struct pen_decision d = decide(a, decide(a, 1).error / 2);
    ck_assert(!d.done);
    const uint64_t selected = pen_adaptive_select(a, d.level);
    ck_assert_msg(a->wanted[32 * 64 + 32] && selected >= 64 * 64 / 32 && selected < 64 * 64 / 8,
                  "%llu, seed %llu", (unsigned long long)selected, (unsigned long long)random.seed);
    end(a);
}
END_TEST

START_TEST(test_decide__spread_tells_of_how_many_samples_pixels_have)
{
    struct pen_adaptive *a = begin(10, 10, PEN_SETTING_LINEAR);
    for (int i = 0; i < 100; i++) /* 60, 34 and 6 pixels */
        a->sums[i].samples = i < 60 ? 2 : i < 94 ? 8 : 64;
    const struct pen_sample_spread s = pen_adaptive_spread(a);
    ck_assert(s.least == 2 && s.median == 2 && s.p95 == 64 && s.most == 64);
    ck_assert_double_eq_tol(s.mean, 0.6 * 2 + 0.34 * 8 + 0.06 * 64, 1e-12);
    for (int i = 94; i < 96; i++)
        a->sums[i].samples = 8;
    ck_assert_uint_eq(pen_adaptive_spread(a).p95, 8);
    end(a);
}
END_TEST

PEN_SUITE("decide", test_decide__estimates_are_right_in_the_mean_over_all_cases,
          test_decide__what_is_brighter_than_white_is_white,
          test_decide__an_edge_between_pixels_is_as_uncertain_as_what_samples_can_miss,
          test_decide__intervals_cover_the_true_error,
          test_decide__what_halves_tell_too_much_is_known_from_the_doubling_before,
          test_decide__few_pixels_do_not_tell_what_halves_tell_too_much,
          test_decide__is_the_same_to_the_bit_for_any_number_of_threads,
          test_decide__what_capped_pixels_leave_is_made_up_for_by_others,
          test_decide__samples_go_where_they_lower_the_error_most,
          test_decide__rounds_have_a_least_size,
          test_decide__spread_tells_of_how_many_samples_pixels_have)
