/* SPDX-License-Identifier: MIT */
/* Specs of accuracy studies: the errors and their places, the rows that a ladder makes. */
#include <stdlib.h>
#include <string.h>

#include "jobs/accuracy_spec.h"
#include "support/kit.h"
#include "support/suite.h"

static struct pen_accuracy_spec spec;
static struct pen_errors errors;
static struct kit kit;

static bool read_text(const char *text)
{
    json_error_t error;
    json_t *members = json_loads(text, 0, &error);
    ck_assert_msg(members != NULL, "%s: %s", error.text, text);
    errors = (struct pen_errors){0};
    const bool ok = pen_accuracy_spec_read(members, &kit.desc, &kit.settings, &spec, &errors);
    json_decref(members);
    ck_assert_msg(ok == (errors.count == 0), "%s", text);
    return ok;
}

static void read_good(const char *text)
{
    if (!read_text(text))
        ck_abort_msg("%s: %s: %s", text, errors.item[0].at, errors.item[0].msg);
}

struct bad {
    const char *text, *at, *words;
};

static const struct bad bad_members[] = {
    {"{\"ladder\": [1]}", "/ladder", "must be an object of render settings"},
    {"{\"ladder\": {}}", "/ladder", "one setting at least"},
    {"{\"ladder\": {\"light_samples\": 4}}", "/ladder/light_samples", "must be an array"},
    {"{\"ladder\": {\"light_samples\": [4, 0]}}", "/ladder/light_samples/1", "found 0"},
    {"{\"ladder\": {\"light_samples\": [4, 4]}}", "/ladder/light_samples/1", "twice"},
    {"{\"ladder\": {\"light_sample\": [4]}}", "/ladder/light_sample",
     "did you mean \"light_samples\"?"},
    {"{\"ladder\": {\"threads\": [1, 2]}}", "/ladder/threads",
     "must be a setting on which accuracy depends: samples_per_pixel,"},
    {"{\"ladder\": {\"light_samples\": [1, 2], \"target_error\": [0.1]}, \"product\": true}",
     "/ladder/target_error", "must not be part of a product"},
    {"{\"product\": 1}", "/product", "must be true or false, found 1"},
    {"{\"reference\": 1}", "/reference", "found 1"},
    {"{\"reference\": {\"light_samples\": 0}}", "/reference/light_samples", "found 0"},
    {"{\"reference\": {\"target_error\": 0.1}}", "/reference/target_error", "fixed numbers"},
    {"{\"reference\": {\"width\": 100}}", "/reference/width", "the same in all pictures"},
    {"{\"target\": 0.02}", "/target", "must be an object"},
    {"{\"target\": {\"metric\": \"flop\", \"value\": 1}}", "/target/metric",
     "must be one of rmse, relative_mse, psnr, ssim, flip, max_error, found the string \"flop\""},
    {"{\"target\": {\"metric\": \"flip\"}}", "/target/value", "is missing"},
    {"{\"target\": {\"metric\": \"flip\", \"value\": 0}}", "/target/value", "found 0"},
    {"{\"target\": {\"metric\": \"flip\", \"value\": 1, \"x\": 1}}", "/target/x", "unknown key"},
    {"{\"seeds\": 0}", "/seeds", "from 1 to 64, found 0"},
    {"{\"seeds\": 65}", "/seeds", "from 1 to 64, found 65"},
    {"{\"budget_seconds\": 0}", "/budget_seconds", "above 0 and at most 86400, found 0"},
};

START_TEST(test_accuracy_spec__errors_name_their_place)
{
    kit_medley(&kit);
    for (size_t i = 0; i < sizeof bad_members / sizeof bad_members[0]; i++) {
        const struct bad *bad = &bad_members[i];
        ck_assert_msg(!read_text(bad->text), "accepted: %s", bad->text);
        const struct pen_status *st = &errors.item[0];
        ck_assert_msg(errors.count == 1, "%s: %zu errors", bad->text, errors.count);
        ck_assert_msg(strcmp(st->at, bad->at) == 0, "%s: at %s", bad->text, st->at);
        ck_assert_msg(strstr(st->msg, bad->words) != NULL, "%s: %s", bad->text, st->msg);
        pen_accuracy_spec_release(&spec);
    }
}
END_TEST

START_TEST(test_accuracy_spec__rows_change_one_setting_at_a_time)
{
    kit_medley(&kit);
    kit.settings.light_samples = 4;
    kit.settings.max_depth = 3;
    kit.settings.target_error = 0.1;
    read_good("{\"ladder\": {\"light_samples\": [1, 4, 9], \"max_depth\": [1, 2],"
              " \"light_pattern\": [\"grid\"], \"target_error\": [0.5]}}");
    static const struct {
        int light, depth, pattern;
        double target;
    } wanted[] = {{4, 3, PEN_PATTERN_SOBOL, 0},  {1, 3, PEN_PATTERN_SOBOL, 0},
                  {9, 3, PEN_PATTERN_SOBOL, 0},  {4, 1, PEN_PATTERN_SOBOL, 0},
                  {4, 2, PEN_PATTERN_SOBOL, 0},  {4, 3, PEN_PATTERN_GRID, 0},
                  {4, 3, PEN_PATTERN_SOBOL, 0.5}};
    ck_assert_int_eq(spec.row_count, 7);
    for (int i = 0; i < 7; i++) {
        const struct pen_settings *s = &spec.rows[i].settings;
        ck_assert_int_eq(s->light_samples, wanted[i].light);
        ck_assert_int_eq(s->max_depth, wanted[i].depth);
        ck_assert_int_eq(s->light_pattern, wanted[i].pattern);
        ck_assert(s->target_error == wanted[i].target);
        ck_assert_uint_eq(json_object_size(spec.rows[i].varied), 4);
    }
    pen_accuracy_spec_release(&spec);
}
END_TEST

START_TEST(test_accuracy_spec__only_setting_has_its_rows_in_order)
{
    kit_medley(&kit);
    kit.settings.light_samples = 4;
    read_good("{\"ladder\": {\"light_samples\": [1, 4, 9]}}");
    ck_assert_int_eq(spec.row_count, 3);
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(spec.rows[i].settings.light_samples, i == 0 ? 1 : i == 1 ? 4 : 9);
    pen_accuracy_spec_release(&spec);
    read_good(
        "{\"ladder\": {\"light_samples\": [1, 9]}}"); /* the settings as they are come first */
    ck_assert_int_eq(spec.row_count, 3);
    ck_assert_int_eq(spec.rows[0].settings.light_samples, 4);
    pen_accuracy_spec_release(&spec);
}
END_TEST

START_TEST(test_accuracy_spec__product_has_all_combinations)
{
    kit_medley(&kit);
    read_good(
        "{\"ladder\": {\"light_samples\": [1, 2], \"max_depth\": [1, 2, 3]}, \"product\": true}");
    ck_assert_int_eq(spec.row_count, 6);
    for (int i = 0; i < 6; i++) {
        ck_assert_int_eq(spec.rows[i].settings.light_samples, 1 + i / 3);
        ck_assert_int_eq(spec.rows[i].settings.max_depth, 1 + i % 3);
    }
    pen_accuracy_spec_release(&spec);
    ck_assert(!read_text("{\"ladder\": {\"light_samples\": [1, 2, 3, 4, 5, 6, 7, 8, 9],"
                         " \"max_depth\": [1, 2, 3, 4, 5, 6, 7, 8]}, \"product\": true}"));
    ck_assert_ptr_nonnull(strstr(errors.item[0].msg, "makes 72 rows, at most 64"));
    pen_accuracy_spec_release(&spec);
}
END_TEST

START_TEST(test_accuracy_spec__defaults_follow_the_scene)
{
    kit_medley(&kit);
    for (uint32_t i = 0; i < kit.desc.light_count; i++)
        kit.lights[i].radius = kit.lights[i].angular_radius = 0;
    read_good("{}");
    ck_assert_int_eq(spec.seeds, 5);
    ck_assert(spec.metric == PEN_METRIC_FLIP && spec.target == 0.02 && spec.budget_s == 60);
    ck_assert_ptr_nonnull(json_object_get(spec.ladder, "samples_per_pixel"));
    pen_accuracy_spec_release(&spec);
    kit.lights[0].radius = 0.5;
    read_good("{}");
    ck_assert_uint_eq(json_object_size(spec.ladder), 2);
    ck_assert_ptr_nonnull(json_object_get(spec.ladder, "light_samples"));
    ck_assert_ptr_nonnull(json_object_get(spec.ladder, "samples_per_pixel"));
    pen_accuracy_spec_release(&spec);
    kit.view.camera.aperture_radius = 0.25;
    kit.view.camera.focus_distance = 8;
    read_good("{}");
    ck_assert_uint_eq(json_object_size(spec.ladder), 2);
    ck_assert_ptr_nonnull(json_object_get(spec.ladder, "light_samples"));
    ck_assert_ptr_nonnull(json_object_get(spec.ladder, "lens_samples"));
    pen_accuracy_spec_release(&spec);
}
END_TEST

START_TEST(test_accuracy_spec__members_are_read_back)
{
    kit_medley(&kit);
    read_good("{\"ladder\": {\"max_depth\": [1, 2]}, \"product\": true, \"seeds\": 2,"
              " \"reference\": {\"max_depth\": 9}, \"budget_seconds\": 7,"
              " \"target\": {\"metric\": \"psnr\", \"value\": 40}}");
    json_t *members = pen_accuracy_spec_members(&spec, json_object());
    struct pen_accuracy_spec again;
    ck_assert(pen_accuracy_spec_read(members, NULL, &kit.settings, &again, &errors));
    ck_assert_int_eq(again.row_count, 2);
    ck_assert(again.product && again.seeds == 2 && again.budget_s == 7);
    ck_assert(again.metric == PEN_METRIC_PSNR && again.target == 40);
    ck_assert(json_equal(again.reference, spec.reference));
    json_decref(members);
    pen_accuracy_spec_release(&again);
    pen_accuracy_spec_release(&spec);
}
END_TEST

PEN_SUITE("accuracy_spec", test_accuracy_spec__errors_name_their_place,
          test_accuracy_spec__rows_change_one_setting_at_a_time,
          test_accuracy_spec__only_setting_has_its_rows_in_order,
          test_accuracy_spec__product_has_all_combinations,
          test_accuracy_spec__defaults_follow_the_scene, test_accuracy_spec__members_are_read_back)
