/* SPDX-License-Identifier: MIT */
/* Blurred rays: their number and their directions, and a cone without width.
 * tests/golden/test_blur.c compares their means with the oracle's. The camera looks along -z from z
 * = 10. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/kit.h"
#include "support/suite.h"

static struct kit kit;

/* A sheet that reflects, across the view, under a sky that is brightest behind the camera. */
static struct pen_material *mirror(double blur)
{
    struct pen_material m = kit_matte(0);
    kit_init(&kit);
    m.kr = pen_vec3(1, 1, 1);
    m.reflection_blur = blur;
    kit.desc.has_sky = true;
    kit.desc.sky = (struct pen_sky){{1, 0.5, 0.25}, {0, 0, 0}, {0, 0, 1}};
    const int material = kit_material(&kit, m);
    kit_sheet(&kit, 0, 1e6, material);
    return &kit.materials[material];
}

/* The mean cosine with the axis of a cone of half-angle a, uniform in solid angle. */
static double mean_cosine(double degrees)
{
    return (1 + cos(degrees * acos(-1) / 180)) / 2;
}

START_TEST(test_gloss__a_cone_has_its_mean_elevation)
{
    static const double degrees[] = {1e-3, 1, 10, 45, 89};
    for (size_t i = 0; i < sizeof degrees / sizeof degrees[0]; i++) {
        struct pen_ray_counts rays;
        mirror(degrees[i]);
        kit.settings.blur_samples = 4096;
        const struct pen_vec3 c = kit_pixel(&kit, 0, 0, &rays);
        ck_assert_double_eq_tol(c.x, mean_cosine(degrees[i]), 5e-5);
        ck_assert_double_eq_tol(c.y, 0.5 * c.x, 1e-12);
        ck_assert_uint_eq(rays.reflection, 4096);
    }
}
END_TEST

/* The same through a sheet: the rays go on to the other side. */
START_TEST(test_gloss__frosted_rays_go_on)
{
    struct pen_ray_counts rays;
    struct pen_material *m = mirror(0);
    m->kt = m->kr;
    m->kr = pen_vec3(0, 0, 0);
    m->transmission_blur = 30;
    kit.desc.sky.up = pen_vec3(0, 0, -1);
    kit.settings.blur_samples = 4096;
    ck_assert_double_eq_tol(kit_pixel(&kit, 0, 0, &rays).x, mean_cosine(30), 2e-5);
    ck_assert_uint_eq(rays.transmission, 4096);
    ck_assert_uint_eq(rays.reflection, 0);
}
END_TEST

/* H128: a cone of no width is a mirror, and its effect is not called for. */
START_TEST(test_gloss__h128_no_blur_is_a_mirror)
{
    struct pen_ray_counts rays;
    mirror(0);
    kit.settings.blur_samples = 64;
    struct pen_scene *scene = kit_freeze(&kit);
    ck_assert_uint_eq(pen_scene_effects(scene, 0, &kit.settings), PEN_FX_SKY | PEN_FX_MIRROR);
    pen_scene_free(scene);
    ck_assert(kit_pixel(&kit, 0, 0, &rays).x == 1);
    ck_assert_uint_eq(rays.reflection, 1);
}
END_TEST

/* The first surface sends blur_samples rays, all others one: between two sheets that reflect,
 * each of the first rays is reflected on until the path is as deep as it may be. */
START_TEST(test_gloss__only_the_first_surface_sends_many)
{
    static const int samples[] = {1, 2, 7, 100};
    for (size_t i = 0; i < sizeof samples / sizeof samples[0]; i++)
        for (int depth = 2; depth < 40; depth += 9) {
            struct pen_ray_counts rays;
            mirror(3);
            kit_sheet(&kit, 20, 1e6, 0);
            kit.settings.blur_samples = samples[i];
            kit.settings.max_depth = depth;
            kit_pixel(&kit, 0, 0, &rays);
            ck_assert_uint_eq(rays.reflection, (uint64_t)samples[i] * (uint64_t)(depth - 1));
            ck_assert_uint_eq(rays.truncated_paths, 0);
        }
}
END_TEST

/* A ball that blurs both ways, seen in sheets that reflect: at every depth, paths wait on the
 * stack. Trees are cut later where each of many rays begins one. */
START_TEST(test_gloss__the_stack_holds_every_depth)
{
    for (int depth = 1; depth < 30; depth++) {
        struct pen_ray_counts rays;
        struct pen_material m = kit_matte(0);
        mirror(5);
        kit_sheet(&kit, 20, 1e6, 0);
        m.kt = m.kr = pen_vec3(0.9, 0.9, 0.9);
        m.ior = 1.5;
        m.reflection_blur = m.transmission_blur = 20;
        kit_sphere(&kit, pen_vec3(0, 0, 5), 2, kit_material(&kit, m));
        kit.settings.blur_samples = 5;
        kit.settings.max_depth = depth;
        kit.settings.min_contribution = 0;
        const struct pen_vec3 c = kit_pixel(&kit, 0, 0, &rays);
        ck_assert(isfinite(c.x));
        ck_assert(depth > 10 || rays.truncated_paths == 0);
        ck_assert_uint_le(rays.reflection + rays.transmission,
                          (uint64_t)2 * 2048 * (uint64_t)kit.settings.blur_samples);
    }
}
END_TEST

/* Blurred rays have nodes of their own, so that what they sample differs: the means of two renders
 * with different seeds differ, with the same seed they do not. */
START_TEST(test_gloss__the_seed_draws_the_rays)
{
    struct pen_vec3 c[3];
    for (int i = 0; i < 3; i++) {
        mirror(20);
        kit.settings.seed = i == 1;
        c[i] = kit_pixel(&kit, 0, 0, NULL);
    }
    ck_assert(memcmp(&c[0], &c[1], sizeof c[0]) != 0);
    ck_assert_mem_eq(&c[0], &c[2], sizeof c[0]);
}
END_TEST

PEN_SUITE("gloss", test_gloss__a_cone_has_its_mean_elevation, test_gloss__frosted_rays_go_on,
          test_gloss__h128_no_blur_is_a_mirror, test_gloss__only_the_first_surface_sends_many,
          test_gloss__the_stack_holds_every_depth, test_gloss__the_seed_draws_the_rays)
