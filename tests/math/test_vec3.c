/* SPDX-License-Identifier: MIT */
/* Vectors and boxes. The boundary cases of the classroom's ray tracer (H035) are ordinary values
 * here, and every operation rounds as written. */
#include <math.h>
#include <stdbool.h>

#include "math/box.h"
#include "math/vec3.h"
#include "support/random.h"
#include "support/suite.h"

static bool is(struct pen_vec3 v, double x, double y, double z)
{
    return v.x == x && v.y == y && v.z == z;
}

START_TEST(test_vec3__arithmetic)
{
    struct pen_vec3 a = pen_vec3(1, 2, 3), b = pen_vec3(-4, 5, 0.5);
    ck_assert(is(pen_add(a, b), -3, 7, 3.5) && is(pen_sub(a, b), 5, -3, 2.5));
    ck_assert(is(pen_scale(a, -2), -2, -4, -6) && is(pen_mul(a, b), -4, 10, 1.5));
    ck_assert(is(pen_neg(a), -1, -2, -3) && pen_dot(a, b) == 7.5);
    ck_assert(is(pen_along(a, b, 2), -7, 12, 4));
    ck_assert(pen_length(pen_vec3(2, -3, 6)) == 7 && pen_norm1(b) == 9.5);
    ck_assert(is(pen_normalize(pen_vec3(0, -2, 0)), 0, -1, 0));
    ck_assert(pen_component(a, 0) == 1 && pen_component(a, 1) == 2 && pen_component(a, 2) == 3);
}
END_TEST

/* H035: the classroom tracer threw an exception for these. */
START_TEST(test_vec3__h035_zero_is_a_vector)
{
    struct pen_vec3 a = pen_vec3(1, 2, 3), zero = pen_vec3(0, 0, 0);
    ck_assert(is(pen_sub(a, a), 0, 0, 0) && is(pen_add(a, pen_neg(a)), 0, 0, 0));
    ck_assert(is(pen_scale(a, 0), 0, 0, 0) && pen_dot(a, zero) == 0 && pen_length(zero) == 0);
    ck_assert(is(pen_along(a, zero, 1e300), 1, 2, 3));
}
END_TEST

START_TEST(test_vec3__normalized_has_unit_length)
{
    struct random r = random_begin(1);
    for (int i = 0; i < 100000; i++) {
        double size = ldexp(1, (int)random_below(&r, 201) - 100);
        struct pen_vec3 v =
            pen_vec3(random_in(&r, -size, size), random_in(&r, -size, size), random_in(&r, -1, 1));
        double off = pen_length(pen_normalize(v)) - 1;
        if (!(fabs(off) <= 6 * 0x1p-53))
            ck_abort_msg("seed %llu: off by %g", (unsigned long long)r.seed, off);
    }
}
END_TEST

/* Each operator is one rounding, in the order written. */
START_TEST(test_vec3__operations_round_as_written)
{
    struct random r = random_begin(2);
    for (int i = 0; i < 100000; i++) {
        struct pen_vec3 a = pen_vec3(random_in(&r, -1, 1), random_in(&r, -1, 1), 0.3);
        struct pen_vec3 b = pen_vec3(random_in(&r, -1, 1), random_in(&r, -1, 1), 0.7);
        volatile double x = a.x * b.x, y = a.y * b.y, z = a.z * b.z;
        volatile double xy = x + y, step = b.x * b.y;
        if (!(pen_dot(a, b) == xy + z && pen_along(a, b, b.y).x == a.x + step))
            ck_abort_msg("seed %llu: a product was fused", (unsigned long long)r.seed);
    }
}
END_TEST

START_TEST(test_box__grows_by_points_and_boxes)
{
    struct pen_box b = pen_box_empty();
    ck_assert(pen_box_half_area(b) == 0 && b.lo.x > b.hi.x);
    b = pen_box_add_point(b, pen_vec3(1, 2, 3));
    ck_assert(is(b.lo, 1, 2, 3) && is(b.hi, 1, 2, 3) && pen_box_half_area(b) == 0);
    b = pen_box_add_point(b, pen_vec3(-1, 5, 3));
    ck_assert(is(b.lo, -1, 2, 3) && is(b.hi, 1, 5, 3) && pen_box_half_area(b) == 6);
    struct pen_box other = {pen_vec3(0, 0, 0), pen_vec3(1, 1, 4)};
    b = pen_box_union(b, other);
    ck_assert(is(b.lo, -1, 0, 0) && is(b.hi, 1, 5, 4));
    ck_assert(pen_box_half_area(b) == 10 + 20 + 8 && is(pen_box_center(b), 0, 2.5, 2));
    b = pen_box_union(pen_box_empty(), other);
    ck_assert(is(b.lo, 0, 0, 0) && is(b.hi, 1, 1, 4));
    b = pen_box_union(other, pen_box_empty());
    ck_assert(is(b.lo, 0, 0, 0) && is(b.hi, 1, 1, 4));
}
END_TEST

START_TEST(test_box__center_does_not_overflow)
{
    struct pen_box b = {pen_vec3(1e308, -1e308, 0), pen_vec3(1.5e308, 1e308, 5e-324)};
    struct pen_vec3 c = pen_box_center(b);
    ck_assert(c.x == 1.25e308 && c.y == 0 && c.z >= 0 && c.z <= 5e-324);
}
END_TEST

PEN_SUITE("vec3", test_vec3__arithmetic, test_vec3__h035_zero_is_a_vector,
          test_vec3__normalized_has_unit_length, test_vec3__operations_round_as_written,
          test_box__grows_by_points_and_boxes, test_box__center_does_not_overflow)
