/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "math/scale.h"
#include "support/random.h"
#include "support/suite.h"

static int same_bits(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

/* Any finite double, of every exponent, subnormals included. */
static double any_finite(struct random *r)
{
    for (;;) {
        uint64_t bits = random_bits(r);
        double x;
        memcpy(&x, &bits, sizeof x);
        if (isfinite(x))
            return x;
    }
}

START_TEST(test_scale__exponent_is_that_of_frexp)
{
    struct random r = random_begin(11);
    const double edges[] = {
        0, -0.0, 1, 0.5, 0x1p-1022, 0x1p-1074, 0x1.8p-1060, 0x1p1023, 0x1.fffffffffffffp1023};
    for (int i = 0; i < 200000; i++) {
        double x = i < 9 ? edges[i] : any_finite(&r);
        int wanted;
        frexp(x, &wanted);
        ck_assert_msg(pen_exponent(x) == wanted, "seed %llu: %a", (unsigned long long)r.seed, x);
    }
    ck_assert_int_eq(pen_exponent(INFINITY), 0);
    ck_assert_int_eq(pen_exponent(NAN), 0);
}
END_TEST

START_TEST(test_scale__scaling_is_that_of_ldexp)
{
    struct random r = random_begin(12);
    for (int i = 0; i < 500000; i++) {
        double x = any_finite(&r);
        int e = (int)(random_bits(&r) % 4400) - 2200;
        ck_assert_msg(same_bits(pen_scale2(x, e), ldexp(x, e)), "seed %llu: %a by %d",
                      (unsigned long long)r.seed, x, e);
    }
}
END_TEST

PEN_SUITE("scale", test_scale__exponent_is_that_of_frexp, test_scale__scaling_is_that_of_ldexp)
