/* SPDX-License-Identifier: MIT */
/* Affine maps against __float128, exact results where the header promises them, and the bounds of
 * the tests that refuse a map. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "math/transform.h"
#include "support/random.h"
#include "support/suite.h"

__extension__ typedef __float128 quad;
quad acosq(quad x);
quad cosq(quad x);
quad sinq(quad x);
quad sqrtq(quad x);

static const double U = 0x1p-53;

static struct pen_vec3 random_vector(struct random *r)
{
    return pen_vec3(random_in(r, -1, 1), random_in(r, -1, 1), random_in(r, -1, 1));
}

static struct pen_transform random_transform(struct random *r)
{
    struct pen_transform f;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++)
            f.m[i][j] = random_in(r, -1, 1);
    }
    return f;
}

static bool equal(struct pen_vec3 a, struct pen_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static struct pen_transform diagonal(double x, double y, double z)
{
    return (struct pen_transform){{{x, 0, 0, 0}, {0, y, 0, 0}, {0, 0, z, 0}}};
}

START_TEST(test_transform__quarter_turns_about_axes_are_exact)
{
    struct random r = random_begin(1);
    const double lengths[] = {1, 49, 1e-300, 1e300, 0.1, 5e-324};
    for (int i = 0; i < 2000; i++) {
        struct pen_vec3 v = random_vector(&r);
        double length = lengths[i % 6];
        int turns = (int)random_below(&r, 4001) - 2000;
        struct pen_vec3 x = pen_rotate(v, pen_vec3(length, 0, 0), 90.0 * turns);
        struct pen_vec3 y = pen_rotate(v, pen_vec3(0, length, 0), 90.0 * turns);
        struct pen_vec3 z = pen_rotate(v, pen_vec3(0, 0, length), 90.0 * turns);
        const int c[] = {1, 0, -1, 0}, s[] = {0, 1, 0, -1};
        double co = c[turns & 3], si = s[turns & 3];
        bool right = equal(x, pen_vec3(v.x, co * v.y - si * v.z, si * v.y + co * v.z)) &&
                     equal(y, pen_vec3(co * v.x + si * v.z, v.y, co * v.z - si * v.x)) &&
                     equal(z, pen_vec3(co * v.x - si * v.y, si * v.x + co * v.y, v.z));
        if (!right)
            ck_abort_msg("seed %llu: %d quarter turns, axis of length %g",
                         (unsigned long long)r.seed, turns, length);
    }
}
END_TEST

START_TEST(test_transform__rotation_is_accurate)
{
    struct random r = random_begin(2);
    double worst = 0;
    for (int i = 0; i < 20000; i++) {
        struct pen_vec3 v = random_vector(&r), k = random_vector(&r);
        double degrees = random_in(&r, -1000, 1000);
        struct pen_vec3 got = pen_rotate(v, k, degrees);
        quad angle = (quad)degrees * (acosq(0) / 90), c = cosq(angle), s = sinq(angle);
        quad length = sqrtq((quad)k.x * k.x + (quad)k.y * k.y + (quad)k.z * k.z);
        quad kx = k.x / length, ky = k.y / length, kz = k.z / length;
        quad along = (kx * v.x + ky * v.y + kz * v.z) * (1 - c);
        quad ex = v.x * c + (ky * v.z - kz * v.y) * s + kx * along;
        quad ey = v.y * c + (kz * v.x - kx * v.z) * s + ky * along;
        quad ez = v.z * c + (kx * v.y - ky * v.x) * s + kz * along;
        double dx = (double)(got.x - ex), dy = (double)(got.y - ey), dz = (double)(got.z - ez);
        double error = sqrt(dx * dx + dy * dy + dz * dz) / pen_length(v);
        worst = error > worst ? error : worst;
    }
    ck_assert_msg(worst < 7 * U, "worst %.2f u", worst / U);
}
END_TEST

START_TEST(test_transform__make_scales_then_turns_then_moves)
{
    struct pen_transform f = pen_transform_make(2, pen_vec3(0, 0, 3), 90, pen_vec3(10, 20, 30));
    ck_assert(equal(pen_transform_point(&f, pen_vec3(1, 0, 5)), pen_vec3(10, 22, 40)));
    ck_assert(equal(pen_transform_vector(&f, pen_vec3(1, 0, 5)), pen_vec3(0, 2, 10)));
    struct pen_transform same = pen_transform_make(1, pen_vec3(1, 2, 3), 0, pen_vec3(0, 0, 0));
    struct pen_transform identity = pen_transform_identity();
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++)
            ck_assert(same.m[i][j] == identity.m[i][j]);
    }
}
END_TEST

START_TEST(test_transform__compose_applies_the_inner_first)
{
    struct random r = random_begin(3);
    struct pen_transform turn = pen_transform_make(1, pen_vec3(0, 1, 0), 90, pen_vec3(0, 0, 0));
    struct pen_transform move = pen_transform_make(4, pen_vec3(1, 0, 0), 0, pen_vec3(1, 2, 3));
    struct pen_transform both = pen_transform_compose(&turn, &move);
    ck_assert(equal(pen_transform_point(&both, pen_vec3(1, 0, 0)), pen_vec3(3, 2, -5)));
    for (int i = 0; i < 20000; i++) {
        struct pen_transform f = random_transform(&r), g = random_transform(&r);
        struct pen_transform fg = pen_transform_compose(&f, &g);
        struct pen_vec3 p = random_vector(&r), inner = pen_transform_point(&g, p);
        struct pen_vec3 d = pen_sub(pen_transform_point(&fg, p), pen_transform_point(&f, inner));
        if (!(pen_norm1(d) < 64 * U))
            ck_abort_msg("seed %llu: off by %g u", (unsigned long long)r.seed, pen_norm1(d) / U);
    }
}
END_TEST

/* The image of a normal stays orthogonal to the image of its plane, and points to the same side. */
START_TEST(test_transform__normal_keeps_its_plane_and_its_side)
{
    struct random r = random_begin(4);
    int mirrored = 0;
    for (int i = 0; i < 20000; i++) {
        struct pen_transform f = random_transform(&r);
        const double(*e)[4] = (const double(*)[4])f.m;
        double det = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
                     e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                     e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
        if (fabs(det) < 0.01)
            continue;
        mirrored += det < 0;
        ck_assert_int_eq(pen_transform_orientation(&f), det < 0 ? -1 : 1);
        struct pen_vec3 n = random_vector(&r), a = random_vector(&r);
        struct pen_vec3 in_plane =
            pen_vec3(n.y * a.z - n.z * a.y, n.z * a.x - n.x * a.z, n.x * a.y - n.y * a.x);
        struct pen_vec3 m = pen_transform_normal(&f, n);
        struct pen_vec3 t = pen_transform_vector(&f, in_plane), o = pen_transform_vector(&f, n);
        double slant = fabs(pen_dot(m, t)) / (pen_length(m) * pen_length(t));
        if (!(slant < 1e-11 && pen_dot(m, o) > 0))
            ck_abort_msg("seed %llu: det %g slant %g side %g", (unsigned long long)r.seed, det,
                         slant, pen_dot(m, o));
    }
    ck_assert_int_gt(mirrored, 1000);
}
END_TEST

START_TEST(test_transform__normal_survives_any_scale)
{
    const double scales[] = {1e-200, 1e-100, 1, 1e100, 1e200, 0x1p-1000, 0x1p1000};
    for (int i = 0; i < 7; i++) {
        struct pen_transform f = diagonal(scales[i], scales[i], -scales[i]);
        struct pen_vec3 n = pen_normalize(pen_transform_normal(&f, pen_vec3(0.6, 0, 0.8)));
        ck_assert_msg(fabs(n.x - 0.6) < 4 * U && n.y == 0 && fabs(n.z + 0.8) < 4 * U,
                      "scale %g: %g %g %g", scales[i], n.x, n.y, n.z);
    }
    struct pen_transform f = diagonal(1, 1e-9, 1e9);
    struct pen_vec3 n = pen_transform_normal(&f, pen_vec3(0, 1, 1));
    ck_assert(fabs(n.z / n.y * 1e18 - 1) < 8 * U && n.x == 0);
    f = pen_transform_identity();
    ck_assert(equal(pen_transform_normal(&f, pen_vec3(0, -1, 0)), pen_vec3(0, -0.5, 0)));
}
END_TEST

START_TEST(test_transform__orientation_is_exact)
{
    struct pen_transform f = diagonal(2, 3, 5);
    ck_assert(pen_transform_orientation(&f) == 1);
    f = diagonal(1e-200, 1e-200, -1e-200); /* the determinant is not a double */
    ck_assert(pen_transform_orientation(&f) == -1);
    f = diagonal(1e300, 1e300, 1e300);
    ck_assert(pen_transform_orientation(&f) == 1);
    /* the product of the first two entries of the diagonal rounds from 23/16 times 2^-1074 to 1 */
    f = (struct pen_transform){
        {{0x1.7p-537, 0, 0x1p463, 0}, {0, 0x1p-537, 0, 0}, {1.25, 0, 0x1p1000, 0}}};
    ck_assert(pen_transform_orientation(&f) == 1);
    f = (struct pen_transform){{{1, 2, 3, 0}, {4, 5, 6, 0}, {7, 8, 9, 0}}};
    ck_assert(pen_transform_orientation(&f) == 0);
    f.m[2][2] = 10;
    ck_assert(pen_transform_orientation(&f) == -1);
    f.m[2][2] = nextafter(9, 0);
    ck_assert(pen_transform_orientation(&f) == 1);
}
END_TEST

static bool similar(struct pen_transform f, double *scale)
{
    *scale = -1;
    return pen_transform_similarity(&f, scale);
}

START_TEST(test_transform__similarity_is_recognised)
{
    double scale;
    ck_assert(similar(pen_transform_identity(), &scale) && scale == 1);
    ck_assert(similar(diagonal(3, -3, 3), &scale) && scale == 3);
    ck_assert(similar(diagonal(0.1, 0.1, 0.1), &scale) && fabs(scale - 0.1) < 0.1 * 4 * U);
    ck_assert(similar(diagonal(0x1p300, 0x1p300, 0x1p300), &scale) && scale == 0x1p300);
    ck_assert(similar(diagonal(1e-250, 1e-250, 1e-250), &scale));
    ck_assert(similar(pen_transform_make(7, pen_vec3(1, 2, 3), 37, pen_vec3(1, 1, 1)), &scale));
    ck_assert(fabs(scale - 7) < 7 * 8 * U);
    ck_assert(similar(diagonal(1, 1, 1 + 4e-7), &scale) &&
              !similar(diagonal(1, 1, 1 + 6e-7), &scale));
    ck_assert(!similar(diagonal(1, 1, 2), &scale) && !similar(diagonal(1, 1e-9, 1), &scale));
    ck_assert(!similar(diagonal(0, 0, 0), &scale) && !similar(diagonal(1, 1, NAN), &scale));
    struct pen_transform shear = pen_transform_identity();
    shear.m[0][1] = 0.9e-6;
    ck_assert(similar(shear, &scale));
    shear.m[0][1] = 1.1e-6;
    ck_assert(!similar(shear, &scale));
    shear.m[0][1] = -1.1e-6;
    ck_assert(!similar(shear, &scale));
}
END_TEST

START_TEST(test_transform__flat_and_broken_maps_cannot_be_inverted)
{
    struct pen_transform f = diagonal(1e-300, 1e300, 1);
    ck_assert(pen_transform_invertible(
        &f)); /* the size of a map does not matter, only whether it is flat */
    f = diagonal(1, 0, 1);
    ck_assert(!pen_transform_invertible(&f));
    f = pen_transform_identity();
    f.m[0][1] = f.m[1][0] = 1;
    ck_assert(!pen_transform_invertible(&f));
    f.m[1][1] = 1 + 0x1p-52; /* the second column leaves the first by one ulp */
    ck_assert(pen_transform_invertible(&f));
    struct pen_vec3 n = pen_transform_normal(&f, pen_vec3(1, 1, 0x1p-40));
    ck_assert(n.x / n.z == 0x1p40 &&
              n.y == 0); /* of the sum of two columns, and a little of the third */
    const double broken[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 12 * 3; i++) {
        f = pen_transform_identity();
        f.m[i / 12][i % 4] = broken[i / 4 % 3];
        ck_assert(!pen_transform_invertible(&f));
    }
}
END_TEST

PEN_SUITE("transform", test_transform__quarter_turns_about_axes_are_exact,
          test_transform__rotation_is_accurate, test_transform__make_scales_then_turns_then_moves,
          test_transform__compose_applies_the_inner_first,
          test_transform__normal_keeps_its_plane_and_its_side,
          test_transform__normal_survives_any_scale, test_transform__orientation_is_exact,
          test_transform__similarity_is_recognised,
          test_transform__flat_and_broken_maps_cannot_be_inverted)
