/* SPDX-License-Identifier: MIT */
/* The error of a pixel's mean, as estimated from the two halves of its samples (render/adaptive.h),
 * for typical contents of a pixel: edges, corners, lines, disks, waves, stripes and checks, at
 * random places. The truth is a mean over a fine grid. */
#include <math.h>

#include "math/sample.h"
#include "support/random.h"
#include "support/suite.h"

/* Coordinates from the middle of a feature, along it and across. */
typedef double feature_fn(double u, double v, double size);

static double edge(double u, double v, double size)
{
    (void)v;
    (void)size;
    return u < 0;
}

static double corner(double u, double v, double size)
{
    (void)size;
    return u < 0 && v < 0;
}

static double line(double u, double v, double size)
{
    (void)v;
    return fabs(u) < size / 2;
}

static double disk(double u, double v, double size)
{
    return u * u + v * v < size * size;
}

static double wave(double u, double v, double size)
{
    (void)v;
    return 0.5 + 0.5 * sin(2 * acos(-1) * u / size);
}

static double stripes(double u, double v, double size)
{
    (void)v;
    return fmod(floor(u / size) + 1000, 2);
}

static double checks(double u, double v, double size)
{
    return fmod(floor(u / size) + floor(v / size) + 1000, 2);
}

/* A feature at a random place in the pixel. */
struct placed {
    feature_fn *at;
    double size, right, down, x, y;
};

static double value_at(const struct placed *p, double x, double y)
{
    const double dx = x - p->x, dy = y - p->y;
    return p->at(p->right * dx + p->down * dy, p->right * dy - p->down * dx, p->size);
}

static double truth_of(const struct placed *p)
{
    enum { GRID = 96 };
    double sum = 0;
    for (int i = 0; i < GRID * GRID; i++)
        sum += value_at(p, (i % GRID + 0.5) / GRID, (i / GRID + 0.5) / GRID);
    return sum / (GRID * GRID);
}

/* 2 to 2^SIZES samples. */
enum { SIZES = 5, FEATURES = 2000 };

/* Sums of squares over features, by the logarithm of the number of samples. */
struct squares {
    double told[SIZES];        /* a quarter of that of the halves' difference */
    double error[SIZES];       /* of the mean */
    double independent[SIZES]; /* of the mean of two sequences of half as many */
};

static double sum_of(const struct placed *p, uint64_t hash, uint32_t first, uint32_t end)
{
    double sum = 0;
    for (uint32_t i = first; i < end; i++) {
        const struct pen_point2 point = pen_sobol2(hash, i);
        sum += value_at(p, point.x, point.y);
    }
    return sum;
}

static void add_feature(struct squares *s, const struct placed *p, uint64_t hash)
{
    const double truth = truth_of(p);
    for (int i = 0; i < SIZES; i++) {
        const uint32_t half = UINT32_C(1) << i;
        const double a = sum_of(p, hash, 0, half) / half,
                     b = sum_of(p, hash, half, 2 * half) / half;
        const double other = sum_of(p, pen_mix64(hash), 0, half) / half;
        const double off = (a + b) / 2 - truth, independent = (a + other) / 2 - truth;
        s->told[i] += (a - b) * (a - b) / 4;
        s->error[i] += off * off;
        s->independent[i] += independent * independent;
    }
}

static struct squares squares_of(feature_fn *at, double degrees, double size)
{
    struct random random = random_begin(20261125);
    struct squares s = {.told = {0}};
    for (int i = 0; i < FEATURES; i++) {
        const double turn = 2 * acos(-1),
                     angle = degrees >= 0 ? degrees / 360 * turn : turn * random_unit(&random);
        struct placed p = {.at = at, .size = size, .right = cos(angle), .down = sin(angle)};
        p.x = random_unit(&random);
        p.y = random_unit(&random);
        add_feature(&s, &p, pen_mix64((uint64_t)i));
    }
    return s;
}

/* An edge: V is what the halves of twice as many samples have in common, n^-1.5, so that they tell
 * 1.83 V; 3 V for one along the pixel's sides, whose error falls as n^-2. Independent sequences are
 * worse by 2^0.5, and by 2. */
START_TEST(test_halves__of_an_edge_tell_more_than_its_error_and_make_it_smaller)
{
    static const struct {
        double degrees, told, worse;
    } rows[] = {{-1, 1.83, 1.41}, {0, 3, 2}, {45, 1.83, 1.41}, {135, 1.83, 1.41}, {26, 1.83, 1.41}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const struct squares s = squares_of(edge, rows[i].degrees, 0);
        for (int n = 2; n < SIZES; n++) {
            const double told = s.told[n] / s.error[n], worse = s.independent[n] / s.error[n];
            ck_assert_msg(fabs(told / rows[i].told - 1) < 0.2,
                          "%g degrees, %d samples: %g of the error", rows[i].degrees, 2 << n, told);
            ck_assert_msg(fabs(worse / rows[i].worse - 1) < 0.2,
                          "%g degrees, %d samples: independent ones %g", rows[i].degrees, 2 << n,
                          worse);
        }
    }
}
END_TEST

/* Of two samples a feature may be in the same state for both because of how they are placed: then
 * halves tell too little, at worst 0.74 of the mean square error. From four on they do not, but for
 * checks along the pixel's sides, a quarter of a pixel wide (0.8, eight samples). */
START_TEST(test_halves__tell_enough_whatever_is_in_the_pixel)
{
    static const struct {
        const char *name;
        feature_fn *at;
        double degrees, size;
    } rows[] = {{"corner", corner, -1, 0},
                {"line 0.1", line, -1, 0.1},
                {"line 0.1, 45", line, 45, 0.1},
                {"disk 0.2", disk, -1, 0.2},
                {"disk 0.1", disk, -1, 0.1},
                {"wave 1, 45", wave, 45, 1},
                {"wave 0.7, 45", wave, 45, 0.707},
                {"wave 0.5", wave, -1, 0.5},
                {"stripes 0.5", stripes, 0, 0.5},
                {"stripes 0.5, 45", stripes, 45, 0.5},
                {"stripes 0.35", stripes, 45, 0.3536},
                {"stripes 0.2", stripes, -1, 0.2},
                {"checks 0.5", checks, 0, 0.5},
                {"checks 0.25", checks, 0, 0.25},
                {"checks 0.1", checks, -1, 0.1},
                {"checks 0.35", checks, 45, 0.3536}};
    double least = 1;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const struct squares s = squares_of(rows[i].at, rows[i].degrees, rows[i].size);
        for (int n = 0; n < SIZES; n++) {
            const double told = s.told[n] / s.error[n];
            const double enough = n == 0 ? 0.7 : rows[i].at == checks ? 0.75 : 0.9;
            least = told < least ? told : least;
            ck_assert_msg(told > enough, "%s, %d samples: %g of the error", rows[i].name, 2 << n,
                          told);
        }
    }
    ck_assert_msg(least < 0.8, "the worst is %g: the comment is wrong", least);
}
END_TEST

PEN_SUITE("halves", test_halves__of_an_edge_tell_more_than_its_error_and_make_it_smaller,
          test_halves__tell_enough_whatever_is_in_the_pixel)
