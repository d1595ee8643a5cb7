/* SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <string.h>

#include "io/scene_json.h"
#include "io/settings_json.h"
#include "support/suite.h"

static struct pen_settings set_all(const char *const *assignments)
{
    struct pen_settings settings = pen_settings_default();
    struct pen_status st = {0};
    for (; *assignments; assignments++)
        ck_assert_msg(pen_settings_set(&settings, *assignments, &st), "%s: %s", *assignments,
                      st.msg);
    return settings;
}

/* The code and message of an assignment that must fail and change nothing. */
static struct pen_status refuse(const char *assignment)
{
    struct pen_settings settings = pen_settings_default(), before = settings;
    struct pen_status st = {0};
    ck_assert_msg(!pen_settings_set(&settings, assignment, &st), "%s was accepted", assignment);
    ck_assert_int_eq(memcmp(&settings, &before, sizeof settings), 0);
    return st;
}

START_TEST(test_settings__every_key_can_be_set_from_a_command_line)
{
    static const char *const assignments[] = {
        "width=1000",       "height=1400.0",       "samples_per_pixel=4",
        "light_samples=64", "blur_samples=3",      "lens_samples=5",
        "max_samples=6",    "light_pattern=grid",  "max_depth=2",
        "tile=16",          "min_contribution=0",  "precision=robust",
        "accelerator=none", "transfer=\"linear\"", "seed=9007199254740992",
        "threads=3",        "target_error=0",      NULL};
    struct pen_settings s = set_all(assignments);
    ck_assert_int_eq(s.width, 1000);
    ck_assert_int_eq(s.height, 1400);
    ck_assert_int_eq(s.samples_per_pixel, 4);
    ck_assert_int_eq(s.light_samples, 64);
    ck_assert_int_eq(s.blur_samples, 3);
    ck_assert_int_eq(s.lens_samples, 5);
    ck_assert_int_eq(s.max_samples, 6);
    ck_assert_int_eq(s.light_pattern, PEN_PATTERN_GRID);
    ck_assert_int_eq(s.max_depth, 2);
    ck_assert_int_eq(s.tile, 16);
    ck_assert_double_eq(s.min_contribution, 0);
    ck_assert_int_eq(s.accelerator, PEN_ACCEL_NONE);
    ck_assert_int_eq(s.transfer, PEN_SETTING_LINEAR);
    ck_assert_uint_eq(s.seed, UINT64_C(1) << 53);
    ck_assert_int_eq(s.threads, 3);
}
END_TEST

START_TEST(test_settings__a_wrong_assignment_names_its_key)
{
    struct pen_status st = refuse("acelerator=none");
    ck_assert_int_eq(st.code, PEN_USAGE);
    ck_assert_str_eq(st.msg, "unknown key \"acelerator\"; did you mean \"accelerator\"?");
    st = refuse("accelerator=non");
    ck_assert_int_eq(st.code, PEN_USAGE);
    ck_assert_ptr_nonnull(strstr(st.msg, "accelerator must be one of \"auto\", \"none\", \"cbr\","
                                         " \"manual\", \"median\", found"));
    ck_assert_ptr_nonnull(strstr(st.msg, "did you mean \"none\"?"));
    ck_assert_str_eq(refuse("width=0").msg, "width must be an integer of at least 1, found 0");
    ck_assert_str_eq(refuse("width=").msg,
                     "width must be an integer of at least 1, found the string \"\"");
    ck_assert_str_eq(refuse("width").msg, "\"width\" is no setting: write key=value");
    ck_assert_int_eq(refuse("=1").code, PEN_USAGE);
    ck_assert_int_eq(refuse("wi\xffth=1").code, PEN_USAGE);
    ck_assert_int_eq(refuse("width={\"a\": 1, \"a\": 2}").code, PEN_USAGE);
}
END_TEST

START_TEST(test_settings__every_accelerator_has_its_word)
{
    for (int kind = 0; kind < PEN_ACCEL_COUNT; kind++) {
        struct pen_settings s = pen_settings_default();
        struct pen_status st;
        char assignment[64];
        snprintf(assignment, sizeof assignment, "accelerator=%s",
                 pen_accelerator_name((enum pen_accelerator)kind));
        ck_assert_msg(pen_settings_set(&s, assignment, &st), "%s", st.msg);
        ck_assert_int_eq(s.accelerator, kind);
    }
}
END_TEST

START_TEST(test_settings__unsupported_features_are_refused_as_such)
{
    struct pen_status st = refuse("precision=fast");
    ck_assert_int_eq(st.code, PEN_UNSUPPORTED);
    ck_assert_ptr_nonnull(strstr(st.msg, "precision known, not supported yet"));
}
END_TEST

/* A preset, then what the keys beside it say, in whatever order they stand. */
START_TEST(test_settings__a_preset_comes_before_the_keys_beside_it)
{
    static const struct {
        const char *json;
        double target_error, min_contribution;
        int samples_per_pixel, light_samples, max_samples;
    } cases[] = {
        {"{\"quality\": \"draft\"}", 0, 0.5, 1, 4, 9},
        {"{\"quality\": \"good\"}", 0.02, 0.5, 7, 8, 9},
        {"{\"quality\": \"final\"}", 0.005, 0.5, 7, 8, 9},
        {"{\"quality\": \"reference\"}", 0.001, 0.0001, 7, 8, 65536},
        {"{\"light_samples\": 50, \"quality\": \"draft\"}", 0, 0.5, 1, 50, 9},
        {"{\"target_error\": 0.3, \"quality\": \"final\", \"max_samples\": 5}", 0.3, 0.5, 7, 8, 5}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct pen_settings s = pen_settings_default();
        struct pen_errors errors = {0};
        s.samples_per_pixel = 7;
        s.light_samples = 8;
        s.max_samples = 9;
        s.min_contribution = 0.5;
        s.light_pattern = PEN_PATTERN_GRID;
        json_t *json = json_loads(cases[i].json, 0, NULL);
        ck_assert(pen_settings_read(json, "/render", &s, &errors));
        json_decref(json);
        ck_assert(s.target_error == cases[i].target_error);
        ck_assert(s.min_contribution == cases[i].min_contribution);
        ck_assert_int_eq(s.samples_per_pixel, cases[i].samples_per_pixel);
        ck_assert_int_eq(s.light_samples, cases[i].light_samples);
        ck_assert_int_eq(s.max_samples, cases[i].max_samples);
        ck_assert_int_eq(s.light_pattern, PEN_PATTERN_SOBOL);
    }
    struct pen_settings s = pen_settings_default();
    struct pen_status st;
    ck_assert(pen_settings_set(&s, "quality=draft", &st) && s.light_samples == 4);
    ck_assert(pen_settings_set(&s, "light_samples=5", &st) && s.light_samples == 5);
    ck_assert_int_eq(refuse("quality=best").code, PEN_USAGE);
}
END_TEST

START_TEST(test_settings__a_job_overrides_what_it_names_and_nothing_else)
{
    struct pen_settings settings = pen_settings_default();
    struct pen_errors errors = {0};
    json_t *scene = json_pack("{s:i, s:i}", "width", 10, "height", 20);
    json_t *job = json_pack("{s:i}", "height", 30);
    ck_assert(pen_settings_read(scene, "/scene/render", &settings, &errors));
    ck_assert(pen_settings_read(job, "/render", &settings, &errors));
    ck_assert_int_eq(settings.width, 10);
    ck_assert_int_eq(settings.height, 30);
    ck_assert_int_eq(settings.max_depth, 10);
    json_decref(scene);
    json_decref(job);
}
END_TEST

START_TEST(test_settings__one_bad_key_leaves_all_as_they_were)
{
    struct pen_settings settings = pen_settings_default();
    struct pen_errors errors = {0};
    json_t *render = json_pack("{s:i, s:i}", "width", 10, "height", -1);
    ck_assert(!pen_settings_read(render, "/render", &settings, &errors));
    ck_assert_uint_eq(errors.count, 1);
    ck_assert_str_eq(errors.item[0].at, "/render/height");
    ck_assert_int_eq(settings.width, 800);
    json_decref(render);
}
END_TEST

static void check_same(const struct pen_settings *a, const struct pen_settings *b)
{
    ck_assert(a->width == b->width && a->height == b->height);
    ck_assert(a->samples_per_pixel == b->samples_per_pixel);
    ck_assert(a->light_samples == b->light_samples && a->light_pattern == b->light_pattern);
    ck_assert(a->blur_samples == b->blur_samples && a->lens_samples == b->lens_samples);
    ck_assert(a->max_samples == b->max_samples && a->max_depth == b->max_depth);
    ck_assert(a->min_contribution == b->min_contribution && a->target_error == b->target_error);
    ck_assert(a->precision == b->precision && a->accelerator == b->accelerator);
    ck_assert(a->transfer == b->transfer && a->seed == b->seed);
    ck_assert(a->tile == b->tile && a->threads == b->threads);
}

/* Reads the JSON of the settings on top of the defaults. */
static void check_json(const struct pen_settings *settings)
{
    struct pen_settings read = pen_settings_default();
    struct pen_errors errors = {0};
    json_t *json = pen_settings_json(settings);
    ck_assert_ptr_nonnull(json);
    ck_assert_msg(pen_settings_read(json, "", &read, &errors), "%s", errors.item[0].msg);
    check_same(&read, settings);
    json_decref(json);
}

START_TEST(test_settings__json_reads_back_to_the_same_settings)
{
    static const char *const numbers[] = {"width=1001",
                                          "height=1402",
                                          "samples_per_pixel=3",
                                          "light_samples=4",
                                          "blur_samples=5",
                                          "lens_samples=6",
                                          "max_samples=7",
                                          "max_depth=8",
                                          "tile=9",
                                          "threads=10",
                                          "min_contribution=0.1",
                                          "seed=9007199254740992",
                                          NULL};
    static const char *const words[] = {
        "light_pattern=sobol", "light_pattern=grid", "light_pattern=random", "accelerator=auto",
        "accelerator=none",    "accelerator=cbr",    "accelerator=manual",   "accelerator=median",
        "transfer=srgb",       "transfer=linear",    "precision=robust"};
    struct pen_settings settings = set_all(numbers);
    check_json(&settings);
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        const char *const one[] = {words[i], NULL};
        settings = set_all(one);
        check_json(&settings);
    }
}
END_TEST

PEN_SUITE("io/settings", test_settings__every_key_can_be_set_from_a_command_line,
          test_settings__a_wrong_assignment_names_its_key,
          test_settings__every_accelerator_has_its_word,
          test_settings__unsupported_features_are_refused_as_such,
          test_settings__a_preset_comes_before_the_keys_beside_it,
          test_settings__a_job_overrides_what_it_names_and_nothing_else,
          test_settings__one_bad_key_leaves_all_as_they_were,
          test_settings__json_reads_back_to_the_same_settings)
