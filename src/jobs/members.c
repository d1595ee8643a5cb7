/* SPDX-License-Identifier: MIT */
/* The reader of `render` objects reads each value of a list, so both allow the same values. */
#include "jobs/internal/members.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "io/json_build.h"
#include "io/message.h"
#include "io/settings_json.h"

enum { AT_BYTES = 2 * PEN_AT_BYTES };

/* Appends a key to a JSON Pointer, escaped: "a~b" becomes "/a~0b". */
static void append_token(char *at, size_t bytes, const char *key)
{
    size_t used = strlen(at);
    if (used + 1 < bytes)
        at[used++] = '/';
    for (; *key && used + 2 < bytes; key++) {
        if (*key == '~' || *key == '/') {
            at[used++] = '~';
            at[used++] = *key == '~' ? '0' : '1';
        } else {
            at[used++] = *key;
        }
    }
    at[used] = '\0';
}

void pen_request_fail(struct pen_errors *errors, enum pen_code code, const char *up,
                      const char *key, const char *format, ...)
{
    char at[AT_BYTES], text[2 * PEN_MSG_BYTES];
    struct pen_status st;
    va_list args;
    snprintf(at, sizeof at, "%s", up);
    if (key)
        append_token(at, sizeof at, key);
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    pen_fail_at(&st, code, at, "%s", text);
    pen_errors_add(errors, &st);
}

struct pen_found pen_found(const json_t *value)
{
    struct pen_found found;
    pen_value_describe(value, found.text, sizeof found.text);
    return found;
}

struct pen_found pen_did_you_mean(const char *name)
{
    struct pen_found hint = {""};
    if (name)
        snprintf(hint.text, sizeof hint.text, "; did you mean \"%s\"?", name);
    return hint;
}

struct pen_found pen_names(const char *const *names)
{
    struct pen_found list = {""};
    size_t used = 0;
    for (int i = 0; names[i] && used < sizeof list.text; i++)
        used += (size_t)snprintf(list.text + used, sizeof list.text - used, "%s%s", i ? ", " : "",
                                 names[i]);
    return list;
}

struct pen_found pen_position(size_t i)
{
    struct pen_found position;
    snprintf(position.text, sizeof position.text, "%zu", i);
    return position;
}

int pen_name_index(const char *word, const char *const *names)
{
    for (int i = 0; word && names[i]; i++)
        if (strcmp(word, names[i]) == 0)
            return i;
    return -1;
}

bool pen_boolean_read(const json_t *members, const char *key, bool *out, struct pen_errors *errors)
{
    const json_t *value = json_object_get(members, key);
    if (value)
        *out = json_is_true(value);
    if (!value || json_is_boolean(value))
        return true;
    pen_request_fail(errors, PEN_INVALID, "", key, "must be true or false, found %s",
                     pen_found(value).text);
    return false;
}

bool pen_integer_read(const json_t *members, const char *up, const char *key, int lo, int hi,
                      int *out, struct pen_errors *errors)
{
    const json_t *value = json_object_get(members, key);
    const double number = json_number_value(value);
    if (!value)
        return true;
    if (!json_is_number(value) || number != floor(number) || number < lo || number > hi) {
        pen_request_fail(errors, PEN_INVALID, up, key, "must be an integer from %d to %d, found %s",
                         lo, hi, pen_found(value).text);
        return false;
    }
    *out = (int)number;
    return true;
}

bool pen_number_read(const json_t *members, const char *up, const char *key, double least,
                     double most, const char *range, double *out, struct pen_errors *errors)
{
    const json_t *value = json_object_get(members, key);
    const double number = json_number_value(value);
    if (!value)
        return true;
    if (!json_is_number(value) || !(number >= least && number <= most)) {
        pen_request_fail(errors, PEN_INVALID, up, key, "must be a number %s, found %s", range,
                         pen_found(value).text);
        return false;
    }
    *out = number;
    return true;
}

int pen_word_read(const json_t *value, const char *up, const char *key, const char *const *names,
                  struct pen_errors *errors)
{
    const char *word = json_string_value(value);
    const int found = pen_name_index(word, names);
    if (found >= 0)
        return found;
    pen_request_fail(errors, PEN_INVALID, up, key, "must be one of %s, found %s%s",
                     pen_names(names).text, pen_found(value).text,
                     pen_did_you_mean(word ? pen_nearest_name(word, names) : NULL).text);
    return -1;
}

bool pen_keys_check(const json_t *object, const char *up, const char *const *names,
                    struct pen_errors *errors)
{
    const char *key;
    json_t *value;
    bool ok = true;
    json_object_foreach((json_t *)(uintptr_t)object, key, value)
    {
        if (pen_name_index(key, names) >= 0)
            continue;
        pen_request_fail(errors, PEN_INVALID, up, key, "unknown key; the keys here are %s",
                         pen_names(names).text);
        ok = false;
    }
    return ok;
}

/* Reads entry i of the list of the setting `key` into *settings. The place of an error is the
 * entry, or the list if there is no such setting. */
static bool read_value(const char *up, const char *key, const json_t *value, size_t i,
                       struct pen_settings *settings, struct pen_errors *errors)
{
    struct pen_errors found = {0};
    bool ok = pen_settings_read_member(key, value, up, settings, &found);
    for (size_t e = 0; e < found.count; e++)
        pen_request_fail(errors, found.item[e].code, found.item[e].at,
                         pen_settings_has(key) ? pen_position(i).text : NULL, "%s",
                         found.item[e].msg);
    return ok;
}

static bool check_list(const char *up, const char *key, const json_t *list,
                       struct pen_errors *errors)
{
    struct pen_settings scratch = pen_settings_default();
    char at[PEN_AT_BYTES];
    bool ok = true;
    size_t i;
    json_t *value;
    if (!json_is_array(list) || json_array_size(list) == 0) {
        pen_request_fail(errors, PEN_INVALID, up, key,
                         "must be an array of one or more values of this setting, found %s",
                         pen_found(list).text);
        return false;
    }
    snprintf(at, sizeof at, "%s/%s", up, key);
    json_array_foreach(list, i, value)
    {
        ok &= read_value(up, key, value, i, &scratch, errors);
        if (!pen_settings_has(key))
            return false;
        for (size_t k = 0; k < i; k++) {
            if (!json_equal(json_array_get(list, k), value))
                continue;
            pen_request_fail(errors, PEN_INVALID, at, pen_position(i).text, "%s is there twice",
                             pen_found(value).text);
            ok = false;
        }
    }
    return ok;
}

bool pen_setting_lists_check(const json_t *lists, const char *name, struct pen_errors *errors)
{
    char up[24];
    const char *key;
    json_t *list;
    bool ok = true;
    snprintf(up, sizeof up, "/%s", name);
    if (!json_is_object(lists)) {
        pen_request_fail(errors, PEN_INVALID, "", name,
                         "must be an object of render settings, each with an array of values, "
                         "found %s",
                         pen_found(lists).text);
        return false;
    }
    json_object_foreach((json_t *)(uintptr_t)lists, key, list)
    {
        ok &= check_list(up, key, list, errors);
    }
    return ok;
}

bool pen_value_equal(const json_t *a, const json_t *b)
{
    return json_is_number(a) && json_is_number(b) ? json_number_value(a) == json_number_value(b)
                                                  : json_equal(a, b);
}

bool pen_setting_listed(const json_t *list, const json_t *value)
{
    size_t i;
    json_t *item;
    json_array_foreach(list, i, item)
    {
        if (pen_value_equal(item, value))
            return true;
    }
    return false;
}

double pen_setting_lists_product(const json_t *lists)
{
    const char *key;
    json_t *list;
    double product = 1;
    json_object_foreach((json_t *)(uintptr_t)lists, key, list)
    {
        product *= (double)json_array_size(list);
    }
    return product;
}

json_t *pen_setting_lists_combination(const json_t *lists, int number)
{
    const char *key;
    json_t *list, *chosen = json_object();
    int left = (int)pen_setting_lists_product(lists);
    json_object_foreach((json_t *)(uintptr_t)lists, key, list)
    {
        left /= (int)json_array_size(list);
        chosen =
            pen_json_with(chosen, key, json_incref(json_array_get(list, (size_t)(number / left))));
        number %= left;
    }
    return chosen;
}
