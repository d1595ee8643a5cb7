/* SPDX-License-Identifier: MIT */
#include "jobs/accuracy_spec.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "io/json_build.h"
#include "io/settings_json.h"
#include "jobs/internal/members.h"

/* The settings that a ladder may have as keys. */
static const char *const ladder_keys[] = {"samples_per_pixel", "light_samples", "light_pattern",
                                          "blur_samples",      "lens_samples",  "max_depth",
                                          "min_contribution",  "target_error",  NULL};
static const char target_key[] = "target_error";

enum { DEFAULT_SEEDS = 5 };
static const double default_budget_s = 60, default_flip = 0.02;

/* Makes the default ladder: each kind of samples that the scene calls for, and samples of the
 * pixel's area, because every picture has edges. Through a lens, lens_samples are these. If the
 * ladder has them all, target errors add samples only at edges. Fails: NULL when out of memory. */
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
        if (!pen_settings_has(key) || pen_name_index(key, ladder_keys) >= 0)
            continue;
        pen_request_fail(errors, PEN_INVALID, "/ladder", key,
                         "must be a setting on which accuracy depends: %s",
                         pen_names(ladder_keys).text);
        ok = false;
    }
    if (!spec->product || json_object_size(spec->ladder) < 2 ||
        !json_object_get(spec->ladder, target_key))
        return ok;
    pen_request_fail(errors, PEN_INVALID, "/ladder", target_key,
                     "must not be part of a product: it takes the place of numbers of samples");
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
        const bool is_target = strcmp(key, target_key) == 0;
        if (!pen_settings_has(key) || (!is_target && pen_name_index(key, ladder_keys) >= 0))
            continue;
        pen_request_fail(errors, PEN_INVALID, "/reference", key,
                         is_target
                             ? "must not be there: a reference has fixed numbers of samples"
                             : "must not be there: it is the same in all pictures of the study");
        ok = false;
    }
    spec->reference = json_incref(value);
    return ok;
}

static bool read_target(const json_t *members, struct pen_accuracy_spec *spec,
                        struct pen_errors *errors)
{
    static const char *const names[] = {"metric", "value", NULL};
    const json_t *target = json_object_get(members, "target");
    if (!target)
        return true;
    if (!json_is_object(target)) {
        pen_request_fail(errors, PEN_INVALID, "", "target",
                         "must be an object {\"metric\": …, \"value\": …}, found %s",
                         pen_found(target).text);
        return false;
    }
    bool ok = pen_keys_check(target, "/target", names, errors);
    for (int i = 0; names[i]; i++) {
        if (json_object_get(target, names[i]))
            continue;
        pen_request_fail(errors, PEN_INVALID, "/target", names[i], "is missing");
        ok = false;
    }
    if (!ok)
        return false;
    const int metric =
        pen_word_read(json_object_get(target, "metric"), "/target", "metric", pen_metrics, errors);
    spec->metric = metric >= 0 ? (enum pen_metric)metric : spec->metric;
    return pen_number_read(target, "/target", "value", PEN_ABOVE_0, DBL_MAX, "above 0",
                           &spec->target, errors) &&
           metric >= 0;
}

/* Returns the values that the ladder's settings have in `base`. */
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

/* Adds a row with these values; takes the reference to them. */
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

/* Returns true if one of the ladder's rows has the settings as they are. Only one setting may
 * vary. */
static bool has_base(const struct pen_accuracy_spec *spec, const json_t *values)
{
    void *only = json_object_iter(spec->ladder);
    return json_object_size(spec->ladder) == 1 &&
           pen_setting_listed(json_object_iter_value(only),
                              json_object_get(values, json_object_iter_key(only)));
}

/* Adds the settings as they are, then each single change. */
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
            if (!ok || (!listed && pen_value_equal(value, json_object_get(values, key))))
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
    for (int i = 0; ok && i < rows; i++)
        ok = add_row(spec, base, pen_setting_lists_combination(spec->ladder, i));
    return ok;
}

/* Returns the most rows that the ladder may make. */
static double count_rows(const struct pen_accuracy_spec *spec)
{
    const char *key;
    json_t *list;
    double sum = 1;
    json_object_foreach(spec->ladder, key, list)
    {
        sum += (double)json_array_size(list);
    }
    return spec->product ? pen_setting_lists_product(spec->ladder) : sum;
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
    bool ok = pen_boolean_read(members, "product", &spec->product, errors);
    ok &= read_reference(members, spec, errors);
    ok &= read_target(members, spec, errors);
    ok &= pen_integer_read(members, "", "seeds", 1, PEN_ACCURACY_SEEDS_MAX, &spec->seeds, errors);
    ok &= pen_number_read(members, "", "budget_seconds", PEN_ABOVE_0, PEN_ACCURACY_BUDGET_MAX_S,
                          "above 0 and at most 86400", &spec->budget_s, errors);
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
    object = pen_json_with(
        object, "target",
        json_pack("{s:s, s:f}", "metric", pen_metrics[spec->metric], "value", spec->target));
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
