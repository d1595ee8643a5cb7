/* SPDX-License-Identifier: MIT */
/* Exact sums against whole numbers of 128 bits, and at the ends of the range of doubles. */
#include <math.h>
#include <stdlib.h>

#include "math/exact_sum.h"
#include "support/random.h"
#include "support/suite.h"

__extension__ typedef __int128 wide;

static double whole(struct random *r, int bits)
{
    double size = (double)(random_bits(r) >> (64 - bits));
    return random_bits(r) & 1 ? -size : size;
}

/* Products of whole numbers of 40 bits times a power of two, some of which cancel; the power is
 * anything from 2^-3220 to 2^2700. */
START_TEST(test_exact_sum__is_exact)
{
    struct random r = random_begin(1);
    for (int i = 0; i < 100000; i++) {
        struct pen_exact_sum sum = {{0}};
        int power[3], at = 0, exponent;
        for (int k = 0; k < 3; k++) {
            power[k] = (int)random_below(&r, 1950) - 1050;
            at += power[k];
        }
        wide truth = 0;
        for (int n = (int)random_below(&r, 20); n > 0; n--) {
            double a = whole(&r, 1 + (int)random_below(&r, 40)),
                   b = whole(&r, 1 + (int)random_below(&r, 40)), c = whole(&r, 40);
            double *factor[3] = {&a, &b, &c};
            pen_exact_add(&sum, ldexp(a, power[0]), ldexp(b, power[1]), ldexp(c, power[2]));
            truth += (wide)a * (wide)b * (wide)c;
            if (random_below(&r, 2) == 0)
                continue;
            *factor[random_below(&r, 3)] *= -1; /* all but the last bit cancels */
            a += random_below(&r, 2);
            pen_exact_add(&sum, ldexp(a, power[0]), ldexp(b, power[1]), ldexp(c, power[2]));
            truth += (wide)a * (wide)b * (wide)c;
        }
        int sign = (truth > 0) - (truth < 0);
        double value = pen_exact_value(&sum, &exponent);
        ck_assert_int_eq(pen_exact_sign(&sum), sign);
        ck_assert(sign == 0 ? value == 0 : fabs(value) >= 0.5 && fabs(value) < 1);
        if (sign != 0) {
            wide got = (wide)ldexp(value, exponent - at),
                 off = got > truth ? got - truth : truth - got;
            ck_assert(off <= (truth < 0 ? -truth : truth) >> 52);
        }
    }
}
END_TEST

START_TEST(test_exact_sum__reaches_from_the_least_to_the_greatest)
{
    const double least = 0x1p-1074, most = 0x1.fffffffffffffp1023;
    struct pen_exact_sum sum = {{0}};
    int exponent;
    pen_exact_add(&sum, most, most, most);
    pen_exact_add(&sum, least, -least, least);
    ck_assert(pen_exact_sign(&sum) == 1);
    pen_exact_add(&sum, most, -most, most);
    ck_assert(pen_exact_value(&sum, &exponent) == -0.5 && exponent == -3221);
    pen_exact_add(&sum, least, least, least);
    ck_assert(pen_exact_value(&sum, &exponent) == 0 && pen_exact_sign(&sum) == 0);
}
END_TEST

START_TEST(test_exact_sum__normals)
{
    const struct pen_vec3 far[3] = {{1e300, 1e300, 0}, {-1e300, -1e300, 0}, {0, 1e-300, 0}};
    struct pen_vec3 n = pen_exact_normal(far, 3);
    ck_assert(n.x == 0 && n.y == 0 && n.z < 0);
    const struct pen_vec3 line[3] = {{1, 1, 1}, {3, 3, 3}, {1e-300, 1e-300, 1e-300}};
    n = pen_exact_normal(line, 3);
    ck_assert(n.x == 0 && n.y == 0 && n.z == 0);
    const struct pen_vec3 square[4] = {{5, 5, 1}, {6, 5, 1}, {6, 6, 1}, {5, 6, 1}};
    n = pen_exact_normal(square, 4);
    ck_assert(n.x == 0 && n.y == 0 && n.z == 0.5);
    const struct pen_vec3 one_ulp[3] = {{0, 0, 0}, {3, 3, 0}, {1, 1 + 0x1p-52, 0}};
    ck_assert(pen_exact_normal(one_ulp, 3).z == 0.75);
}
END_TEST

PEN_SUITE("exact_sum", test_exact_sum__is_exact,
          test_exact_sum__reaches_from_the_least_to_the_greatest, test_exact_sum__normals)
