/* SPDX-License-Identifier: MIT */
/* The light that one surface reflects from one light source: the equations of the shading model,
 * one by one. The scene is one pixel that looks straight down on the plane z = 0 from z = 10,
 * unless a test states otherwise. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "support/kit.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

static void assert_near(vec3 got, double r, double g, double b)
{
    const double tolerance = 4e-15;
    const double want[3] = {r, g, b};
    for (int c = 0; c < 3; c++)
        ck_assert_double_eq_tol(pen_component(got, c), want[c], tolerance * (want[c] + 1e-300));
}

static struct pen_material shiny(double kd, double ks, double shininess)
{
    struct pen_material m = kit_matte(kd);
    m.ks = pen_vec3(ks, ks, ks);
    m.shininess = shininess;
    return m;
}

static void floor_of(struct pen_material material)
{
    kit_init(&kit);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), kit_material(&kit, material));
}

START_TEST(test_light__directional)
{
    floor_of(shiny(0.5, 0.25, 3));
    kit_directional(&kit, pen_vec3(6, 0, -8), pen_vec3(1, 0.5, 4));
    struct pen_ray_counts rays;
    double share = 0.5 * 0.8 + 0.25 * 0.8 * 0.8 * 0.8; /* -v.r is 0.8 */
    assert_near(kit_pixel(&kit, 0, 0, &rays), share, 0.5 * share, 4 * share);
    ck_assert_uint_eq(rays.primary, 1);
    ck_assert_uint_eq(rays.shadow, 1);
    ck_assert_uint_eq(rays.reflection, 0);
    ck_assert_uint_eq(rays.transmission, 0);
}
END_TEST

START_TEST(test_light__point_with_attenuation)
{
    floor_of(shiny(0.5, 0.25, 2));
    struct pen_light_desc *light = kit_point(&kit, pen_vec3(3, 0, 4), pen_vec3(7, 7, 14));
    light->attenuation[0] = 0.5;
    light->attenuation[1] = 0.25;
    light->attenuation[2] = 0.125;
    double intensity = 7 / (0.5 + 0.25 * 5 + 0.125 * 25);
    double share = intensity * (0.5 * 0.8 + 0.25 * 0.64);
    assert_near(kit_pixel(&kit, 0, 0, NULL), share, share, 2 * share);
}
END_TEST

/* The local frame scales lengths by a power of two, so attenuation must follow: a primitive far off
 * makes the frame large. */
START_TEST(test_light__attenuation_is_in_scene_units)
{
    for (int k = -40; k <= 40; k += 8) {
        floor_of(kit_matte(0.5));
        double s = ldexp(1, k);
        kit.view.camera.position = pen_vec3(0, 0, 10 * s);
        struct pen_light_desc *light = kit_point(&kit, pen_vec3(0, 0, 4 * s), pen_vec3(8, 8, 8));
        light->attenuation[1] = 0.25 / s;
        light->attenuation[2] = 0.5 / (s * s);
        kit_sphere(&kit, pen_vec3(1000 * s, 0, -500 * s), s, -1);
        double want = 0.5 * 8 / (1 + 1 + 8);
        assert_near(kit_pixel(&kit, 0, 0, NULL), want, want, want);
    }
}
END_TEST

START_TEST(test_light__spot_with_beam_exponent)
{
    static const double exponents[] = {0, 1, 2.5, 14, 1000};
    for (size_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++) {
        floor_of(kit_matte(1));
        kit_spot(&kit, pen_vec3(0, 0, 4), pen_vec3(3, 0, -4), pen_vec3(1, 1, 1))->beam_exponent =
            exponents[i];
        double want = exp(log(0.8) * exponents[i]);
        vec3 got = kit_pixel(&kit, 0, 0, NULL);
        ck_assert_double_eq_tol(got.x, want, 1e-12 * want);
    }
}
END_TEST

START_TEST(test_light__h116_nothing_behind_a_spot)
{
    static const vec3 directions[] = {{0, 0, 1}, {1, 0, 0}, {1, 0, 0.1}};
    for (int i = 0; i < 3; i++) {
        floor_of(kit_matte(1));
        kit_spot(&kit, pen_vec3(0, 0, 4), directions[i], pen_vec3(1, 1, 1))->beam_exponent = 0;
        struct pen_ray_counts rays;
        assert_near(kit_pixel(&kit, 0, 0, &rays), 0, 0, 0);
        ck_assert_uint_eq(rays.shadow, 0);
    }
}
END_TEST

START_TEST(test_light__only_on_the_viewers_side)
{
    for (int above = -1; above <= 1; above += 2)
        for (int normal = -1; normal <= 1; normal += 2) {
            struct pen_material m = shiny(0.5, 0.5, 0);
            m.emission = pen_vec3(0.25, 0.25, 0.25);
            kit_init(&kit);
            kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, normal), kit_material(&kit, m));
            kit_point(&kit, pen_vec3(0, 0, 4 * above), pen_vec3(1, 1, 1));
            kit_directional(&kit, pen_vec3(0, 0, -above), pen_vec3(1, 1, 1));
            struct pen_ray_counts rays;
            double want = 0.25 + (above > 0 ? 2 : 0);
            assert_near(kit_pixel(&kit, 0, 0, &rays), want, want, want);
            ck_assert_uint_eq(rays.shadow, above > 0 ? 2 : 0);
        }
}
END_TEST

/* A light in the surface's plane is on neither side: no share of it depends on rounding. */
START_TEST(test_light__dark_in_the_plane_of_the_surface)
{
    kit_init(&kit);
    int m = kit_material(&kit, shiny(0.5, 1, 0));
    const vec3 slope[] = {{-7, -5, -1.3}, {9, -4, 2.1}, {4.3, 6.7, 0}};
    vec3 u = pen_sub(slope[1], slope[0]), w = pen_sub(slope[2], slope[0]);
    kit_triangle(&kit, slope[0], slope[1], slope[2], m);
    vec3 in_plane = pen_along(pen_along(slope[0], u, 0.3), w, 0.4);
    kit_point(&kit, in_plane, pen_vec3(1, 1, 1));
    kit_point(&kit, pen_along(in_plane, u, -3), pen_vec3(1, 1, 1));
    kit.settings.width = kit.settings.height = 32;
    struct pen_scene *scene = kit_freeze(&kit);
    for (int i = 0; i < 32 * 32; i++) {
        double rgb[3];
        struct pen_ray_counts rays;
        struct pen_status st;
        ck_assert(pen_render_pixel(scene, 0, &kit.settings, i % 32, i / 32, rgb, &rays, &st));
        ck_assert(rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0);
        ck_assert_uint_eq(rays.shadow, 0);
    }
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_light__h117_light_at_the_point)
{
    struct pen_material m = shiny(0.5, 0.5, 4);
    m.emission = pen_vec3(0.125, 0, 0);
    floor_of(m);
    struct pen_light_desc *light = kit_point(&kit, pen_vec3(0, 0, 0), pen_vec3(1, 1, 1));
    light->attenuation[0] = 0; /* the intensity itself is infinite here */
    light->attenuation[2] = 1;
    struct pen_ray_counts rays;
    assert_near(kit_pixel(&kit, 0, 0, &rays), 0.125, 0, 0);
    ck_assert_uint_eq(rays.dropped_samples, 0);
    light->position = pen_vec3(0, 0, -1); /* under the plane */
    assert_near(kit_pixel(&kit, 0, 0, &rays), 0.125, 0, 0);
}
END_TEST

START_TEST(test_light__h117_light_inside_an_opaque_sphere)
{
    floor_of(kit_matte(1));
    kit_sphere(&kit, pen_vec3(2, 0, 2), 1, -1);
    kit_point(&kit, pen_vec3(2, 0, 2), pen_vec3(1, 1, 1));
    struct pen_ray_counts rays;
    assert_near(kit_pixel(&kit, 0, 0, &rays), 0, 0, 0);
    ck_assert_uint_eq(rays.shadow, 1);
}
END_TEST

/* 0 to any power is 0 where the mirrored light turns away from the viewer, and 1 to the power of 0
 * where it does not. */
START_TEST(test_light__power_of_zero)
{
    kit_init(&kit);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(1, 0, 1), kit_material(&kit, shiny(0, 0.5, 0)));
    kit_directional(&kit, pen_vec3(-1, 0, 0), pen_vec3(1, 1, 1)); /* mirrored: straight up */
    assert_near(kit_pixel(&kit, 0, 0, NULL), 0.5, 0.5, 0.5);
    kit.lights[0].direction = pen_vec3(-1, 0, 0.75); /* from below: still on the viewer's side */
    struct pen_ray_counts rays;
    assert_near(kit_pixel(&kit, 0, 0, &rays), 0.5, 0.5, 0.5);
    kit.lights[0].direction = pen_vec3(0.5, 0, -1); /* mirrored: downwards along x */
    assert_near(kit_pixel(&kit, 0, 0, &rays), 0, 0, 0);
    ck_assert_uint_eq(rays.shadow, 0); /* the unshadowed term is 0 */
}
END_TEST

START_TEST(test_light__shadows_off)
{
    floor_of(kit_matte(1));
    kit_sphere(&kit, pen_vec3(3, 0, 4), 1, -1);
    kit_directional(&kit, pen_vec3(-6, 0, -8), pen_vec3(1, 1, 1));
    struct pen_ray_counts rays;
    assert_near(kit_pixel(&kit, 0, 0, &rays), 0, 0, 0);
    ck_assert_uint_eq(rays.shadow, 1);
    kit.lights[0].shadows = false;
    assert_near(kit_pixel(&kit, 0, 0, &rays), 0.8, 0.8, 0.8);
    ck_assert_uint_eq(rays.shadow, 0);
}
END_TEST

START_TEST(test_light__emission_and_ambient)
{
    struct pen_material m = pen_material_default();
    m.emission = pen_vec3(0.5, 0, 2);
    m.ka = pen_vec3(0.5, 1, 0);
    floor_of(m);
    kit.desc.ambient = pen_vec3(0.25, 0.5, 1);
    kit.desc.background = pen_vec3(9, 9, 9);
    assert_near(kit_pixel(&kit, 0, 0, NULL), 0.625, 0.5, 2);
    kit.desc.object_count = 0;
    assert_near(kit_pixel(&kit, 0, 0, NULL), 9, 9, 9);
}
END_TEST

START_TEST(test_light__very_far)
{
    floor_of(kit_matte(1));
    kit.view.camera.position = pen_vec3(0, 0, 1);
    kit_point(&kit, pen_vec3(0, 0, 0x1p390), pen_vec3(1, 1, 1));
    assert_near(kit_pixel(&kit, 0, 0, NULL), 1, 1, 1);
}
END_TEST

/* Cosines of 1 that rounding has lifted above it: a huge power would make them brighter than the
 * light. */
START_TEST(test_light__powers_never_amplify)
{
    for (int i = 0; i < 300; i++) {
        vec3 n = pen_normalize(pen_vec3(0.1 * (i % 17) - 0.8, 0.07 * (i % 23) - 0.8, 1));
        vec3 v = pen_vec3(0, 0, -1), back = pen_along(v, n, -2 * pen_dot(n, v));
        kit_init(&kit);
        kit_plane(&kit, pen_vec3(0, 0, 0), n, kit_material(&kit, shiny(0, 1, 1e17)));
        kit_directional(&kit, pen_neg(back), pen_vec3(1, 1, 1)); /* mirrored to the viewer */
        ck_assert_double_le(kit_pixel(&kit, 0, 0, NULL).x, 1);
        kit.materials[0] = kit_matte(1);
        kit.desc.light_count = 0;
        vec3 at = pen_scale(n, 3 + 0.01 * i);
        kit_spot(&kit, at, pen_neg(at), pen_vec3(1, 1, 1))->beam_exponent = 1e17;
        ck_assert_double_le(kit_pixel(&kit, 0, 0, NULL).x, 1 + 1e-15);
    }
}
END_TEST

START_TEST(test_light__h090_overflow_is_dropped_and_counted)
{
    floor_of(kit_matte(1));
    struct pen_light_desc *light = kit_point(&kit, pen_vec3(0, 0, 1e-9), pen_vec3(1e308, 0, 1));
    light->attenuation[0] = 0;
    light->attenuation[2] = 1;
    struct pen_ray_counts rays;
    assert_near(kit_pixel(&kit, 0, 0, &rays), 0, 0, 0);
    ck_assert_uint_eq(rays.dropped_samples, 1);
    light->attenuation[0] = 1;
    light->attenuation[2] = 0; /* finite in double, but not on film */
    for (int channel = 0; channel < 3; channel++) {
        light->intensity =
            pen_vec3(channel == 0 ? 1e39 : 1, channel == 1 ? 1e39 : 1, channel == 2 ? 1e39 : 1);
        assert_near(kit_pixel(&kit, 0, 0, &rays), 0, 0, 0);
        ck_assert_uint_eq(rays.dropped_samples, 1);
    }
}
END_TEST

/* H116: a spot gives no light where its direction is at a right angle to that of the point, or
 * behind; an ulp before that, next to none; and a cosine next to 1 to a large power. */
START_TEST(test_light__h116_edge_of_a_spot)
{
    static const struct {
        double z, exponent;
    } rows[] = {{0, 1},       {-0.0, 1},     {5e-324, 1},     {0x1p-53, 1},
                {0, 1e6},     {5e-324, 0},   {-0x1p-53, 1},   {-0x1p-53, 1e6},
                {-5e-324, 1}, {-0x1p-53, 0}, {-0x1p-1000, 0}, {-0x1p-1000, 1}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        floor_of(kit_matte(1));
        kit_spot(&kit, pen_vec3(0, 0, 4), pen_vec3(1, 0, rows[i].z), pen_vec3(1, 1, 1))
            ->beam_exponent = rows[i].exponent;
        struct pen_ray_counts rays;
        double want = rows[i].z < 0 ? pow(-rows[i].z, rows[i].exponent) : 0;
        assert_near(kit_pixel(&kit, 0, 0, &rays), want, want, want);
        ck_assert_uint_eq(rays.dropped_samples, 0);
    }
    for (int k = 20; k <= 30; k++) { /* 1 / sqrt(1 + s^2) to the power of a million */
        double s = ldexp(1, -k), n = 1e6, want = exp(-0.5 * n * log1p(s * s));
        floor_of(kit_matte(1));
        kit_spot(&kit, pen_vec3(0, 0, 4), pen_vec3(s, 0, -1), pen_vec3(1, 1, 1))->beam_exponent = n;
        vec3 got = kit_pixel(&kit, 0, 0, NULL); /* the cosine is within an ulp, n times */
        ck_assert_double_eq_tol(got.x, want, (2 * n + 2) * 0x1p-53);
    }
}
END_TEST

/* H090: the film stays finite, whatever the attenuation; values that the film cannot hold are
 * counted. 1e-300 is below the resolution of coordinates here, so the light is at the point. */
START_TEST(test_light__h090_strongest_light_at_the_least_distance)
{
    static const double attenuation[][3] = {{1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 8; i++) {
        floor_of(kit_matte(1));
        struct pen_light_desc *light =
            kit_point(&kit, pen_vec3(0, 0, i < 4 ? 1e-300 : 1e-9), pen_vec3(1e308, 1e308, 1e308));
        for (int k = 0; k < 3; k++)
            light->attenuation[k] = attenuation[i % 4][k];
        struct pen_scene *scene = kit_freeze(&kit);
        float *film = kit_film(scene, &kit.settings, 1);
        for (int c = 0; c < 3; c++)
            ck_assert(film[c] >= 0 && film[c] <= FLT_MAX);
        free(film);
        pen_scene_free(scene);
        struct pen_ray_counts rays;
        kit_pixel(&kit, 0, 0, &rays);
        ck_assert_uint_eq(rays.dropped_samples, i < 4 ? 0 : 1);
    }
}
END_TEST

PEN_SUITE("light", test_light__directional, test_light__point_with_attenuation,
          test_light__attenuation_is_in_scene_units, test_light__spot_with_beam_exponent,
          test_light__h116_nothing_behind_a_spot, test_light__only_on_the_viewers_side,
          test_light__dark_in_the_plane_of_the_surface, test_light__h117_light_at_the_point,
          test_light__h117_light_inside_an_opaque_sphere, test_light__power_of_zero,
          test_light__shadows_off, test_light__emission_and_ambient, test_light__very_far,
          test_light__powers_never_amplify, test_light__h090_overflow_is_dropped_and_counted,
          test_light__h116_edge_of_a_spot, test_light__h090_strongest_light_at_the_least_distance)
