/* SPDX-License-Identifier: MIT */
/* The background: the sky's colours by the elevation of a ray that meets no object. */
#include <math.h>

#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;
static const vec3 zenith = {0.25, 0.5, 2}, horizon = {1, 0.75, 0.5}, nadir = {0.125, 0, 0.25};

static void under_sky(vec3 up)
{
    kit_init(&kit);
    kit.desc.has_sky = true;
    kit.desc.background = horizon;
    kit.desc.sky = (struct pen_sky){zenith, nadir, up};
}

/* The colour seen from the eye in a direction. */
static vec3 look(vec3 d)
{
    struct pen_ray_counts rays;
    kit.view.camera.direction = d;
    kit.view.camera.up = fabs(d.y) > fabs(d.x) ? pen_vec3(1, 0, 0) : pen_vec3(0, 1, 0);
    const vec3 c = kit_pixel(&kit, 0, 0, &rays);
    ck_assert_uint_eq(rays.primary, 1);
    ck_assert_uint_eq(rays.reflection + rays.transmission + rays.shadow, 0);
    return c;
}

static void assert_colour(vec3 got, vec3 want)
{
    ck_assert_msg(got.x == want.x && got.y == want.y && got.z == want.z,
                  "(%a %a %a), want (%a %a %a)", got.x, got.y, got.z, want.x, want.y, want.z);
}

START_TEST(test_background__sky_at_zenith_horizon_and_nadir)
{
    under_sky(pen_vec3(0, 7, 0));
    assert_colour(look(pen_vec3(0, 1, 0)), zenith);
    assert_colour(look(pen_vec3(0, -3, 0)), nadir);
    assert_colour(look(pen_vec3(1, 0, 0)), horizon);
    assert_colour(look(pen_vec3(-1, 0, -2)), horizon);
    under_sky(pen_vec3(0, 0, -1));
    assert_colour(look(pen_vec3(0, 0, -1)), zenith);
    assert_colour(look(pen_vec3(0, 0, 1)), nadir);
}
END_TEST

/* The oracle is the definition in long double: linear in the sine of the elevation. */
START_TEST(test_background__sky_is_linear_in_the_sine)
{
    struct random r = random_begin(411);
    for (int i = 0; i < random_cases(4000); i++) {
        const vec3 up = pen_scale(random_direction(&r), exp2(random_in(&r, -20, 20)));
        const vec3 d = random_direction(&r);
        under_sky(up);
        const vec3 got = look(d);
        const long double sine =
            ((long double)d.x * up.x + (long double)d.y * up.y + (long double)d.z * up.z) /
            sqrtl((long double)up.x * up.x + (long double)up.y * up.y + (long double)up.z * up.z) /
            sqrtl((long double)d.x * d.x + (long double)d.y * d.y + (long double)d.z * d.z);
        for (int c = 0; c < 3; c++) {
            const long double from = pen_component(horizon, c),
                              to = pen_component(sine < 0 ? nadir : zenith, c),
                              want = from + (to - from) * fabsl(sine);
            ck_assert_msg(fabsl(pen_component(got, c) - want) <= 0x1p-48L,
                          "case %d: %.17g, want %.17Lg", i, pen_component(got, c), want);
        }
    }
}
END_TEST

/* A mirror shows the sky above, glass the sky behind. */
START_TEST(test_background__sky_in_mirrors_and_through_glass)
{
    under_sky(pen_vec3(0, 1, 0));
    struct pen_material m = kit_glow(0, 0, 0);
    m.kr = pen_vec3(0.5, 0.5, 0.25);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 1, 1), kit_material(&kit, m));
    struct pen_ray_counts rays;
    const vec3 up = kit_pixel(&kit, 0, 0, &rays); /* along -z, mirrored along +y */
    ck_assert_double_le(pen_length(pen_sub(up, pen_mul(m.kr, zenith))), 0x1p-50);
    ck_assert_uint_eq(rays.reflection, 1);
    kit.materials[0].kr = pen_vec3(0, 0, 0);
    kit.materials[0].kt = pen_vec3(0.5, 1, 0.75);
    assert_colour(kit_pixel(&kit, 0, 0, &rays), pen_mul(kit.materials[0].kt, horizon));
    ck_assert_uint_eq(rays.transmission, 1);
}
END_TEST

/* A sky of one colour is a background: no effect, the same bits. */
START_TEST(test_background__a_plain_sky_is_no_effect)
{
    under_sky(pen_vec3(1, 2, 3));
    ck_assert_uint_eq(pen_desc_effects(&kit.desc, &kit.settings), PEN_FX_SKY);
    kit.desc.sky.zenith = kit.desc.sky.nadir = horizon;
    ck_assert_uint_eq(pen_desc_effects(&kit.desc, &kit.settings), 0);
    assert_colour(look(pen_vec3(1, 2, 5)), horizon);
    kit.desc.sky.nadir.z += 0x1p-52;
    ck_assert_uint_eq(pen_desc_effects(&kit.desc, &kit.settings), PEN_FX_SKY);
}
END_TEST

PEN_SUITE("background", test_background__sky_at_zenith_horizon_and_nadir,
          test_background__sky_is_linear_in_the_sine,
          test_background__sky_in_mirrors_and_through_glass,
          test_background__a_plain_sky_is_no_effect)
