/* SPDX-License-Identifier: MIT */
/* The reader of `render` objects reads each value of a list, so the same values are allowed in
 * both.
 */
#include "jobs/internal/setting_lists.h"

#include <stdio.h>
#include <string.h>

#include "io/settings_json.h"
#include "jobs/internal/request_errors.h"

/* Reads entry i of the list of the setting `key` into *settings. The place of an error is the
 * entry, or the list if there is no such setting. */
static bool read_value(const char *up, const char *key, const json_t *value, size_t i,
                       struct pen_settings *settings, struct pen_errors *errors)
{
    struct pen_errors found = {0};
    bool known = pen_settings_has(key);
    bool ok = pen_settings_read_member(key, value, up, settings, &found);
    for (size_t e = 0; e < found.count; e++) {
        struct pen_status *error = &found.item[e];
        char at[PEN_AT_BYTES], place[24];
        snprintf(at, sizeof at, "%s", error->at);
        snprintf(place, sizeof place, "%zu", i);
        pen_request_fail(errors, error->code, at, known ? place : NULL, "%s", error->msg);
    }
    return ok;
}

static bool check_list(const char *up, const char *key, const json_t *list,
                       struct pen_errors *errors)
{
    struct pen_settings scratch = pen_settings_default();
    bool ok = true;
    size_t i;
    json_t *value;
    if (!json_is_array(list) || json_array_size(list) == 0) {
        pen_request_fail(errors, PEN_INVALID, up, key,
                         "must be an array of one or more values of this setting, found %s",
                         pen_found(list).text);
        return false;
    }
    json_array_foreach(list, i, value)
    {
        ok &= read_value(up, key, value, i, &scratch, errors);
        if (!pen_settings_has(key))
            return false;
        for (size_t k = 0; k < i; k++) {
            char at[PEN_AT_BYTES], place[24];
            if (!json_equal(json_array_get(list, k), value))
                continue;
            snprintf(at, sizeof at, "%s/%s", up, key);
            snprintf(place, sizeof place, "%zu", i);
            pen_request_fail(errors, PEN_INVALID, at, place, "%s is there twice",
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

bool pen_count_read(const json_t *members, const char *key, int lo, int hi, int *out,
                    struct pen_errors *errors)
{
    const json_t *value = json_object_get(members, key);
    double number = json_number_value(value);
    if (!value)
        return true;
    if (!json_is_number(value) || !(number >= lo && number <= hi) || number != (int)number) {
        pen_request_fail(errors, PEN_INVALID, "", key, "must be an integer from %d to %d, found %s",
                         lo, hi, pen_found(value).text);
        return false;
    }
    *out = (int)number;
    return true;
}

bool pen_number_read(const json_t *members, const char *key, bool zero, double hi, double *out,
                     struct pen_errors *errors)
{
    const json_t *value = json_object_get(members, key);
    const double number = json_number_value(value);
    if (!value)
        return true;
    if (!json_is_number(value) || !(zero ? number >= 0 : number > 0) || number > hi) {
        pen_request_fail(errors, PEN_INVALID, "", key, "must be a number %s %g, found %s",
                         zero ? "from 0 to" : "above 0 and at most", hi, pen_found(value).text);
        return false;
    }
    *out = number;
    return true;
}
