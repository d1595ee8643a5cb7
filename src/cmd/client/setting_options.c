/* SPDX-License-Identifier: MIT */
#include "cmd/client/setting_options.h"

#include <string.h>

#include "io/scene_json.h"
#include "io/settings_json.h"

static bool apply_one(const char *assignment, struct pen_settings *settings, struct pen_status *st)
{
    struct pen_status cause;
    return pen_settings_set(settings, assignment, &cause) ||
           pen_fail(st, cause.code, "--set %s: %s", assignment, cause.msg);
}

bool pen_set_options_apply(const struct pen_option_list *set, struct pen_settings *settings,
                           struct pen_status *st)
{
    bool ok = true;
    for (int i = 0; ok && i < set->count; i++)
        ok = apply_one(set->item[i], settings, st);
    return ok;
}

bool pen_set_options_add(json_t *job, const struct pen_option_list *set, struct pen_status *st)
{
    struct pen_settings checked = pen_settings_default();
    json_t *render = json_object_get(job, "render");
    if (!pen_set_options_apply(set, &checked, st))
        return false;
    if (set->count > 0 && !json_is_object(render)) {
        render = json_object();
        json_object_set_new(job, "render", render);
    }
    for (int i = 0; i < set->count; i++) {
        const char *equals = strchr(set->item[i], '=');
        json_t *value = pen_settings_parse_value(equals + 1, strlen(equals + 1), st);
        if (!value)
            return false;
        json_object_setn_new(render, set->item[i], (size_t)(equals - set->item[i]), value);
    }
    return true;
}

static bool fail_form(const char *option, const char *text, struct pen_status *st)
{
    return pen_fail(st, PEN_USAGE, "--%s: found \"%s\", allowed is KEY=VALUE,…", option, text);
}

/* "none,auto" -> ["none", "auto"]. */
static json_t *list_of(const char *text)
{
    struct pen_status ignored; /* the caller reports the whole option */
    json_t *list = json_array();
    for (const char *at = text;; at++) {
        size_t bytes = strcspn(at, ",");
        if (bytes == 0 ||
            json_array_append_new(list, pen_settings_parse_value(at, bytes, &ignored)) != 0) {
            json_decref(list);
            return NULL;
        }
        at += bytes;
        if (!*at)
            return list;
    }
}

/* Adds "KEY=VALUE,…" of the option --name to an object of lists. */
static bool add_list(json_t *lists, const char *name, const char *text, struct pen_status *st)
{
    const char *equals = strchr(text, '=');
    size_t length = equals ? (size_t)(equals - text) : 0;
    json_t *list = length ? list_of(equals + 1) : NULL;
    if (!list)
        return fail_form(name, text, st);
    if (json_object_getn(lists, text, length)) {
        json_decref(list);
        return pen_fail(st, PEN_USAGE, "--%s: %.*s is given twice", name, (int)length, text);
    }
    return json_object_setn_new(lists, text, length, list) == 0 || fail_form(name, text, st);
}

/* Adds the lists of an option to a job, as the member of this name. */
static bool add_lists(json_t *job, const char *name, const struct pen_option_list *options,
                      struct pen_status *st)
{
    json_t *lists = options->count > 0 ? json_object() : NULL;
    if (lists && json_object_set_new(job, name, lists) != 0)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    for (int i = 0; i < options->count; i++) {
        if (!add_list(lists, name, options->item[i], st))
            return false;
    }
    return true;
}

/* "accelerator=auto,threads=1" -> {"accelerator": "auto", "threads": 1}. */
static bool add_baseline(json_t *job, const char *text, struct pen_status *st)
{
    struct pen_status ignored;
    json_t *baseline = json_object();
    bool ok = json_object_set_new(job, "baseline", baseline) == 0;
    for (const char *at = text; ok; at++) {
        size_t bytes = strcspn(at, ",");
        const char *equals = memchr(at, '=', bytes);
        size_t length = equals ? (size_t)(equals - at) : 0;
        ok = length > 0 && length + 1 < bytes;
        if (ok) {
            json_t *value = pen_settings_parse_value(equals + 1, bytes - length - 1, &ignored);
            ok = json_object_setn_new(baseline, at, length, value) == 0;
        }
        at += bytes;
        if (!*at)
            break;
    }
    return ok || fail_form("baseline", text, st);
}

static bool is_row(const char *baseline)
{
    return strchr(baseline, '=') != NULL;
}

static bool add_baselines(json_t *job, const struct pen_option_list *baseline,
                          struct pen_status *st)
{
    for (int i = 0; i < baseline->count; i++) {
        if (!is_row(baseline->item[i]))
            continue;
        if (json_object_get(job, "baseline") && i > 0)
            return pen_fail(st, PEN_USAGE, "--baseline: only one row can be the baseline");
        if (!add_baseline(job, baseline->item[i], st))
            return false;
    }
    return true;
}

bool pen_bench_options_report(const struct pen_bench_values *values, const char **report,
                              struct pen_status *st)
{
    const struct pen_option_list *baseline = &values->baseline;
    *report = NULL;
    for (int i = 0; i < baseline->count; i++) {
        if (is_row(baseline->item[i]))
            continue;
        if (*report)
            return pen_fail(st, PEN_USAGE,
                            "--baseline: found the reports \"%s\" and \"%s\", allowed is one",
                            *report, baseline->item[i]);
        *report = baseline->item[i];
    }
    return true;
}

static bool add_integer(json_t *job, const char *key, int value)
{
    return value < 0 || json_object_set_new(job, key, json_integer(value)) == 0;
}

static bool add_real(json_t *job, const char *key, double value)
{
    return value < 0 || json_object_set_new(job, key, json_real(value)) == 0;
}

static bool add_numbers(json_t *job, const struct pen_bench_values *values, struct pen_status *st)
{
    return (add_integer(job, "repeats", values->repeats) &&
            add_integer(job, "warmup", values->warmup) &&
            add_integer(job, "order_seed", values->order_seed) &&
            add_real(job, "interval", values->interval) &&
            add_real(job, "budget_seconds", values->budget) &&
            add_real(job, "least_effect", values->least_effect)) ||
           pen_fail(st, PEN_NO_MEMORY, "out of memory");
}

bool pen_bench_options_add(json_t *job, const struct pen_bench_values *values,
                           struct pen_status *st)
{
    if (!add_lists(job, "matrix", &values->matrix, st))
        return false;
    return add_numbers(job, values, st) && add_baselines(job, &values->baseline, st);
}

/* Adds every "KEY=VALUE" of --reference to an object. */
static bool add_reference(json_t *job, const struct pen_option_list *options, struct pen_status *st)
{
    json_t *reference = options->count > 0 ? json_object() : NULL;
    if (reference && json_object_set_new(job, "reference", reference) != 0)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    for (int i = 0; i < options->count; i++) {
        const char *text = options->item[i], *equals = strchr(text, '=');
        const size_t length = equals ? (size_t)(equals - text) : 0;
        if (length == 0 || !equals[1])
            return pen_fail(st, PEN_USAGE, "--reference: found \"%s\", allowed is KEY=VALUE", text);
        json_t *value = pen_settings_parse_value(equals + 1, strlen(equals + 1), st);
        if (!value || json_object_setn_new(reference, text, length, value) != 0)
            return false;
    }
    return true;
}

/* "flip=0.02" -> {"metric": "flip", "value": 0.02} */
static bool add_target(json_t *job, const char *text, struct pen_status *st)
{
    const char *equals = text ? strchr(text, '=') : NULL;
    if (!text)
        return true;
    if (!equals || equals == text || !equals[1])
        return pen_fail(st, PEN_USAGE, "--target: found \"%s\", allowed is METRIC=VALUE", text);
    json_t *value = pen_settings_parse_value(equals + 1, strlen(equals + 1), st);
    json_t *target =
        value ? json_pack("{s:s#, s:o}", "metric", text, (int)(equals - text), "value", value)
              : NULL;
    return target && (json_object_set_new(job, "target", target) == 0 ||
                      pen_fail(st, PEN_NO_MEMORY, "out of memory"));
}

bool pen_accuracy_options_add(json_t *job, const struct pen_accuracy_values *values,
                              struct pen_status *st)
{
    if (values->product && json_object_set_new(job, "product", json_true()) != 0)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    return add_lists(job, "ladder", &values->ladder, st) &&
           add_reference(job, &values->reference, st) && add_target(job, values->target, st) &&
           (add_integer(job, "seeds", values->seeds) ||
            pen_fail(st, PEN_NO_MEMORY, "out of memory"));
}

/* "/matrix/threads/1" -> "--matrix threads"; "/budget_seconds" -> "--budget". */
static void name_option(struct pen_status *st)
{
    char option[PEN_AT_BYTES + 8], text[PEN_MSG_BYTES];
    if (strcmp(st->at, "/budget_seconds") == 0)
        strcpy(st->at, "/budget");
    size_t length = strcspn(st->at + 1, "/");
    for (char *c = st->at; c <= st->at + length; c++)
        *c = *c == '_' ? '-' : *c;
    const char *key = st->at[length + 1] ? st->at + length + 2 : "";
    snprintf(option, sizeof option, "--%.*s%s%.*s", (int)length, st->at + 1, *key ? " " : "",
             (int)strcspn(key, "/"), key);
    memcpy(text, st->msg, sizeof text);
    pen_fail(st, st->code == PEN_INVALID ? PEN_USAGE : st->code, "%s: %s", option, text);
}

void pen_bench_options_errors(struct pen_errors *errors)
{
    for (size_t i = 0; i < errors->count; i++) {
        if (errors->item[i].at[0])
            name_option(&errors->item[i]);
    }
}
