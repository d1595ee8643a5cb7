/* SPDX-License-Identifier: MIT */
/* Single values of a scene: numbers in a range, vectors, words. Each message names the allowed
 * values and the value found. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "io/scene/reader.h"

const struct pen_range pen_range_any = {-PEN_NUMBER_MAX, PEN_NUMBER_MAX, false, false};
const struct pen_range pen_range_positive = {0, PEN_NUMBER_MAX, true, false};
const struct pen_range pen_range_not_negative = {0, PEN_NUMBER_MAX, false, false};
const struct pen_range pen_range_unit = {0, 1, false, false};
/* pen_sincos_deg takes angles up to 2^20 degrees. */
const struct pen_range pen_range_turn = {-1e6, 1e6, false, false};
const struct pen_range pen_range_count = {1, INT_MAX, false, false};

static bool inside(const struct pen_range *range, double v)
{
    bool above = range->lo_open ? v > range->lo : v >= range->lo;
    bool below = range->hi_open ? v < range->hi : v <= range->hi;
    return above && below;
}

/* The allowed values in words: "a number from 0 to 1". Bounds that only keep arithmetic finite are
 * named only if the number found exceeds them. */
static struct pen_text range_text(const char *noun, const struct pen_range *range, double found)
{
    bool lo = range->lo > -PEN_NUMBER_MAX || found < range->lo;
    bool hi = range->hi < INT_MAX || found > range->hi;
    struct pen_text a = pen_text_number(range->lo), b = pen_text_number(range->hi), out;
    const char *from = range->lo_open ? "greater than" : "of at least";
    const char *to = range->hi_open ? "less than" : "at most";
    if (lo && hi && !range->lo_open && !range->hi_open)
        snprintf(out.text, sizeof out.text, "%s from %.30s to %.30s", noun, a.text, b.text);
    else if (lo && hi)
        snprintf(out.text, sizeof out.text, "%s %s %.30s and %s %.30s", noun, from, a.text, to,
                 b.text);
    else if (lo)
        snprintf(out.text, sizeof out.text, "%s %s %.30s", noun, from, a.text);
    else if (hi)
        snprintf(out.text, sizeof out.text, "%s %s%s %.30s", noun, range->hi_open ? "" : "of ", to,
                 b.text);
    else
        snprintf(out.text, sizeof out.text, "%s", noun);
    return out;
}

static bool number_in(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                      const struct pen_range *range, bool integral)
{
    double v = json_is_number(value) ? json_number_value(value) : NAN;
    if (inside(range, v) && (!integral || v == floor(v)))
        return true;
    struct pen_text allowed = range_text(integral ? "an integer" : "a number", range, v);
    struct pen_text found = pen_reader_found(r, at, value);
    return pen_reader_fail(r, at, PEN_INVALID, "must be %s, found %s", allowed.text, found.text);
}

bool pen_read_number(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                     const struct pen_range *range, double *out)
{
    if (!number_in(r, at, value, range, false))
        return false;
    *out = json_number_value(value);
    return true;
}

bool pen_read_integer(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                      const struct pen_range *range, int *out)
{
    if (!number_in(r, at, value, range, true))
        return false;
    *out = (int)json_number_value(value);
    return true;
}

/* A JSON integer is compared as an integer, because 2^53 + 1 is not a double. */
bool pen_read_seed(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                   uint64_t *out)
{
    const int64_t most = INT64_C(1) << 53;
    const struct pen_range range = {0, (double)most, false, false};
    if (json_is_integer(value) && json_integer_value(value) > most) {
        struct pen_text found = pen_reader_found(r, at, value);
        return pen_reader_fail(r, at, PEN_INVALID, "must be an integer from 0 to %lld, found %s",
                               (long long)most, found.text);
    }
    if (!number_in(r, at, value, &range, true))
        return false;
    *out = json_is_integer(value) ? (uint64_t)json_integer_value(value)
                                  : (uint64_t)json_real_value(value);
    return true;
}

static bool triple_elements(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                            const struct pen_range *range, double out[3])
{
    bool ok = true;
    for (size_t i = 0; i < 3; i++) {
        struct pen_place place = pen_place_index(at, i);
        ok &= pen_read_number(r, &place, json_array_get(value, i), range, &out[i]);
    }
    return ok;
}

static bool read_three(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                       const struct pen_range *range, double out[3])
{
    if (json_array_size(value) == 3)
        return triple_elements(r, at, value, range, out);
    struct pen_text found = pen_reader_found(r, at, value);
    return pen_reader_fail(r, at, PEN_INVALID, "must be an array of 3 numbers, found %s",
                           found.text);
}

bool pen_read_vec3(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                   const struct pen_range *range, struct pen_vec3 *out)
{
    double v[3];
    if (!read_three(r, at, value, range, v))
        return false;
    *out = pen_vec3(v[0], v[1], v[2]);
    return true;
}

/* The zero vector found, for a message. */
static struct pen_text zeros(const struct pen_reader *r, const struct pen_place *at,
                             const json_t *value)
{
    return pen_reader_is_xml(r) ? pen_reader_found(r, at, value) : (struct pen_text){"[0, 0, 0]"};
}

bool pen_read_direction(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                        struct pen_vec3 *out)
{
    if (!pen_read_vec3(r, at, value, &pen_range_any, out))
        return false;
    if (out->x == 0 && out->y == 0 && out->z == 0)
        return pen_reader_fail(r, at, PEN_INVALID, "must have a length greater than 0, found %s",
                               zeros(r, at, value).text);
    return true;
}

bool pen_read_factor(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                     struct pen_vec3 *out)
{
    double v;
    if (json_is_array(value) && json_array_size(value) == 3)
        return pen_read_vec3(r, at, value, &pen_range_unit, out);
    if (json_is_number(value)) {
        if (!pen_read_number(r, at, value, &pen_range_unit, &v))
            return false;
        *out = pen_vec3(v, v, v);
        return true;
    }
    struct pen_text found = pen_reader_found(r, at, value);
    return pen_reader_fail(
        r, at, PEN_INVALID,
        "must be a number from 0 to 1, or %s3 such numbers (red, green, blue), found %s",
        pen_reader_is_xml(r) ? "" : "an array of ", found.text);
}

bool pen_read_coefficients(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                           double out[3])
{
    if (!read_three(r, at, value, &pen_range_not_negative, out))
        return false;
    if (out[0] == 0 && out[1] == 0 && out[2] == 0)
        return pen_reader_fail(r, at, PEN_INVALID, "must not be all 0, found %s",
                               zeros(r, at, value).text);
    return true;
}

bool pen_read_array(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                    const char *what)
{
    if (json_is_array(value))
        return true;
    struct pen_text found = pen_reader_found(r, at, value);
    return pen_reader_fail(r, at, PEN_INVALID, "must be an array of %s, found %s", what,
                           found.text);
}

bool pen_read_string(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                     const char **out)
{
    if (!json_is_string(value)) {
        struct pen_text found = pen_reader_found(r, at, value);
        return pen_reader_fail(r, at, PEN_INVALID, "must be a string, found %s", found.text);
    }
    size_t bytes = json_string_length(value) + 1;
    char *copy = pen_reader_alloc(r, bytes, 1);
    if (!copy)
        return false;
    *out = memcpy(copy, json_string_value(value), bytes);
    return true;
}

static bool wrong_word(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                       const struct pen_word *words)
{
    enum { WORDS_MAX = 16 };
    const char *names[WORDS_MAX + 1];
    char list[256] = "";
    int count = 0;
    size_t used = 0;
    for (const struct pen_word *w = words; w->name && count < WORDS_MAX; w++) {
        if (w->unsupported)
            continue;
        int n = snprintf(list + used, sizeof list - used, "%s\"%s\"", count ? ", " : "", w->name);
        used += (size_t)n < sizeof list - used ? (size_t)n : 0;
        names[count++] = w->name;
    }
    names[count] = NULL;
    struct pen_text found = pen_reader_found(r, at, value), near = {""};
    if (json_is_string(value))
        near = pen_text_nearest(json_string_value(value), names);
    return pen_reader_fail(r, at, PEN_INVALID, "must be %s%s, found %s%s",
                           count > 1 ? "one of " : "", list, found.text, near.text);
}

bool pen_read_word(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                   const struct pen_word *words, int *out)
{
    if (json_is_string(value)) {
        for (const struct pen_word *w = words; w->name; w++) {
            if (strcmp(w->name, json_string_value(value)) != 0)
                continue;
            *out = w->value;
            return w->unsupported ? pen_reader_unsupported(r, at, w->unsupported) : true;
        }
    }
    return wrong_word(r, at, value, words);
}
