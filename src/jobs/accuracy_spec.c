/* SPDX-License-Identifier: MIT */
#include "jobs/accuracy_spec.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/json_build.h"
#include "io/settings_json.h"
#include "jobs/internal/request_errors.h"
#include "jobs/internal/setting_lists.h"

/* The settings that a ladder may have. */
static const char *const ladder_keys[] = {"samples_per_pixel", "light_samples", "light_pattern",
                                          "blur_samples",      "lens_samples",  "max_depth",
                                          "min_contribution",  "target_error",  NULL};
static const char target_key[] = "target_error";

enum { DEFAULT_SEEDS = 5 };
static const double default_budget_s = 60, default_flip = 0.02;

static bool is_one_of(const char *key, const char *const *names)
{
    for (; *names; names++)
        if (strcmp(key, *names) == 0)
            return true;
    return false;
}

/* "a, b and c" of the ladder's keys. */
static void list_keys(char *text, size_t bytes)
{
    size_t used = 0;
    for (int i = 0; ladder_keys[i]; i++)
        used += (size_t)snprintf(text + used, bytes - used, "%s%s", i ? ", " : "", ladder_keys[i]);
}

/* The ladder of a study that has none: each kind of samples that the scene calls for, with those of
 * the pixel's area, since edges are in each picture. Through a lens, lens_samples are these. Where
 * they are all, target errors take samples to the edges alone. Fails: NULL when out of memory. */
static json_t *default_ladder(const struct pen_scene_desc *desc, const struct pen_settings *base)
{
    const unsigned effects = pen_desc_effects(desc, base);
    json_t *ladder = json_object();
    if (effects & PEN_FX_SOFT_SHADOWS)
        ladder =
            pen_json_with(ladder, "light_samples", json_pack("[i,i,i,i,i]", 1, 4, 16, 64, 256));
    if (pen_effects_blur(effects))
        ladder = pen_json_with(ladder, "blur_samples", json_pack("[i,i,i,i]", 1, 4, 16, 64));
    if (effects & PEN_FX_DEPTH_OF_FIELD)
        ladder = pen_json_with(ladder, "lens_samples", json_pack("[i,i,i,i]", 4, 16, 64, 256));
    else
        ladder = pen_json_with(ladder, "samples_per_pixel", json_pack("[i,i,i,i]", 1, 4, 16, 64));
    if (ladder && json_object_size(ladder) == 1 && !(effects & PEN_FX_DEPTH_OF_FIELD))
        ladder = pen_json_with(ladder, target_key, json_pack("[f,f,f]", 0.02, 0.01, 0.005));
    return ladder;
}

static bool check_ladder(const struct pen_accuracy_spec *spec, struct pen_errors *errors)
{
    const char *key;
    json_t *list;
    bool ok = pen_setting_lists_check(spec->ladder, "ladder", errors);
    if (ok && json_object_size(spec->ladder) == 0) {
        pen_request_fail(errors, PEN_INVALID, "", "ladder", "must have one setting at least");
        return false;
    }
    json_object_foreach(spec->ladder, key, list)
    {
        char keys[160];
        if (!pen_settings_has(key) || is_one_of(key, ladder_keys))
            continue;
        list_keys(keys, sizeof keys);
        pen_request_fail(errors, PEN_INVALID, "/ladder", key,
                         "must be a setting on which accuracy depends: %s", keys);
        ok = false;
    }
    if (!spec->product || json_object_size(spec->ladder) < 2 ||
        !json_object_get(spec->ladder, target_key))
        return ok;
    pen_request_fail(errors, PEN_INVALID, "/ladder", target_key,
                     "must not be part of a product: it takes the place of numbers of samples");
    return false;
}

static bool read_product(const json_t *members, struct pen_accuracy_spec *spec,
                         struct pen_errors *errors)
{
    const json_t *value = json_object_get(members, "product");
    spec->product = json_is_true(value);
    if (!value || json_is_boolean(value))
        return true;
    pen_request_fail(errors, PEN_INVALID, "", "product", "must be true or false, found %s",
                     pen_found(value).text);
    return false;
}

static bool read_reference(const json_t *members, struct pen_accuracy_spec *spec,
                           struct pen_errors *errors)
{
    json_t *value = json_object_get(members, "reference");
    struct pen_settings scratch = pen_settings_default();
    const char *key;
    json_t *setting;
    if (!value)
        return true;
    bool ok = pen_settings_read(value, "/reference", &scratch, errors);
    json_object_foreach(value, key, setting)
    {
        if (!pen_settings_has(key) || (is_one_of(key, ladder_keys) && strcmp(key, target_key) != 0))
            continue;
        pen_request_fail(errors, PEN_INVALID, "/reference", key,
                         strcmp(key, target_key) == 0
                             ? "must not be there: a reference has fixed numbers of samples"
                             : "must not be there: it is the same in all pictures of the study");
        ok = false;
    }
    spec->reference = json_incref(value);
    return ok;
}

static bool read_metric(const json_t *value, struct pen_accuracy_spec *spec,
                        struct pen_errors *errors)
{
    const char *name = json_string_value(value);
    int m = 0;
    while (name && m < PEN_METRIC_COUNT && strcmp(name, pen_accuracy_metrics[m]) != 0)
        m++;
    if (name && m < PEN_METRIC_COUNT) {
        spec->metric = (enum pen_accuracy_metric)m;
        return true;
    }
    pen_request_fail(errors, PEN_INVALID, "/target", "metric",
                     "must be one of rmse, relative_mse, psnr, ssim, flip, max_error, found %s",
                     pen_found(value).text);
    return false;
}

static bool read_target_value(const json_t *value, struct pen_accuracy_spec *spec,
                              struct pen_errors *errors)
{
    const double number = json_number_value(value);
    if (json_is_number(value) && number > 0) {
        spec->target = number;
        return true;
    }
    pen_request_fail(errors, PEN_INVALID, "/target", "value", "must be a number above 0, found %s",
                     pen_found(value).text);
    return false;
}

static const char *const members_of_target[] = {"metric", "value", NULL};

static bool read_target(const json_t *members, struct pen_accuracy_spec *spec,
                        struct pen_errors *errors)
{
    json_t *target = json_object_get(members, "target"), *value;
    const char *key;
    bool ok = true;
    if (!target)
        return true;
    if (!json_is_object(target)) {
        pen_request_fail(errors, PEN_INVALID, "", "target",
                         "must be an object {\"metric\": …, \"value\": …}, found %s",
                         pen_found(target).text);
        return false;
    }
    json_object_foreach(target, key, value)
    {
        if (is_one_of(key, members_of_target))
            continue;
        pen_request_fail(errors, PEN_INVALID, "/target", key,
                         "unknown key; the keys here are metric, value");
        ok = false;
    }
    for (int i = 0; members_of_target[i]; i++) {
        if (json_object_get(target, members_of_target[i]))
            continue;
        pen_request_fail(errors, PEN_INVALID, "/target", members_of_target[i], "is missing");
        ok = false;
    }
    if (!ok)
        return false;
    ok = read_metric(json_object_get(target, "metric"), spec, errors);
    return read_target_value(json_object_get(target, "value"), spec, errors) && ok;
}

/* The values that the ladder's settings have in `base`. */
static json_t *base_values(const struct pen_accuracy_spec *spec, const struct pen_settings *base)
{
    json_t *all = pen_settings_json(base), *values = json_object();
    const char *key;
    json_t *list;
    json_object_foreach(spec->ladder, key, list)
    {
        json_t *value = json_object_get(all, key);
        values = pen_json_with(values, key, value ? json_incref(value) : json_integer(0));
    }
    json_decref(all);
    return values;
}

/* Adds a row with these values. Takes the reference to them. */
static bool add_row(struct pen_accuracy_spec *spec, const struct pen_settings *base, json_t *varied)
{
    struct pen_errors none = {0};
    struct pen_accuracy_row *row = &spec->rows[spec->row_count];
    if (!varied)
        return false;
    *row = (struct pen_accuracy_row){.settings = *base, .varied = varied};
    spec->row_count++;
    return pen_settings_read(varied, "", &row->settings, &none);
}

static bool is_equal(const json_t *a, const json_t *b)
{
    return json_is_number(a) && json_is_number(b) ? json_number_value(a) == json_number_value(b)
                                                  : json_equal(a, b);
}

static bool is_listed(const json_t *list, const json_t *value)
{
    size_t i;
    json_t *item;
    json_array_foreach(list, i, item)
    {
        if (is_equal(item, value))
            return true;
    }
    return false;
}

/* Whether the settings as they are stand among the ladder's rows, where only one setting varies. */
static bool has_base(const struct pen_accuracy_spec *spec, const json_t *values)
{
    void *only = json_object_iter(spec->ladder);
    return json_object_size(spec->ladder) == 1 &&
           is_listed(json_object_iter_value(only),
                     json_object_get(values, json_object_iter_key(only)));
}

/* The settings as they are, and one change at a time. */
static bool add_single_rows(struct pen_accuracy_spec *spec, const struct pen_settings *base)
{
    const char *key;
    json_t *list, *value, *values = base_values(spec, base);
    size_t i;
    const bool listed = has_base(spec, values);
    bool ok = listed || add_row(spec, base, json_copy(values));
    json_object_foreach(spec->ladder, key, list)
    {
        json_array_foreach(list, i, value)
        {
            if (!ok || (!listed && is_equal(value, json_object_get(values, key))))
                continue;
            json_t *varied = json_copy(values);
            ok = varied && json_object_set(varied, key, value) == 0;
            ok = add_row(spec, base, varied) && ok;
        }
    }
    json_decref(values);
    return ok;
}

static bool add_product_rows(struct pen_accuracy_spec *spec, const struct pen_settings *base,
                             int rows)
{
    bool ok = true;
    for (int number = 0; ok && number < rows; number++) {
        const char *key;
        json_t *list, *varied = json_object();
        int left = rows, rest = number;
        json_object_foreach(spec->ladder, key, list)
        {
            left /= (int)json_array_size(list);
            varied = pen_json_with(varied, key,
                                   json_incref(json_array_get(list, (size_t)(rest / left))));
            rest %= left;
        }
        ok = add_row(spec, base, varied);
    }
    return ok;
}

/* The most rows that the ladder may make. */
static double count_rows(const struct pen_accuracy_spec *spec)
{
    const char *key;
    json_t *list;
    double sum = 1, product = 1;
    json_object_foreach(spec->ladder, key, list)
    {
        sum += (double)json_array_size(list);
        product *= (double)json_array_size(list);
    }
    return spec->product ? product : sum;
}

static bool make_rows(struct pen_accuracy_spec *spec, const struct pen_settings *base,
                      struct pen_errors *errors)
{
    struct pen_settings fixed = *base;
    const double rows = count_rows(spec);
    if (rows > PEN_ACCURACY_ROWS_MAX) {
        pen_request_fail(errors, PEN_INVALID, "", "ladder",
                         "makes %.0f rows, at most %d are allowed", rows,
                         (int)PEN_ACCURACY_ROWS_MAX);
        return false;
    }
    fixed.target_error = 0;
    spec->rows = calloc((size_t)rows, sizeof *spec->rows);
    if (spec->rows &&
        (spec->product ? add_product_rows(spec, &fixed, (int)rows) : add_single_rows(spec, &fixed)))
        return true;
    pen_request_fail(errors, PEN_NO_MEMORY, "", NULL, "no memory for %.0f rows", rows);
    return false;
}

bool pen_accuracy_spec_read(const json_t *members, const struct pen_scene_desc *desc,
                            const struct pen_settings *base, struct pen_accuracy_spec *spec,
                            struct pen_errors *errors)
{
    json_t *ladder = json_object_get(members, "ladder");
    *spec = (struct pen_accuracy_spec){.metric = PEN_METRIC_FLIP,
                                       .target = default_flip,
                                       .seeds = DEFAULT_SEEDS,
                                       .budget_s = default_budget_s};
    bool ok = read_product(members, spec, errors);
    ok &= read_reference(members, spec, errors);
    ok &= read_target(members, spec, errors);
    ok &= pen_count_read(members, "seeds", 1, PEN_ACCURACY_SEEDS_MAX, &spec->seeds, errors);
    ok &= pen_number_read(members, "budget_seconds", false, PEN_ACCURACY_BUDGET_MAX_S,
                          &spec->budget_s, errors);
    if (!ladder && !desc)
        return false;
    spec->ladder = ladder ? json_incref(ladder) : default_ladder(desc, base);
    if (!spec->ladder) {
        pen_request_fail(errors, PEN_NO_MEMORY, "", NULL, "no memory for a ladder");
        return false;
    }
    return check_ladder(spec, errors) && make_rows(spec, base, errors) && ok;
}

void pen_accuracy_spec_release(struct pen_accuracy_spec *spec)
{
    for (int i = 0; i < spec->row_count; i++)
        json_decref((json_t *)(uintptr_t)spec->rows[i].varied);
    free(spec->rows);
    json_decref(spec->ladder);
    json_decref(spec->reference);
    *spec = (struct pen_accuracy_spec){0};
}

json_t *pen_accuracy_spec_members(const struct pen_accuracy_spec *spec, json_t *object)
{
    object = pen_json_with(object, "ladder", json_incref(spec->ladder));
    object = pen_json_with(object, "product", json_boolean(spec->product));
    if (spec->reference)
        object = pen_json_with(object, "reference", json_incref(spec->reference));
    object = pen_json_with(object, "target",
                           json_pack("{s:s, s:f}", "metric", pen_accuracy_metrics[spec->metric],
                                     "value", spec->target));
    object = pen_json_with(object, "seeds", json_integer(spec->seeds));
    return pen_json_with(object, "budget_seconds", json_real(spec->budget_s));
}

struct pen_accuracy_task pen_accuracy_of_spec(const struct pen_accuracy_spec *spec)
{
    return (struct pen_accuracy_task){.rows = spec->rows,
                                      .row_count = spec->row_count,
                                      .reference = spec->reference,
                                      .metric = spec->metric,
                                      .target = spec->target,
                                      .seeds = spec->seeds,
                                      .budget_ms = spec->budget_s * 1000};
}
