/* SPDX-License-Identifier: MIT */
/* Render settings, from a `render` object or from `key=value` of a command line. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"
#include "io/message.h"
#include "io/scene/reader.h"
#include "io/scene/tables.h"
#include "io/settings_json.h"

/* The bounds of an edge and of a depth limit the memory of a tile and of a path. The number of
 * pixels and of rays is limited elsewhere (io/scene_json.h). */
static const struct pen_range edge_range = {1, 65536, false, false};
static const struct pen_range depth_range = {1, 65536, false, false};
static const struct pen_range threads_range = {0, INT_MAX, false, false};

static const struct pen_word patterns[] = {{"sobol", PEN_PATTERN_SOBOL, NULL},
                                           {"grid", PEN_PATTERN_GRID, NULL},
                                           {"random", PEN_PATTERN_RANDOM, NULL},
                                           {0}};

static const struct pen_word precisions[] = {
    {"robust", PEN_PRECISION_ROBUST, NULL},
    {"fast", PEN_PRECISION_FAST, "the precision \"fast\"; only \"robust\" is accepted so far"},
    {0}};

static const struct pen_word accelerators[] = {
    {"auto", PEN_ACCEL_AUTO, NULL},     {"none", PEN_ACCEL_NONE, NULL},
    {"cbr", PEN_ACCEL_CBR, NULL},       {"manual", PEN_ACCEL_MANUAL, NULL},
    {"median", PEN_ACCEL_MEDIAN, NULL}, {0}};

static const struct pen_word transfers[] = {{"srgb", PEN_SETTING_SRGB, NULL},
                                            {"linear", PEN_SETTING_LINEAR, NULL},
                                            {"display", PEN_SETTING_DISPLAY, NULL},
                                            {0}};

static const struct pen_word qualities[] = {{"draft", PEN_QUALITY_DRAFT, NULL},
                                            {"good", PEN_QUALITY_GOOD, NULL},
                                            {"final", PEN_QUALITY_FINAL, NULL},
                                            {"reference", PEN_QUALITY_REFERENCE, NULL},
                                            {0}};

/* The target of pen_settings_fields: the settings, and values that are read but not kept. */
struct target {
    struct pen_settings settings;
    int quality; /* enum pen_quality */
};

#define MEMBER(name) offsetof(struct target, settings.name)

const struct pen_field pen_settings_fields[] = {
    {"width", PEN_FIELD_INTEGER, .offset = MEMBER(width), .range = &pen_range_count},
    {"height", PEN_FIELD_INTEGER, .offset = MEMBER(height), .range = &pen_range_count},
    {"samples_per_pixel", PEN_FIELD_INTEGER, .offset = MEMBER(samples_per_pixel),
     .range = &pen_range_count},
    {"light_samples", PEN_FIELD_INTEGER, .offset = MEMBER(light_samples),
     .range = &pen_range_count},
    {"light_pattern", PEN_FIELD_WORD, .offset = MEMBER(light_pattern), .words = patterns},
    {"blur_samples", PEN_FIELD_INTEGER, .offset = MEMBER(blur_samples), .range = &pen_range_count},
    {"lens_samples", PEN_FIELD_INTEGER, .offset = MEMBER(lens_samples), .range = &pen_range_count},
    {"max_depth", PEN_FIELD_INTEGER, .offset = MEMBER(max_depth), .range = &depth_range},
    {"min_contribution", PEN_FIELD_NUMBER, .offset = MEMBER(min_contribution),
     .range = &pen_range_unit},
    {"target_error", PEN_FIELD_NUMBER, .offset = MEMBER(target_error),
     .range = &pen_range_not_negative},
    {"max_samples", PEN_FIELD_INTEGER, .offset = MEMBER(max_samples), .range = &pen_range_count},
    {"precision", PEN_FIELD_WORD, .offset = MEMBER(precision), .words = precisions},
    {"accelerator", PEN_FIELD_WORD, .offset = MEMBER(accelerator), .words = accelerators},
    {"transfer", PEN_FIELD_WORD, .offset = MEMBER(transfer), .words = transfers},
    {"quality", PEN_FIELD_WORD, .offset = offsetof(struct target, quality), .words = qualities},
    {"seed", PEN_FIELD_SEED, .offset = MEMBER(seed)},
    {"tile", PEN_FIELD_INTEGER, .offset = MEMBER(tile), .range = &edge_range},
    {"threads", PEN_FIELD_INTEGER, .offset = MEMBER(threads), .range = &threads_range},
    {0}};

/* Applies a preset. It comes before the keys beside it, which are more specific. A value that is no
 * preset is refused with them. */
static void set_quality(const json_t *name, struct pen_settings *settings)
{
    for (const struct pen_word *w = qualities; w->name && json_is_string(name); w++)
        if (strcmp(w->name, json_string_value(name)) == 0)
            pen_settings_set_quality(settings, (enum pen_quality)w->value);
}

bool pen_settings_fields_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                              struct pen_settings *settings)
{
    struct target target = {.settings = *settings};
    set_quality(json_object_get(json, "quality"), &target.settings);
    bool ok = pen_fields_read(r, at, json, pen_settings_fields, &target);
    if (ok)
        *settings = target.settings;
    return ok;
}

bool pen_settings_read(const json_t *render, const char *at, struct pen_settings *settings,
                       struct pen_errors *errors)
{
    const struct pen_place root = {0};
    struct pen_reader r = {.errors = errors, .prefix = at};
    return pen_settings_fields_read(&r, &root, render, settings);
}

bool pen_settings_has(const char *key)
{
    return pen_field_find(pen_settings_fields, key) != NULL;
}

const char *pen_settings_nearest(const char *word)
{
    enum { NAMES = 64 };
    const char *names[NAMES];
    int count = 0;
    for (const struct pen_field *field = pen_settings_fields; field->key && count < NAMES - 1;
         field++)
        names[count++] = field->key;
    names[count] = NULL;
    return pen_nearest_name(word, names);
}

bool pen_settings_read_member(const char *key, const json_t *value, const char *at,
                              struct pen_settings *settings, struct pen_errors *errors)
{
    const struct pen_place root = {0};
    struct pen_reader r = {.errors = errors, .prefix = at};
    struct target target = {.settings = *settings};
    if (strcmp(key, "quality") == 0)
        set_quality(value, &target.settings);
    bool ok = pen_fields_read_member(&r, &root, key, value, pen_settings_fields, &target);
    if (ok)
        *settings = target.settings;
    return ok;
}

json_t *pen_settings_parse_value(const char *text, size_t bytes, struct pen_status *st)
{
    const struct pen_limits limits = pen_limits_default();
    struct pen_status not_json;
    if (!pen_utf8_is_valid(text, bytes)) {
        pen_fail(st, PEN_USAGE, "the value must be text in UTF-8");
        return NULL;
    }
    json_t *value = pen_json_parse(text, bytes, &limits, &not_json);
    if (!value && !(value = json_stringn(text, bytes)))
        pen_fail(st, PEN_NO_MEMORY, "no memory for a setting");
    return value;
}

/* Fills *st with the error of an assignment key=value: it begins with the key. */
static bool fail_assignment(const struct pen_status *error, const char *key, struct pen_status *st)
{
    bool names_key = pen_settings_has(key); /* else the message itself names the unknown key */
    return pen_fail(st, error->code == PEN_INVALID ? PEN_USAGE : error->code, "%s%s%s",
                    names_key ? key : "", names_key ? " " : "", error->msg);
}

bool pen_settings_set(struct pen_settings *settings, const char *assignment, struct pen_status *st)
{
    const char *equals = strchr(assignment, '=');
    if (!equals || equals == assignment)
        return pen_fail(st, PEN_USAGE, "%s is no setting: write key=value",
                        pen_text_quote(assignment).text);
    struct pen_errors errors = {0};
    struct pen_status cause;
    char *key = strndup(assignment, (size_t)(equals - assignment));
    json_t *value = pen_settings_parse_value(equals + 1, strlen(equals + 1), &cause);
    bool ok = key && value && pen_settings_read_member(key, value, "", settings, &errors);
    if (!key)
        pen_fail(st, PEN_NO_MEMORY, "no memory for a setting");
    else if (!ok)
        fail_assignment(value ? &errors.item[0] : &cause, key, st);
    json_decref(value);
    free(key);
    return ok;
}
