/* SPDX-License-Identifier: MIT */
/* The elementary functions against __float128, on ordinary and on hard ranges. Each test prints its
 * worst case. fn.h promises 1 ulp. The tests require of each function the smaller error for which
 * it was built. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "math/fn.h"
#include "support/random.h"
#include "support/suite.h"

__extension__ typedef __float128 quad;
quad acosq(quad x);
quad cosq(quad x);
quad expq(quad x);
quad fabsq(quad x);
quad logq(quad x);
quad powq(quad x, quad y);
quad sinq(quad x);

/* Arguments per range; the environment variable PEN_N asks for a longer search. */
static int N;

struct worst {
    const char *what;
    double bound, ulp, x, y;
    struct random random;
    long count, beside; /* arguments; of these, results beside the correctly rounded one */
};

/* Log-uniform in size. */
static double spread(struct random *state, double lo, double hi)
{
    return exp(random_in(state, log(lo), log(hi)));
}

static double of_bits(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* The spacing of doubles at the exact result; beyond the range, that of the last binade. */
static double ulp_of(quad exact)
{
    double size = (double)fabsq(exact);
    if (size < 0x1p-1022)
        return 0x1p-1074;
    if (isinf(size))
        return 0x1p971;
    return ldexp(1.0, ilogb(size) - 52);
}

/* Overflow is right if the exact value is beyond the largest double by half an ulp at least. */
static double error(double got, quad exact)
{
    if (isinf(got))
        return fabsq(exact) >= (quad)0x1.fffffffffffffp1023 + (quad)0x1p970 ? 0 : INFINITY;
    return (double)(fabsq((quad)got - exact) / ulp_of(exact));
}

static void note(struct worst *w, double got, quad exact, double x, double y)
{
    double e = error(got, exact);
    w->count++;
    if (!(e <= w->ulp))
        w->ulp = e, w->x = x, w->y = y;
}

/* Subnormal results: within `bound` times 2^-1074 of the exact result, and not more than one double
 * beside the correctly rounded one, which may happen since they round twice. */
static void note_subnormal(struct worst *w, double got, quad exact, double x, double y)
{
    note(w, got, exact, x, y);
    double beside = fabs(got - (double)exact) / 0x1p-1074;
    ck_assert_msg(beside <= 1, "%s: %g doubles off at x=%a y=%a", w->what, beside, x, y);
    w->beside += beside > 0;
}

static void report(const struct worst *w)
{
    printf("%s: worst %.4f ulp of %ld at x=%a y=%a (seed %llu)\n", w->what, w->ulp, w->count, w->x,
           w->y, (unsigned long long)w->random.seed);
    ck_assert_msg(w->ulp <= w->bound, "%s: %.4f ulp at x=%a y=%a", w->what, w->ulp, w->x, w->y);
}

static struct worst begin(const char *what, double bound, uint64_t seed)
{
    const char *count = getenv("PEN_N");
    N = count ? atoi(count) : 40000;
    return (struct worst){.what = what, .bound = bound, .random = random_begin(seed)};
}

/* The bound of a result that is rounded twice: 0.57 ulp of at most half a spacing, and half of
 * one. */
#define SUBNORMAL 0.785

static void report_subnormal(const struct worst *w)
{
    report(w);
    printf("%s: %ld not correctly rounded\n", w->what, w->beside);
    ck_assert_int_gt(w->beside, 0);
}

static void check_exp(struct worst *w, double x)
{
    note(w, pen_exp(x), expq(x), x, 0);
}

START_TEST(test_fn__exp_is_within_its_bound)
{
    struct worst w = begin("exp", 0.58, 1), tiny = begin("exp, subnormal results", SUBNORMAL, 1);
    struct random s = w.random;
    for (int i = 0; i < N; i++) {
        check_exp(&w, random_in(&s, -1, 1));
        check_exp(&w, random_in(&s, -708, 709.7));
        for (int k = 0; k < 2;
             k++) { /* all of them; the largest, whose first rounding shows most */
            double x = random_in(&s, k ? -709.08 : -746, -708.4);
            note_subnormal(&tiny, pen_exp(x), expq(x), x, 0);
        }
        check_exp(&w, random_in(&s, 709.7, 709.8));
        check_exp(&w, (random_bits(&s) & 1 ? 1 : -1) * spread(&s, 1e-300, 1));
        /* just beside a switch of table entries */
        check_exp(&w, ((double)(random_bits(&s) % 4000) - 1999.5) * (M_LN2 / 128) *
                          random_in(&s, 1, 1 + 1e-12));
    }
    report(&w);
    report_subnormal(&tiny);
}
END_TEST

START_TEST(test_fn__exp_at_its_edges)
{
    ck_assert(pen_exp(0) == 1 && pen_exp(-0.0) == 1);
    ck_assert(pen_exp(INFINITY) == INFINITY && pen_exp(-INFINITY) == 0);
    ck_assert(isnan(pen_exp(NAN)));
    ck_assert(pen_exp(0x1.62e42fefa39efp9) < INFINITY && pen_exp(0x1.62e42fefa39f0p9) == INFINITY);
    ck_assert(pen_exp(-0x1.74910d52d3051p9) == 0x1p-1074 && pen_exp(-0x1.74910d52d3052p9) == 0);
    ck_assert(pen_exp(1e308) == INFINITY && pen_exp(-1e308) == 0);
}
END_TEST

static void check_log(struct worst *w, double x)
{
    note(w, pen_ln(x), logq(x), x, 0);
}

START_TEST(test_fn__log_is_within_its_bound)
{
    struct worst w = begin("ln", 0.502, 2);
    struct random s = w.random;
    for (int i = 0; i < N; i++) {
        check_log(&w, random_in(&s, 0.5, 2));
        check_log(&w, 1 + (random_bits(&s) & 1 ? 1 : -1) * spread(&s, 1e-16, 0.1));
        check_log(&w, of_bits(1 + random_bits(&s) % UINT64_C(0x7FEFFFFFFFFFFFFF)));
        check_log(&w, of_bits(1 + random_bits(&s) % UINT64_C(0x000FFFFFFFFFFFFF))); /* subnormal */
        /* just beside a switch of table entries */
        check_log(&w, of_bits(UINT64_C(0x3fe6900000000000) + (random_bits(&s) % 128 << 45) - 2 +
                              random_bits(&s) % 4));
    }
    report(&w);
}
END_TEST

START_TEST(test_fn__log_at_its_edges)
{
    uint64_t one = UINT64_C(0x3FF0000000000000);
    ck_assert(pen_ln(1) == 0 && pen_ln(0) == -INFINITY && pen_ln(-0.0) == -INFINITY);
    ck_assert(isnan(pen_ln(-1)) && isnan(pen_ln(NAN)) && isnan(pen_ln(-INFINITY)));
    ck_assert(pen_ln(INFINITY) == INFINITY);
    ck_assert(pen_ln(of_bits(one + 1)) == 0x1p-52 - 0x1p-105 &&
              pen_ln(of_bits(one - 1)) == -0x1p-53);
}
END_TEST

/* Subnormal results are noted apart. */
static void check_pow(struct worst w[2], double x, double y)
{
    quad exact = powq(x, y);
    if (exact < (quad)0x1p-1022)
        note_subnormal(&w[1], pen_pow(x, y), exact, x, y);
    else
        note(&w[0], pen_pow(x, y), exact, x, y);
}

START_TEST(test_fn__pow_is_within_its_bound)
{
    struct worst w[2] = {begin("pow", 0.58, 3), begin("pow, subnormal results", SUBNORMAL, 3)};
    struct random s = w[0].random;
    for (int i = 0; i < N; i++) {
        double x = random_in(&s, 0, 1),
               near = 1 + (random_bits(&s) & 1 ? 1 : -1) * spread(&s, 1e-16, 1e-3);
        check_pow(w, x, (double)(random_bits(&s) % 1001)); /* highlights */
        check_pow(w, x, random_in(&s, 0, 10));
        check_pow(w, x, 1 / 2.4);
        check_pow(w, near, spread(&s, 1, 1e6));
        check_pow(w, near, random_in(&s, 0, 1) * 745 / fabs(log(near))); /* beyond 1e6 */
        check_pow(w, of_bits(1 + random_bits(&s) % UINT64_C(0x7FEFFFFFFFFFFFFF)),
                  random_in(&s, 0, 1));
        x = spread(&s, 1e-300, 1 - 1e-9);
        check_pow(w, x, random_in(&s, 600, 708.3) / -log(x)); /* to the brink of the subnormal */
        check_pow(w, x, random_in(&s, 708.4, 746) / -log(x));
        check_pow(w, x, random_in(&s, 708.4, 709.08) / -log(x)); /* the largest subnormals */
        x = spread(&s, 1 + 1e-9, 1e300);
        check_pow(w, x, random_in(&s, 709.7, 709.8) / log(x)); /* to the brink of overflow */
        check_pow(w, of_bits(1 + random_bits(&s) % UINT64_C(0x000FFFFFFFFFFFFF)),
                  random_in(&s, 0, 1));
    }
    report(&w[0]);
    report_subnormal(&w[1]);
}
END_TEST

START_TEST(test_fn__pow_at_its_edges)
{
    const double inf = INFINITY, below = 1 - 0x1p-53, above = 1 + 0x1p-52;
    ck_assert(pen_pow(0, 0) == 0 && pen_pow(0, 3) == 0 && pen_pow(-0.0, 2) == 0);
    ck_assert(pen_pow(-2, 2) == 0 && pen_pow(-2, 0) == 0 && pen_pow(-inf, 2) == 0);
    ck_assert(pen_pow(0.3, 0) == 1 && pen_pow(inf, 0) == 1 && pen_pow(5e-324, 0) == 1);
    ck_assert(pen_pow(1, 1e300) == 1 && pen_pow(1, inf) == 1 && pen_pow(1, 7.5) == 1);
    ck_assert(pen_pow(inf, 0.5) == inf && pen_pow(below, inf) == 0 && pen_pow(above, inf) == inf);
    ck_assert(pen_pow(below, 1e300) == 0 && pen_pow(above, 1e300) == inf);
    ck_assert(pen_pow(0.5, 1074) == 0x1p-1074 && pen_pow(0.5, 1076) == 0);
    ck_assert(pen_pow(2, 1023) == 0x1p1023 && pen_pow(2, 1024) == inf);
    ck_assert(pen_pow(5e-324, 1) == 5e-324 && pen_pow(0.1, 1) == 0.1 && pen_pow(3, 2) == 9);
    ck_assert(isnan(pen_pow(NAN, 2)) && isnan(pen_pow(NAN, 0)) && isnan(pen_pow(2, NAN)));
}
END_TEST

static void check_sincos(struct worst *w, double x)
{
    double sine, cosine;
    pen_sincos(x, &sine, &cosine);
    note(w, sine, sinq(x), x, 0);
    note(w, cosine, cosq(x), x, 1);
}

START_TEST(test_fn__sincos_is_within_its_bound)
{
    struct worst w = begin("sincos", 0.83, 4);
    struct random s = w.random;
    for (int i = 0; i < N; i++) {
        check_sincos(&w, random_in(&s, -4, 4));
        check_sincos(&w, random_in(&s, -0x1p20, 0x1p20));
        check_sincos(&w, (random_bits(&s) & 1 ? 1 : -1) * spread(&s, 1e-300, 1));
        /* the doubles next to a multiple of pi/4, where one of them vanishes or they are equal */
        double close = (double)(random_bits(&s) % (1 << 20)) * M_PI_4;
        check_sincos(&w, nextafter(close, random_bits(&s) & 1 ? INFINITY : -INFINITY));
        check_sincos(&w, close);
    }
    report(&w);
}
END_TEST

/* Reduced in degrees, which is exact, so that the reference keeps its precision near zeros. */
static void check_sincos_deg(struct worst *w, double x)
{
    double sine, cosine, quarters = rint(x / 90);
    quad angle = ((quad)x - 90 * (quad)quarters) * (acosq(0) / 90);
    quad s = sinq(angle), c = cosq(angle);
    long k = (long)quarters & 3;
    pen_sincos_deg(x, &sine, &cosine);
    note(w, sine, k == 0 ? s : k == 1 ? c : k == 2 ? -s : -c, x, 0);
    note(w, cosine, k == 0 ? c : k == 1 ? -s : k == 2 ? -c : s, x, 1);
}

START_TEST(test_fn__sincos_deg_is_within_its_bound)
{
    struct worst w = begin("sincos_deg", 0.83, 5);
    struct random s = w.random;
    for (int i = 0; i < N; i++) {
        check_sincos_deg(&w, random_in(&s, -360, 360));
        check_sincos_deg(&w, random_in(&s, -0x1p20, 0x1p20));
        check_sincos_deg(&w, (random_bits(&s) & 1 ? 1 : -1) * spread(&s, 1e-300, 1));
        double close = (double)(random_bits(&s) % 20000) * 45;
        check_sincos_deg(&w, nextafter(close, random_bits(&s) & 1 ? INFINITY : -INFINITY));
        check_sincos_deg(&w, (double)(random_bits(&s) % 1000000) * 0.5);
    }
    report(&w);
}
END_TEST

START_TEST(test_fn__sincos_deg_is_exact_where_it_can_be)
{
    static const double sine_of[12] = {0, .5, 0, 1, 0, .5, 0, -.5, 0, -1, 0, -.5};
    for (int i = -12 * 1000; i <= 12 * 1000; i++) {
        double s, c;
        int at = ((i % 12) + 12) % 12;
        pen_sincos_deg(30.0 * i, &s, &c);
        if (at % 3 == 0 || sine_of[at] != 0)
            ck_assert_msg(s == sine_of[at], "sin %d = %a", 30 * i, s);
        if (at % 3 == 0 || sine_of[(at + 3) % 12] != 0)
            ck_assert_msg(c == sine_of[(at + 3) % 12], "cos %d = %a", 30 * i, c);
    }
}
END_TEST

START_TEST(test_fn__sincos_outside_its_range_is_nan)
{
    const double far[] = {0x1.0000000000001p20, -1e300, INFINITY, -INFINITY, NAN};
    for (size_t i = 0; i < sizeof far / sizeof far[0]; i++) {
        double s = 0, c = 0;
        pen_sincos(far[i], &s, &c);
        ck_assert(isnan(s) && isnan(c));
        s = c = 0;
        pen_sincos_deg(far[i], &s, &c);
        ck_assert(isnan(s) && isnan(c));
    }
}
END_TEST

/* The same bits whatever the compiler and its options: a sum over many results. */
START_TEST(test_fn__bits_are_the_same_everywhere)
{
    uint64_t hash = 0;
    struct random s = {6, 6};
    for (int i = 0; i < 40000; i++) {
        double value[7], x = random_in(&s, 0, 1), y = random_in(&s, 0, 1);
        y *= (double)(1 << random_bits(&s) % 20);
        value[0] = pen_exp((x - 0.5) * 1400);
        value[1] = pen_ln(x * y);
        value[2] = pen_pow(x, y);
        pen_sincos(y, &value[3], &value[4]);
        pen_sincos_deg(y, &value[5], &value[6]);
        for (int j = 0; j < 7; j++) {
            uint64_t bits;
            memcpy(&bits, &value[j], sizeof bits);
            hash = (hash ^ bits) * UINT64_C(0x9E3779B97F4A7C15);
            hash ^= hash >> 32;
        }
    }
    ck_assert_uint_eq(hash, UINT64_C(0x1FF2604B09EDBD73));
}
END_TEST

PEN_SUITE("fn", test_fn__exp_is_within_its_bound, test_fn__exp_at_its_edges,
          test_fn__log_is_within_its_bound, test_fn__log_at_its_edges,
          test_fn__pow_is_within_its_bound, test_fn__pow_at_its_edges,
          test_fn__sincos_is_within_its_bound, test_fn__sincos_deg_is_within_its_bound,
          test_fn__sincos_deg_is_exact_where_it_can_be, test_fn__sincos_outside_its_range_is_nan,
          test_fn__bits_are_the_same_everywhere)
