/* SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/buf.h"
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
          test_limits__pixels_and_work_are_refused_just_above_their_limits,
          test_limits__objects_are_counted_with_their_groups,
          test_limits__a_million_objects_are_read,
          test_limits__the_defaults_are_those_of_the_format)
