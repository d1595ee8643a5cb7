/* SPDX-License-Identifier: MIT */
/* Unshadowed light in lanes, for every instruction set of this processor: each lane has the bits of
 * its point alone, with any points in the other lanes. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support/lanes.h"
#include "support/random.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

enum { MAX = LANES_TEST_MAX };

/* A point of which many are special: black, dull, seen along the surface, with a wide horizon, lit
 * from below it or along it, or unlit. */
static struct lanes_point point(struct random *r, const struct pen_light *light)
{
    struct lanes_point s = {.p = random_vec(r, 2),
                            .n = random_direction(r),
                            .v = random_direction(r),
                            .shininess = random_below(r, 4) ? random_in(r, 0, 200) : 0,
                            .grazing_sine = PEN_HORIZON_SINE,
                            .bound = 0x1p-48,
                            .lit = random_below(r, 8) != 0};
    if (random_below(r, 4))
        s.kd = pen_vec3(random_unit(r), random_unit(r), random_unit(r));
    if (random_below(r, 3))
        s.ks = pen_vec3(random_unit(r), 0, random_unit(r));
    if (random_below(r, 8) == 0)
        s.grazing_sine = random_below(r, 2) ? INFINITY : random_unit(r);
    if (random_below(r, 8) == 0) /* looked at straight against the mirrored light */
        s.v = light->direction;
    vec3 q = light->positional ? pen_sub(s.p, light->position) : light->direction;
    if (random_below(r, 8) == 0) { /* the light grazes the surface, or almost */
        const vec3 e = pen_normalize(pen_along(s.n, q, -pen_dot(s.n, q) / pen_dot(q, q)));
        const double low = ldexp(random_in(r, -2, 2), -22 - (int)random_below(r, 20));
        s.n = pen_normalize(pen_along(e, q, -low / pen_length(q)));
    } else if (pen_dot(s.n, q) > 0 && random_below(r, 4)) {
        s.n = pen_neg(s.n);
    }
    if (pen_dot(s.n, s.v) > 0)
        s.v = pen_neg(s.v);
    if (random_below(r, 64) == 0)
        s.p.x = random_below(r, 2) ? 1e200 : NAN;
    s.nv = pen_dot(s.n, s.v);
    return s;
}

static struct pen_light some_light(struct random *r)
{
    struct pen_light l = {.positional = random_below(r, 4) != 0,
                          .intensity = pen_vec3(random_unit(r), random_unit(r), random_unit(r)),
                          .position = random_vec(r, 3),
                          .direction = random_direction(r),
                          .kc = 1,
                          .kl = random_unit(r),
                          .kq = random_unit(r),
                          .beam_exponent = random_in(r, 0, 30)};
    l.beam = l.positional && random_below(r, 2);
    return l;
}

/* NaNs count as equal. */
static bool same3(vec3 a, vec3 b)
{
    const double *x = (const double *)&a, *y = (const double *)&b;
    for (int i = 0; i < 3; i++)
        if (memcmp(x + i, y + i, sizeof *x) != 0 && !(isnan(x[i]) && isnan(y[i])))
            return false;
    return true;
}

/* Counts in *dark and *bright how many points get nothing, and something. */
static void compare(const struct lanes_test *test, const struct pen_light *light,
                    const struct lanes_point *points, bool specular, int *dark, int *bright)
{
    const struct lanes_test *alone = lanes_test_of(PEN_ISA_BASE);
    struct lanes_arriving got[MAX], want;
    test->light(light, points, specular, got);
    for (int i = 0; i < test->lanes; i++) {
        alone->light(light, &points[i], specular, &want);
        *dark += !want.arrives;
        *bright += want.arrives;
        ck_assert_msg(got[i].arrives == want.arrives &&
                          (!want.arrives || same3(got[i].term, want.term)) &&
                          same3(got[i].to_light, want.to_light),
                      "lane %d of %d: n.v %a, term %a instead of %a", i, test->lanes, points[i].nv,
                      got[i].term.x, want.term.x);
    }
}

START_TEST(test_light_lanes__are_single_points)
{
    ck_assert_int_eq(lanes_test_of(PEN_ISA_BASE)->lanes, 1);
    for (int isa = PEN_ISA_BASE + 1; isa < PEN_ISA_COUNT; isa++) {
        const struct lanes_test *test = lanes_test_of((enum pen_isa)isa);
        struct random r = random_begin(4);
        int dark = 0, bright = 0;
        if (!test) {
            printf("not on this processor: %s\n", pen_isa_name((enum pen_isa)isa));
            continue;
        }
        for (int n = random_cases(100000); n-- > 0;) {
            const struct pen_light light = some_light(&r);
            struct lanes_point points[MAX];
            for (int i = 0; i < MAX; i++)
                points[i] = point(&r, &light);
            compare(test, &light, points, n & 7, &dark, &bright);
        }
        ck_assert_int_gt(dark, 1000);
        ck_assert_int_gt(bright, 1000);
    }
}
END_TEST

PEN_SUITE("light_lanes", test_light_lanes__are_single_points)
