/* SPDX-License-Identifier: MIT */
/* The choice of the kernel for a view: a kernel without a sky or patterns, if few samples meet
 * them. Bits and rays do not depend on it. */
#include <stdlib.h>
#include <string.h>

#include "support/isa.h"
#include "support/kit.h"
#include "support/scene_files.h"
#include "support/suite.h"

static struct kit kit;
static const struct pen_pattern tiles = {true, {1, 0.5, 0.25}, {0, 0.25, 0.5},
                                         0.75, {0, 0, 0},      {0, 0, 0}};
static const struct pen_patterns tiled = {.of = {[PEN_COLOUR_KD] = &tiles}};
static const struct pen_patterns blind = {.of = {[PEN_COLOUR_KT] = &tiles}};

/* Mirrors, glass and lights with radii, for which there is a kernel, but none with a sky. */
static void medley(void)
{
    kit_medley(&kit);
    kit.settings.width = 40;
    kit.settings.height = 32;
    kit.settings.samples_per_pixel = 1;
    kit.settings.light_samples = 4;
}

static void under_sky(void)
{
    kit.desc.has_sky = true;
    kit.desc.sky = (struct pen_sky){{1, 2, 3}, {3, 2, 1}, {0, 1, 0}};
}

/* A sphere around the scene. */
static void enclose(void)
{
    kit_sphere(&kit, pen_vec3(0, 0, 0), 60, kit_material(&kit, kit_matte(0.5)));
}

/* A ball that few samples meet. */
static void small_ball(const struct pen_patterns *patterns)
{
    struct pen_material m = kit_matte(0.5);
    m.patterns = patterns;
    m.kt = patterns == &blind ? pen_vec3(0.5, 0.4, 0.3) : m.kt;
    kit_sphere(&kit, pen_vec3(0.8, 2.3, 6), 0.2, kit_material(&kit, m));
}

/* The effects that the chosen kernel leaves out. Its frame is that of the kernel with all. */
static unsigned left_out(int64_t pixels)
{
    struct pen_scene *scene = kit_freeze(&kit);
    unsigned left = 0;
    for (int isa = 0; isa < isa_count(); isa++) {
        struct pen_kernel_input input = frame_input(scene, 0, &kit.settings, (enum pen_isa)isa);
        const struct pen_kernel *full = pen_kernel_select(input.effects, (enum pen_isa)isa);
        struct pen_ray_counts want_rays, rays;
        double *want = frame_by_blocks(full, &input, &want_rays);
        const size_t bytes = 3 * sizeof *want * (size_t)(kit.settings.width * kit.settings.height);
        const struct pen_kernel chosen = pen_kernel_choose(&input, pixels, (enum pen_isa)isa);
        double *frame = frame_by_blocks(&chosen, &input, &rays);
        left = input.effects & ~chosen.effects;
        ck_assert_int_eq(left != 0, input.full != NULL);
        ck_assert(chosen.pixel == full->pixel);
        ck_assert_int_eq(memcmp(frame, want, bytes), 0);
        ck_assert_int_eq(memcmp(&rays, &want_rays, sizeof rays), 0);
        free(want);
        free(frame);
    }
    pen_scene_free(scene);
    return left;
}

enum { MANY = 1 << 20 };

START_TEST(test_kernel_choice__leaves_out_a_sky_that_few_samples_meet)
{
    medley();
    under_sky();
    ck_assert_uint_eq(left_out(MANY), 0);
    enclose();
    ck_assert_uint_eq(left_out(MANY), PEN_FX_SKY);
    ck_assert_uint_eq(left_out(6400), PEN_FX_SKY);
    ck_assert_uint_eq(left_out(6399), 0); /* too small a picture to find out */
}
END_TEST

START_TEST(test_kernel_choice__leaves_out_patterns_that_few_samples_meet)
{
    medley();
    small_ball(&tiled);
    ck_assert_uint_eq(left_out(MANY), 0); /* there is a kernel with patterns */
    under_sky();
    ck_assert_uint_eq(left_out(MANY), 0); /* but none with a sky as well */
    enclose();
    ck_assert_uint_eq(left_out(MANY), PEN_FX_PATTERNS | PEN_FX_SKY);
    kit.materials[kit.desc.material_count - 1].patterns = &tiled;
    ck_assert_uint_eq(left_out(MANY), PEN_FX_SKY);
}
END_TEST

/* Shadow rays meet a kt that is a pattern wherever it throws a shadow. */
START_TEST(test_kernel_choice__never_leaves_out_patterned_glass)
{
    medley();
    small_ball(&blind);
    under_sky();
    enclose();
    ck_assert_uint_eq(left_out(MANY), PEN_FX_SKY);
}
END_TEST

/* No effect is left out for its own sake. */
START_TEST(test_kernel_choice__takes_the_kernel_with_a_sky)
{
    kit_init(&kit);
    kit.settings.width = kit.settings.height = 8;
    kit_sphere(&kit, pen_vec3(0, 0, 0), 60, kit_material(&kit, kit_matte(0.5)));
    kit_point(&kit, pen_vec3(1, 2, 3), pen_vec3(1, 1, 1));
    under_sky();
    ck_assert_uint_eq(left_out(MANY), 0);
}
END_TEST

/* Lists of samples of pixels: some meet the sky, in some lists many. */
START_TEST(test_kernel_choice__samples_of_pixels_are_the_same)
{
    medley();
    small_ball(&tiled);
    under_sky();
    kit.settings.samples_per_pixel = 2;
    struct pen_scene *scene = kit_freeze(&kit);
    for (int isa = 0; isa < isa_count(); isa++) {
        struct pen_kernel_input input = frame_input(scene, 0, &kit.settings, (enum pen_isa)isa);
        struct pen_kernel_scratch *scratch = pen_kernel_scratch_new(&input);
        const struct pen_kernel *full = pen_kernel_select(input.effects, (enum pen_isa)isa);
        const struct pen_kernel *small =
            pen_kernel_select(input.effects & ~(unsigned)PEN_FX_MAY_BE_LEFT_OUT, (enum pen_isa)isa);
        ck_assert_uint_ne(small->effects & input.effects, input.effects);
        for (int list = 0; list < 40 * 32 / PEN_KERNEL_SAMPLES; list++) {
            struct pen_camera_sample samples[PEN_KERNEL_SAMPLES];
            struct pen_vec3 want[PEN_KERNEL_SAMPLES], got[PEN_KERNEL_SAMPLES];
            struct pen_ray_counts want_rays = {0}, rays = {0};
            for (int i = 0; i < PEN_KERNEL_SAMPLES; i++)
                samples[i] = (struct pen_camera_sample){
                    .x = list % 5 * 8 + i % 8, .y = list / 5 * 8 + i / 8, .index = (uint32_t)list};
            input.full = NULL;
            full->samples(&input, scratch, samples, PEN_KERNEL_SAMPLES, want, &want_rays);
            input.full = full;
            small->samples(&input, scratch, samples, PEN_KERNEL_SAMPLES, got, &rays);
            ck_assert_int_eq(memcmp(got, want, sizeof got), 0);
            ck_assert_int_eq(memcmp(&rays, &want_rays, sizeof rays), 0);
        }
        pen_kernel_scratch_free(scratch);
    }
    pen_scene_free(scene);
}
END_TEST

PEN_SUITE("kernel_choice", test_kernel_choice__leaves_out_a_sky_that_few_samples_meet,
          test_kernel_choice__leaves_out_patterns_that_few_samples_meet,
          test_kernel_choice__never_leaves_out_patterned_glass,
          test_kernel_choice__takes_the_kernel_with_a_sky,
          test_kernel_choice__samples_of_pixels_are_the_same)
