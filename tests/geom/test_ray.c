/* SPDX-License-Identifier: MIT */
/* Rays made in lanes, for every instruction set of this processor. Each lane is the ray that is
 * made alone, and has the properties that struct pen_ray promises. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support/lanes.h"
#include "support/random.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

enum { MAX = LANES_TEST_MAX };

/* A component that is large, small, zero, at a limit, not finite, or like another one. */
static double component(struct random *r, double other)
{
    static const double SPECIAL[] = {0,
                                     1,
                                     PEN_LEAST,
                                     0x1p-301,
                                     0x1p-400,
                                     0x1p400,
                                     0x1.0000000000001p400,
                                     0x1p-130,
                                     0x1p-131,
                                     0x1.fffffffffffffp1023,
                                     INFINITY,
                                     NAN,
                                     0x1p-1074};
    const double sign = random_below(r, 2) ? 1 : -1;
    switch (random_below(r, 8)) {
    case 0:
        return sign * SPECIAL[random_below(r, sizeof SPECIAL / sizeof SPECIAL[0])];
    case 1:
        return sign * other;
    case 2:
        return sign * random_nudge(other, (int)random_below(r, 3) - 1);
    default:
        return random_in(r, -2, 2);
    }
}

static vec3 vector(struct random *r, bool hard)
{
    double x = random_in(r, -2, 2), y = random_in(r, -2, 2), z = random_in(r, -2, 2);
    if (hard) {
        x = component(r, 1);
        y = component(r, x);
        z = component(r, random_below(r, 2) ? x : y);
    }
    return pen_vec3(x, y, z);
}

static bool same(const struct pen_ray *a, const struct pen_ray *b)
{
    return memcmp(a, b, offsetof(struct pen_ray, kx)) == 0 && a->kx == b->kx && a->ky == b->ky &&
           a->kz == b->kz;
}

START_TEST(test_ray__lanes_are_single_rays)
{
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++) {
        const struct lanes_test *test = lanes_test_of((enum pen_isa)isa);
        struct random r = random_begin(2);
        int made = 0, refused = 0;
        if (!test)
            printf("not on this processor: %s\n", pen_isa_name((enum pen_isa)isa));
        for (int n = random_cases(test ? 200000 : 0); n-- > 0;) {
            const uint32_t hard = random_below(&r, 4); /* few lanes, some, or all */
            vec3 o[MAX], d[MAX];
            struct pen_ray got[MAX], want;
            for (int i = 0; i < MAX; i++) {
                o[i] = vector(&r, random_below(&r, 4) < hard);
                d[i] = vector(&r, random_below(&r, 4) < hard);
            }
            const unsigned bits = test->rays(o, d, got);
            const int first = test->lanes * (int)random_below(&r, 64 / (uint32_t)test->lanes);
            static struct pen_ray_array array, copy;
            pen_ray_array_begin(&array);
            ck_assert_uint_eq(test->ray_array(o, d, first, &array), bits);
            for (int i = 0; i < test->lanes; i++) {
                const bool can = pen_ray_make(&want, o[i], d[i]);
                ck_assert_msg((bits >> i & 1) == can && (!can || same(&got[i], &want)),
                              "lane %d of %d: o %a %a %a d %a %a %a", i, test->lanes, o[i].x,
                              o[i].y, o[i].z, d[i].x, d[i].y, d[i].z);
                made += can;
                refused += !can;
                if (!can)
                    continue;
                pen_ray_array_get(&array, first + i, &got[i]);
                ck_assert_msg(same(&got[i], &want), "in an array, number %d", first + i);
                ck_assert_int_eq(array.forward >> (first + i) & 1, want.permuted_d.z > 0);
                pen_ray_array_begin(&copy);
                pen_ray_array_set(&copy, i, &want);
                pen_ray_array_get(&copy, i, &got[i]);
                ck_assert(same(&got[i], &want));
                ck_assert_int_eq(copy.forward >> i & 1, want.permuted_d.z > 0);
            }
        }
        ck_assert(!test || (made > 1000 && refused > 1000));
    }
}
END_TEST

static double limited(double x, double least)
{
    return fabs(x) < least ? copysign(0, x) : x;
}

/* One by one, by the words of geom/ray.h. */
START_TEST(test_ray__is_what_it_says)
{
    struct random r = random_begin(3);
    for (int n = random_cases(200000); n-- > 0;) {
        const vec3 o = vector(&r, n & 1), d = vector(&r, n & 2);
        const double *const from = (const double *)&o, *const along = (const double *)&d;
        const double largest = fmax(fabs(d.x), fmax(fabs(d.y), fabs(d.z)));
        const bool can = isfinite(o.x) && isfinite(o.y) && isfinite(o.z) && !isnan(d.x) &&
                         !isnan(d.y) && !isnan(d.z) && largest >= 0x1p-400 && largest <= 0x1p400;
        struct pen_ray ray;
        ck_assert_int_eq(pen_ray_make(&ray, o, d), can);
        if (!can)
            continue;
        ck_assert_int_eq(ray.kx, (ray.kz + 1) % 3);
        ck_assert_int_eq(ray.ky, (ray.kz + 2) % 3);
        ck_assert(fabs(along[ray.kz]) == largest);
        for (int i = 0; i < 3; i++) {
            const double x = limited(from[i], PEN_LEAST);
            const double y = limited(along[i], PEN_LEAST_DIRECTION * largest);
            ck_assert(memcmp((const double *)&ray.o + i, &x, sizeof x) == 0);
            ck_assert(memcmp((const double *)&ray.d + i, &y, sizeof y) == 0);
        }
        const vec3 po = pen_permuted(&ray, &ray.o), pd = pen_permuted(&ray, &ray.d);
        ck_assert(memcmp(&ray.permuted_o, &po, sizeof po) == 0);
        ck_assert(memcmp(&ray.permuted_d, &pd, sizeof pd) == 0);
        ck_assert(ray.inv_dd == 1.0 / pen_dot(pd, pd) && ray.sz == 1.0 / pd.z);
        ck_assert(ray.sx == pd.x / pd.z && ray.sy == pd.y / pd.z);
        ck_assert(pen_ray_tied(&ray) == (fabs(pd.x) == fabs(pd.y) && fabs(pd.y) == fabs(pd.z)));
    }
}
END_TEST

PEN_SUITE("ray", test_ray__lanes_are_single_rays, test_ray__is_what_it_says)
