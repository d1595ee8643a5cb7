/* SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/buf.h"
#include "io/builtin.h"
#include "io/scene_json.h"
#include "support/suite.h"

static const char head[] = "{\"format\": \"penumbra-scene/1\", "
                           "\"camera\": {\"position\": [0, 0, 5], \"look_at\": [0, 0, 0]}, ";

/* A scene with one view and the given lights. */
static struct pen_scene_desc scene_with(struct pen_light_desc *lights, uint32_t count,
                                        struct pen_view_desc *view)
{
    *view = (struct pen_view_desc){.name = "main"};
    return (struct pen_scene_desc){
        .views = view, .view_count = 1, .lights = lights, .light_count = count};
}

START_TEST(test_limits__work_counts_shadow_rays_of_every_light)
{
    struct pen_light_desc lights[] = {
        {.kind = PEN_LIGHT_POINT, .shadows = true},
        {.kind = PEN_LIGHT_POINT, .shadows = false, .radius = 2},
        {.kind = PEN_LIGHT_SPOT, .shadows = true, .radius = 2},
        {.kind = PEN_LIGHT_DIRECTIONAL, .shadows = true, .angular_radius = 1, .radius = 0},
        {.kind = PEN_LIGHT_DIRECTIONAL, .shadows = true, .radius = 9},
    };
    struct pen_view_desc view;
    struct pen_settings settings = pen_settings_default();
    settings.light_samples = 10;
    settings.samples_per_pixel = 3;
    for (uint32_t count = 0; count <= 5; count++) {
        static const double shadow_rays[] = {0, 1, 1, 11, 21, 22};
        struct pen_scene_desc desc = scene_with(lights, count, &view);
        ck_assert_double_eq(pen_work_per_pixel(&desc, &settings), 3 * (1 + shadow_rays[count]));
    }
    struct pen_scene_desc desc = scene_with(lights, 3, &view);
    settings.light_pattern = PEN_PATTERN_GRID; /* 4 x 4 cells hold 10 samples */
    ck_assert_double_eq(pen_work_per_pixel(&desc, &settings), 3 * (1 + 1 + 16));
}
END_TEST

START_TEST(test_limits__work_takes_the_largest_sample_count_in_use)
{
    struct pen_view_desc view;
    struct pen_scene_desc desc = scene_with(NULL, 0, &view);
    struct pen_settings settings = pen_settings_default();
    settings.samples_per_pixel = 4;
    ck_assert_double_eq(pen_work_per_pixel(&desc, &settings), 4);
    view.camera.aperture_radius = 1;
    ck_assert_double_eq(pen_work_per_pixel(&desc, &settings), 16);
    settings.target_error = 0.01;
    ck_assert_double_eq(pen_work_per_pixel(&desc, &settings), 4096);
}
END_TEST

START_TEST(test_limits__a_target_error_goes_with_some_settings_only)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_view_desc view;
    struct pen_scene_desc desc = scene_with(NULL, 0, &view);
    struct pen_settings settings = pen_settings_default();
    struct pen_status st;
    settings.light_pattern = PEN_PATTERN_GRID;
    settings.max_samples = 3;
    ck_assert(pen_limits_check(&limits, &desc, &settings, 1, "/render", &st));
    settings.target_error = 0.01;
    ck_assert(!pen_limits_check(&limits, &desc, &settings, 1, "/render", &st));
    ck_assert_int_eq(st.code, PEN_INVALID);
    ck_assert_str_eq(st.at, "/render");
    ck_assert_str_eq(st.msg, "light_pattern is \"grid\", whose points cannot be continued as "
                             "target_error asks; allowed with it are \"sobol\" and \"random\"");
    settings.light_pattern = PEN_PATTERN_RANDOM;
    ck_assert(pen_limits_check(&limits, &desc, &settings, 1, "/render", &st));
    settings.max_samples = 1;
    ck_assert(!pen_limits_check(&limits, &desc, &settings, 1, "/render", &st));
    ck_assert_str_eq(st.msg, "max_samples is 1; allowed with this target_error is 2 or more, with "
                             "which each pixel begins");
    settings.target_error = 0.0099;
    settings.max_samples = 3;
    ck_assert(!pen_limits_check(&limits, &desc, &settings, 1, "/render", &st));
    ck_assert_str_eq(st.msg, "max_samples is 3; allowed with this target_error is 4 or more, with "
                             "which each pixel begins");
    settings.max_samples = 4;
    ck_assert(pen_limits_check(&limits, &desc, &settings, 1, "/render", &st));
}
END_TEST

START_TEST(test_limits__pixels_and_work_are_refused_just_above_their_limits)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_view_desc view;
    struct pen_scene_desc desc = scene_with(NULL, 0, &view);
    struct pen_settings settings = pen_settings_default();
    struct pen_status st;
    settings.width = 64000;
    settings.height = 1000;
    ck_assert(pen_limits_check(&limits, &desc, &settings, 64, "", &st));
    settings.height = 1001;
    ck_assert(!pen_limits_check(&limits, &desc, &settings, 1, "/scene", &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    ck_assert_str_eq(st.at, "/scene");
    settings.width = settings.height = 1000;
    settings.samples_per_pixel = 5000000;
    ck_assert(pen_limits_check(&limits, &desc, &settings, 2, "", &st));
    ck_assert(!pen_limits_check(&limits, &desc, &settings, 3, "", &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    settings.width = settings.height = 2147483647;
    ck_assert(!pen_limits_check(&limits, &desc, &settings, 1, "", &st));
}
END_TEST

/* A scene with a sphere in a group, whose material has these factors, and 10^9 pixel samples. */
static bool check_forks(double kr, double kt, int max_depth, uint32_t views, struct pen_status *st)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_material materials[] = {pen_material_default(), pen_material_default()};
    struct pen_object_desc ball = {.kind = PEN_OBJECT_SPHERE, .material = 1};
    struct pen_object_desc group = {.kind = PEN_OBJECT_GROUP,
                                    .u.group = {.count = 1, .objects = &ball}};
    struct pen_view_desc view;
    struct pen_scene_desc desc = scene_with(NULL, 0, &view);
    struct pen_settings settings = pen_settings_default();
    materials[0].kr = materials[0].kt = pen_vec3(1, 1, 1); /* no object has it */
    materials[1].kr.x = kr;
    materials[1].kt.y = kt;
    desc.materials = materials;
    desc.material_count = 2;
    desc.objects = &group;
    desc.object_count = 1;
    settings.width = settings.height = 1000;
    settings.samples_per_pixel = 1000;
    settings.max_depth = max_depth;
    return pen_limits_check(&limits, &desc, &settings, views, "/render", st);
}

START_TEST(test_limits__work_counts_the_surfaces_of_paths_that_fork)
{
    struct pen_status st;
    ck_assert(check_forks(1, 0, 65536, 64, &st));
    ck_assert(check_forks(0, 1, 65536, 64, &st));
    ck_assert(check_forks(0.5, 0.5, 11, 4, &st)); /* 2047 of them, then 2048 */
    ck_assert(!check_forks(0.5, 0.5, 11, 5, &st));
    ck_assert(check_forks(0.5, 0.5, 60, 4, &st));
    ck_assert(check_forks(0.5, 0.5, 10000, 1, &st)); /* a path may have as many as max_depth */
    ck_assert(!check_forks(0.5, 0.5, 10001, 1, &st));
    ck_assert_str_eq(st.msg,
                     "the views take up to 1e+13 rays, at most 1e+13 are allowed: a material has "
                     "both kr and kt, or refracts, so that paths fork, and 1e+09 primary and "
                     "shadow rays become 10001 times as many with max_depth 10001; lower it to "
                     "10000, or take fewer "
                     "pixels or samples");
    ck_assert(!check_forks(0.5, 0.5, 60, 5, &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    ck_assert_str_eq(st.at, "/render");
    ck_assert_ptr_nonnull(strstr(st.msg, "2048 times as many with max_depth 60; lower it to 10,"));
    ck_assert(check_forks(0.5, 0.5, 10, 5, &st));
}
END_TEST

/* A picture of 10^9 pixels and shadow rays, all of whose rays are blurred, with kt and without. */
static bool check_blur(double kt, int blur_samples, struct pen_status *st)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_material m = pen_material_default();
    struct pen_object_desc ball = {.kind = PEN_OBJECT_SPHERE, .material = 0};
    struct pen_view_desc view;
    struct pen_scene_desc desc = scene_with(NULL, 0, &view);
    struct pen_settings settings = pen_settings_default();
    m.kr.x = 0.5;
    m.kt.x = kt;
    m.reflection_blur = 5;
    desc.materials = &m;
    desc.material_count = 1;
    desc.objects = &ball;
    desc.object_count = 1;
    settings.width = settings.height = 1000;
    settings.samples_per_pixel = 1000;
    settings.max_depth = 3;
    settings.blur_samples = blur_samples;
    return pen_limits_check(&limits, &desc, &settings, 1, "/render", st);
}

START_TEST(test_limits__work_counts_blurred_rays)
{
    struct pen_status st;
    ck_assert(check_blur(0, 10000, &st));
    ck_assert(!check_blur(0, 10001, &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    ck_assert_str_eq(st.msg,
                     "the views take up to 1e+13 rays, at most 1e+13 are allowed: a material "
                     "blurs, so that 1e+09 primary and shadow rays become 1e+04 times as "
                     "many with blur_samples 10001 and max_depth 3; lower these, or take "
                     "fewer pixels or samples");
    ck_assert(check_blur(0.5, 1428, &st));
    ck_assert(!check_blur(0.5, 1429, &st));
}
END_TEST

/* No picture of a built-in scene is refused because its paths may fork: at its own size, at four
 * times the width and height, and with 16 samples per pixel. */
START_TEST(test_limits__builtin_scenes_fit)
{
    struct pen_limits limits = pen_limits_default();
    for (size_t i = 0; i < pen_builtin_count(); i++) {
        size_t bytes;
        const char *text = pen_builtin_text(i, &bytes);
        struct pen_arena *arena = pen_arena_new(0);
        struct pen_scene_desc desc;
        struct pen_errors errors = {0};
        struct pen_status st;
        ck_assert(pen_scene_load(text, bytes, &limits, arena, &desc, &errors));
        for (int variant = 0; variant < 3; variant++) {
            struct pen_settings settings = desc.settings;
            if (variant == 1)
                settings.width *= 4, settings.height *= 4;
            if (variant == 2)
                settings.samples_per_pixel = 16;
            ck_assert_msg(pen_limits_check(&limits, &desc, &settings, desc.view_count, "", &st),
                          "%s: %s", pen_builtin_name(i), st.msg);
        }
        pen_arena_free(arena);
    }
}
END_TEST

/* Groups of ten spheres: 11 objects each. */
static void write_groups(struct pen_buf *text, int groups)
{
    pen_buf_puts(text, head);
    pen_buf_puts(text, "\"objects\": [");
    for (int g = 0; g < groups; g++) {
        pen_buf_puts(text, g ? ",{\"type\":\"group\",\"objects\":["
                             : "{\"type\":\"group\",\"objects\":[");
        for (int i = 0; i < 10; i++)
            pen_buf_printf(text, "%s{\"type\":\"sphere\",\"center\":[%d,%d,0],\"radius\":1}",
                           i ? "," : "", g, i);
        pen_buf_puts(text, "]}");
    }
    pen_buf_puts(text, "]}");
    ck_assert(!text->failed);
}

static bool load(const struct pen_buf *text, const struct pen_limits *limits,
                 struct pen_scene_desc *desc, struct pen_errors *errors)
{
    struct pen_arena *arena = pen_arena_new(0);
    bool ok = pen_scene_load((const char *)text->data, text->bytes, limits, arena, desc, errors);
    pen_arena_free(arena);
    return ok;
}

START_TEST(test_limits__objects_are_counted_with_their_groups)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_scene_desc desc;
    struct pen_errors errors = {0};
    struct pen_buf text = {0};
    write_groups(&text, 10);
    limits.objects = 110;
    ck_assert(load(&text, &limits, &desc, &errors));
    ck_assert_uint_eq(desc.primitive_count, 100);
    limits.objects = 109;
    ck_assert(!load(&text, &limits, &desc, &errors));
    ck_assert_uint_eq(errors.total, 1);
    ck_assert_int_eq(errors.item[0].code, PEN_INVALID);
    ck_assert_str_eq(errors.item[0].at, "/objects/9/objects");
    limits.objects = 9;
    errors = (struct pen_errors){0};
    ck_assert(!load(&text, &limits, &desc, &errors));
    ck_assert_str_eq(errors.item[0].at, "/objects");
    pen_buf_release(&text);
}
END_TEST

START_TEST(test_limits__a_million_objects_are_read)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_scene_desc desc;
    struct pen_errors errors = {0};
    struct pen_buf text = {0};
    limits.body_bytes = limits.parsed_bytes = (size_t)1 << 30;
    write_groups(&text, 90909);
    ck_assert(load(&text, &limits, &desc, &errors));
    ck_assert_uint_eq(desc.primitive_count, 909090);
    pen_buf_release(&text);
}
END_TEST

START_TEST(test_limits__the_defaults_are_those_of_the_format)
{
    struct pen_limits limits = pen_limits_default();
    ck_assert_uint_eq(limits.body_bytes, 16 * 1024 * 1024);
    ck_assert_int_eq(limits.nesting, 64);
    ck_assert_uint_eq(limits.objects, 1000000);
    ck_assert_uint_eq(limits.pixels_per_view, 64000000);
    ck_assert_uint_eq(limits.views, 64);
    ck_assert_double_eq(limits.work, 1e13);
}
END_TEST

PEN_SUITE("io/limits", test_limits__work_counts_shadow_rays_of_every_light,
          test_limits__work_takes_the_largest_sample_count_in_use,
          test_limits__a_target_error_goes_with_some_settings_only,
          test_limits__pixels_and_work_are_refused_just_above_their_limits,
          test_limits__work_counts_the_surfaces_of_paths_that_fork,
          test_limits__work_counts_blurred_rays, test_limits__builtin_scenes_fit,
          test_limits__objects_are_counted_with_their_groups,
          test_limits__a_million_objects_are_read,
          test_limits__the_defaults_are_those_of_the_format)
