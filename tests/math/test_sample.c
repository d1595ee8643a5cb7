/* SPDX-License-Identifier: MIT */
/* Sampling sequences are nets, uniform, independent of each other, and never change. */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "math/sample.h"
#include "support/suite.h"

static struct pen_sample_key key(uint32_t n)
{
    return (struct pen_sample_key){
        .seed = 7, .x = n % 512, .y = n / 512, .node = 1, .purpose = PEN_PURPOSE_LIGHT};
}

static uint64_t hash_of(uint32_t n)
{
    struct pen_sample_key k = key(n);
    return pen_sample_hash(&k);
}

/* Each of the 2^k boxes of size 2^-a x 2^-b, a + b = k, holds one of the first 2^k points. */
static void check_net(uint64_t hash, unsigned k, unsigned a)
{
    static unsigned char seen[1 << 10];
    memset(seen, 0, sizeof seen);
    for (uint32_t i = 0; i < 1u << k; i++) {
        struct pen_point2 p = pen_sobol2(hash, i);
        if (!(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1))
            ck_abort_msg("point %u is outside: %a %a", i, p.x, p.y);
        unsigned column = (unsigned)(p.x * (1u << a)), row = (unsigned)(p.y * (1u << (k - a)));
        unsigned box = column << (k - a) | row;
        if (seen[box])
            ck_abort_msg("hash %llx: box %u of %u x %u holds two of %u points",
                         (unsigned long long)hash, box, 1u << a, 1u << (k - a), 1u << k);
        seen[box] = 1;
    }
}

START_TEST(test_sample__sobol_prefixes_are_nets)
{
    for (uint32_t n = 0; n < 200; n++) {
        for (unsigned k = 0; k <= 10; k++) {
            for (unsigned a = 0; a <= k; a++)
                check_net(hash_of(n), k, a);
        }
    }
    for (unsigned a = 0; a <= 10; a++) {
        check_net(0, 10, a);
        check_net(UINT64_MAX, 10, a);
    }
}
END_TEST

enum { CELLS = 16, POINTS = 1 << 16 };

/* Pearson's statistic of 256 equally likely cells: mean 255, standard deviation 22.6. */
static double chi_square(const struct pen_point2 *points, int count)
{
    double hits[CELLS * CELLS] = {0}, expected = (double)count / (CELLS * CELLS), sum = 0;
    for (int i = 0; i < count; i++)
        hits[(int)(points[i].x * CELLS) * CELLS + (int)(points[i].y * CELLS)]++;
    for (int i = 0; i < CELLS * CELLS; i++)
        sum += (hits[i] - expected) * (hits[i] - expected) / expected;
    return sum;
}

static void check_uniform(const struct pen_point2 *points, const char *what)
{
    double chi = chi_square(points, POINTS);
    ck_assert_msg(chi > 255 - 5 * 22.6 && chi < 255 + 5 * 22.6, "%s: chi-square %.1f", what, chi);
}

/* The same point of many sets is uniform over the sets, whatever the point. */
START_TEST(test_sample__a_point_is_uniform_over_keys)
{
    static struct pen_point2 sobol[POINTS], random[POINTS];
    const uint32_t indices[] = {0, 1, 2, 3, 255, 4096, UINT32_MAX};
    for (size_t j = 0; j < sizeof indices / sizeof indices[0]; j++) {
        for (uint32_t n = 0; n < POINTS; n++) {
            sobol[n] = pen_sobol2(hash_of(n), indices[j]);
            random[n] = pen_random2(hash_of(n), indices[j]);
        }
        check_uniform(sobol, "sobol");
        check_uniform(random, "random");
    }
}
END_TEST

START_TEST(test_sample__random_points_of_one_key_are_uniform)
{
    static struct pen_point2 points[POINTS];
    for (uint32_t n = 0; n < 20; n++) {
        for (uint32_t i = 0; i < POINTS; i++)
            points[i] = pen_random2(hash_of(n), i);
        check_uniform(points, "random");
    }
}
END_TEST

/* Sets of different keys are independent: pairs of a coordinate of point i of one set and of point
 * i of the other fill the square evenly. If the order of points were not shuffled, the pairs would
 * fall into 16 of the 256 cells. */
START_TEST(test_sample__sets_are_independent)
{
    static struct pen_point2 pairs[4][POINTS];
    for (uint32_t n = 0; n < POINTS / 64; n++) {
        struct pen_sample_key near = key(n), other = key(n);
        near.x++;
        other.purpose = PEN_PURPOSE_LENS;
        uint64_t h = hash_of(n), hn = pen_sample_hash(&near), ho = pen_sample_hash(&other);
        for (uint32_t i = 0; i < 64; i++) {
            struct pen_point2 p = pen_sobol2(h, i), q = pen_sobol2(hn, i), o = pen_sobol2(ho, i);
            pairs[0][n * 64 + i] = (struct pen_point2){p.x, q.x};
            pairs[1][n * 64 + i] = (struct pen_point2){p.y, q.y};
            pairs[2][n * 64 + i] = (struct pen_point2){p.x, o.x};
            pairs[3][n * 64 + i] = (struct pen_point2){p.x, o.y};
        }
    }
    for (int j = 0; j < 4; j++)
        check_uniform(pairs[j], "pairs");
}
END_TEST

START_TEST(test_sample__pairs_within_one_set_fill_the_square)
{
    /* Also without the structure over keys: within one pixel, 256 points of two purposes. */
    double sum = 0;
    for (uint32_t n = 0; n < 400; n++) {
        struct pen_point2 pairs[256];
        struct pen_sample_key other = key(n);
        other.purpose = PEN_PURPOSE_LENS;
        uint64_t h = hash_of(n), ho = pen_sample_hash(&other);
        for (uint32_t i = 0; i < 256; i++)
            pairs[i] = (struct pen_point2){pen_sobol2(h, i).x, pen_sobol2(ho, i).x};
        sum += chi_square(pairs, 256);
    }
    /* Each row and column holds exactly 16, so the mean is 225 rather than 255. */
    ck_assert_msg(fabs(sum / 400 - 225) < 15, "mean chi-square %.1f", sum / 400);
}
END_TEST

START_TEST(test_sample__every_bit_of_the_key_counts)
{
    struct pen_sample_key base = {UINT64_C(0x123456789ABCDEF0), 100, 200, 3, 5, 3, 1};
    uint64_t h = pen_sample_hash(&base);
    uint32_t *words[] = {&base.x,    &base.y,       &base.pixel_sample,
                         &base.node, &base.purpose, &base.light};
    for (int i = 0; i < 64 + 6 * 32; i++) {
        struct pen_sample_key saved = base;
        if (i < 64)
            base.seed ^= UINT64_C(1) << i;
        else
            *words[(i - 64) / 32] ^= 1u << i % 32;
        int changed = __builtin_popcountll(h ^ pen_sample_hash(&base));
        base = saved;
        ck_assert_msg(changed >= 12 && changed <= 52, "bit %d of the key changes %d bits", i,
                      changed);
    }
}
END_TEST

/* The part of a disk light that is visible beyond a straight edge at height h, in closed form, and
 * the error of its estimates from n points: RMSE over many edges. Published for these patterns are
 * 5.5e-3 for scrambled Sobol' at 256 points, and 2.4e-2 for random points. */
static double edge_rmse(bool sobol, uint32_t n, double *bias)
{
    double squares = 0, sum = 0;
    const uint32_t edges = 2000;
    for (uint32_t e = 0; e < edges; e++) {
        uint64_t hash = hash_of(e);
        struct pen_point2 line = pen_random2(~hash, 0);
        double h = 2 * line.x - 1, angle = 2 * M_PI * line.y, seen = 0;
        for (uint32_t i = 0; i < n; i++) {
            struct pen_point2 p =
                pen_disk_of_square(sobol ? pen_sobol2(hash, i) : pen_random2(hash, i));
            seen += p.x * cos(angle) + p.y * sin(angle) > h;
        }
        double error = seen / n - (acos(h) - h * sqrt(1 - h * h)) / M_PI;
        squares += error * error;
        sum += error;
    }
    *bias = sum / edges;
    return sqrt(squares / edges);
}

START_TEST(test_sample__shadow_edges_converge_as_published)
{
    const struct {
        bool sobol;
        uint32_t n;
        double rmse;
    } rows[] = {{true, 16, 4.3e-2},
                {true, 64, 1.5e-2},
                {true, 256, 5.5e-3},
                {true, 1024, 1.9e-3},
                {false, 256, 2.4e-2}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        double bias, rmse = edge_rmse(rows[i].sobol, rows[i].n, &bias);
        ck_assert_msg(rmse < 1.15 * rows[i].rmse, "n=%u: %g", rows[i].n, rmse);
        ck_assert_msg(rmse > 0.75 * rows[i].rmse, "n=%u: %g", rows[i].n, rmse);
        ck_assert_msg(fabs(bias) < 5 * rmse / sqrt(2000), "n=%u: bias %g", rows[i].n, bias);
    }
}
END_TEST

START_TEST(test_sample__disk_map_preserves_areas)
{
    /* The Jacobian by differences is pi / 4 x 4 = pi everywhere but on the diagonals. */
    const double d = 1e-5;
    for (uint32_t i = 0; i < 10000; i++) {
        struct pen_point2 p = pen_random2(99, i);
        double a = fabs(p.x - 0.5), b = fabs(p.y - 0.5);
        if (fabs(a - b) < 2 * d || a + b < 0.05)
            continue; /* the map is not differentiable there */
        struct pen_point2 q = pen_disk_of_square(p);
        struct pen_point2 qx = pen_disk_of_square((struct pen_point2){p.x + d, p.y});
        struct pen_point2 qy = pen_disk_of_square((struct pen_point2){p.x, p.y + d});
        double area = ((qx.x - q.x) * (qy.y - q.y) - (qx.y - q.y) * (qy.x - q.x)) / (d * d);
        ck_assert_msg(fabs(area - M_PI) < 1e-3, "at %a %a: %g", p.x, p.y, area);
    }
}
END_TEST

START_TEST(test_sample__disk_map_at_its_edges)
{
    struct pen_point2 p = pen_disk_of_square((struct pen_point2){0.5, 0.5});
    ck_assert(p.x == 0 && p.y == 0);
    p = pen_disk_of_square((struct pen_point2){0, 0.5});
    ck_assert(p.x == -1 && p.y == 0);
    p = pen_disk_of_square((struct pen_point2){0.5, 0});
    ck_assert(p.x == 0 && p.y == -1);
    p = pen_disk_of_square((struct pen_point2){0.75, 0.25});
    ck_assert(fabs(p.x - M_SQRT1_2 / 2) < 1e-15 && fabs(p.y + M_SQRT1_2 / 2) < 1e-15);
    for (uint32_t i = 0; i <= 1000; i++) {
        p = pen_disk_of_square((struct pen_point2){i / 1000., 0});
        double angle = (1.5 + (i / 1000. - 0.5) / 2) * M_PI;
        ck_assert(fabs(p.x - cos(angle)) < 1e-15 && fabs(p.y - sin(angle)) < 1e-15);
    }
}
END_TEST

START_TEST(test_sample__grid_has_one_point_in_every_cell)
{
    static struct pen_point2 points[POINTS];
    const uint32_t edges[] = {1, 2, 15, 64};
    for (size_t e = 0; e < sizeof edges / sizeof edges[0]; e++) {
        uint32_t edge = edges[e], n = 0;
        for (uint32_t key_number = 0; n < POINTS; key_number++)
            for (uint32_t cell = 0; cell < edge * edge && n < POINTS; cell++) {
                struct pen_point2 p = pen_grid2(hash_of(key_number), edge, cell);
                ck_assert_uint_eq((uint32_t)(p.x * edge), cell % edge);
                ck_assert_uint_eq((uint32_t)(p.y * edge), cell / edge);
                points[n].x = p.x * edge - cell % edge;
                points[n++].y = p.y * edge - cell / edge;
            }
        check_uniform(points, "within cells");
    }
}
END_TEST

/* A change of these values changes every picture that uses samples, so it needs a new major
 * version. */
START_TEST(test_sample__values_are_fixed)
{
    struct pen_sample_key k = {42, 640, 480, 1, 2, PEN_PURPOSE_LIGHT, 3};
    uint64_t h = pen_sample_hash(&k);
    struct pen_point2 p = pen_sobol2(h, 5), q = pen_random2(h, 5), d = pen_disk_of_square(p);
    ck_assert_uint_eq(h, UINT64_C(2272846109047862657));
    ck_assert_msg(p.x == 0x1.1107d1d3p-1 && p.y == 0x1.cae091d5p-1, "%a %a", p.x, p.y);
    ck_assert_msg(q.x == 0x1.f2b068c5p-1 && q.y == 0x1.c4d87b5ep-2, "%a %a", q.x, q.y);
    struct pen_point2 g = pen_grid2(h, 7, 30);
    ck_assert_msg(g.x == 0x1.411d58bep-2 && g.y == 0x1.68d583afdb6dbp-1, "%a %a", g.x, g.y);
    ck_assert_msg(d.x == 0x1.abb6da4c6e9a4p-5 && d.y == 0x1.94df767ecb3bep-1, "%a %a", d.x, d.y);
}
END_TEST

PEN_SUITE("sample", test_sample__sobol_prefixes_are_nets, test_sample__a_point_is_uniform_over_keys,
          test_sample__random_points_of_one_key_are_uniform, test_sample__sets_are_independent,
          test_sample__pairs_within_one_set_fill_the_square,
          test_sample__every_bit_of_the_key_counts, test_sample__shadow_edges_converge_as_published,
          test_sample__disk_map_preserves_areas, test_sample__disk_map_at_its_edges,
          test_sample__grid_has_one_point_in_every_cell, test_sample__values_are_fixed)
