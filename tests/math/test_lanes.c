/* SPDX-License-Identifier: MIT */
/* The elementary functions and sample points in lanes have the bits of the scalar ones, with any
 * values in the other lanes, for every instruction set of this processor. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "math/fn.h"
#include "support/lanes.h"
#include "support/random.h"
#include "support/suite.h"

enum { F = LANES_TEST_FUNCTIONS, MAX = LANES_TEST_MAX };

/* Where branches of the functions meet, and what they treat as special. */
static const double EDGES[] = {
    0,      1,      2,   INFINITY, NAN,   0x1p-1074, 0x1p-1022, 0x1.fffffffffffffp1023,
    0x1p64, 0x1p20, 30,  60,       90,    706.3,     708.3,     709.7,
    710,    745.1,  746, 0x1p-30,  1e300, 0x1.6ap-1};
enum { EDGE_COUNT = sizeof EDGES / sizeof EDGES[0] };

static void scalar(double x, double y, double out[F])
{
    out[0] = pen_exp(x);
    out[1] = pen_ln(x);
    out[2] = pen_pow(x, y);
    pen_sincos(x, &out[3], &out[4]);
    pen_sincos_deg(x, &out[5], &out[6]);
}

/* NaNs count as equal. */
static bool same_bits(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0 || (isnan(a) && isnan(b));
}

static void check_group(const struct lanes_test *test, const double *x, const double *y)
{
    double got[F][MAX], want[F];
    test->functions(x, y, got);
    for (int i = 0; i < test->lanes; i++) {
        scalar(x[i], y[i], want);
        for (int f = 0; f < F; f++)
            ck_assert_msg(same_bits(got[f][i], want[f]),
                          "function %d, lane %d of %d: x %a y %a: %a, not %a", f, i, test->lanes,
                          x[i], y[i], got[f][i], want[f]);
    }
}

static double edge(int i)
{
    const double e = random_nudge(EDGES[i / 2 % EDGE_COUNT], i / (2 * EDGE_COUNT) - 1);
    return i & 1 ? -e : e;
}

enum { EDGE_CASES = 2 * EDGE_COUNT * 3 };

static double argument(struct random *r)
{
    uint64_t bits = random_bits(r);
    double any;
    memcpy(&any, &bits, sizeof any);
    switch (random_below(r, 6)) {
    case 0:
        return edge((int)random_below(r, EDGE_CASES));
    case 1:
        return any;
    case 2:
        return random_in(r, 0, 1);
    case 3:
        return random_in(r, -750, 750);
    case 4:
        return 1 + random_in(r, -0x1p-10, 0x1p-10);
    default:
        return random_in(r, -0x1p21, 0x1p21);
    }
}

START_TEST(test_lanes__functions_of_random_numbers)
{
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++) {
        const struct lanes_test *test = lanes_test_of((enum pen_isa)isa);
        struct random r = random_begin(1);
        if (!test)
            printf("not on this processor: %s\n", pen_isa_name((enum pen_isa)isa));
        for (int n = random_cases(test ? 200000 : 0); n-- > 0;) {
            double x[MAX], y[MAX];
            for (int i = 0; i < MAX; i++) {
                x[i] = argument(&r);
                y[i] = argument(&r);
            }
            check_group(test, x, y);
        }
    }
}
END_TEST

/* One special argument in each lane, alone and in a set of lanes: 8 lanes have 255 sets. */
START_TEST(test_lanes__functions_at_their_edges)
{
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++) {
        const struct lanes_test *test = lanes_test_of((enum pen_isa)isa);
        for (int i = 0; test && i < EDGE_CASES; i++)
            for (unsigned set = 1; set < 1u << test->lanes; set++) {
                double x[MAX], y[MAX], u[MAX], v[MAX];
                for (int lane = 0; lane < MAX; lane++) {
                    const bool in = set >> lane & 1;
                    x[lane] = in ? edge(i) : 0.25 + 0.125 * lane;
                    y[lane] = 3 + lane;
                    u[lane] = 0.25 + 0.125 * lane;
                    v[lane] = in ? edge(i) : 3 + lane;
                }
                check_group(test, x, y);
                check_group(test, u, v);
            }
    }
}
END_TEST

/* Sample points are those of math/sample.h, up to the last index. */
START_TEST(test_lanes__sample_points)
{
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++) {
        const struct lanes_test *test = lanes_test_of((enum pen_isa)isa);
        struct random r = random_begin(2);
        for (int n = random_cases(test ? 50000 : 0); n-- > 0;) {
            struct pen_point2 random[MAX], sobol[MAX], disk[MAX];
            const uint64_t hash = random_bits(&r);
            const uint32_t bits = (uint32_t)random_bits(&r),
                           last = UINT32_MAX - (uint32_t)test->lanes + 1,
                           index = n & 1         ? bits & 255
                                   : bits < last ? bits
                                                 : last;
            test->samples(hash, index, random, sobol, disk);
            for (int i = 0; i < test->lanes; i++) {
                const struct pen_point2 p = pen_random2(hash, index + (uint32_t)i);
                const struct pen_point2 q = pen_sobol2(hash, index + (uint32_t)i);
                const struct pen_point2 d = pen_disk_of_square(p);
                ck_assert_msg(random[i].x == p.x && random[i].y == p.y && sobol[i].x == q.x &&
                                  sobol[i].y == q.y && disk[i].x == d.x && disk[i].y == d.y,
                              "%s: hash %llx, index %u, lane %d", pen_isa_name((enum pen_isa)isa),
                              (unsigned long long)hash, index, i);
            }
        }
    }
}
END_TEST

START_TEST(test_lanes__points_of_sequences_of_many_keys)
{
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++) {
        const struct lanes_test *test = lanes_test_of((enum pen_isa)isa);
        struct random r = random_begin(3);
        for (int n = random_cases(test ? 50000 : 0); n-- > 0;) {
            const uint64_t seed = random_bits(&r);
            const uint32_t purpose = 1 + (uint32_t)random_bits(&r) % 5;
            struct pen_sample_key key[MAX];
            uint32_t index[MAX];
            struct pen_point2 sobol[MAX];
            for (int i = 0; i < MAX; i++) {
                key[i] = (struct pen_sample_key){.seed = seed,
                                                 .x = (uint32_t)random_bits(&r) >> (n & 24),
                                                 .y = (uint32_t)random_bits(&r) >> (n & 24),
                                                 .pixel_sample = (uint32_t)random_bits(&r),
                                                 .node = (uint32_t)random_bits(&r),
                                                 .purpose = purpose};
                index[i] = (uint32_t)random_bits(&r) >> (n & 31);
            }
            test->sequences(key, index, sobol);
            for (int i = 0; i < test->lanes; i++) {
                const struct pen_point2 p = pen_sobol2(pen_sample_hash(&key[i]), index[i]);
                ck_assert_msg(sobol[i].x == p.x && sobol[i].y == p.y,
                              "%s: case %d, lane %d, index %u", pen_isa_name((enum pen_isa)isa), n,
                              i, index[i]);
            }
        }
    }
}
END_TEST

PEN_SUITE("lanes", test_lanes__functions_of_random_numbers, test_lanes__functions_at_their_edges,
          test_lanes__sample_points, test_lanes__points_of_sequences_of_many_keys)
