/* SPDX-License-Identifier: MIT */
#include "io/xml/values.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "io/json/memory.h"

/* The text of an attribute while it is read. */
struct text {
    const char *s;
    size_t at, bytes;
    struct pen_json_numbers *numbers;
    size_t *bytes_left;
    struct pen_xml_value_error *error;
};

bool pen_xml_token(const char *text, size_t bytes, size_t index, size_t *start, size_t *end)
{
    size_t at = 0;
    for (;; index--) {
        while (at < bytes && (pen_xml_is_space(text[at]) || text[at] == ';'))
            at++;
        *start = at;
        while (at < bytes && !pen_xml_is_space(text[at]) && text[at] != ';')
            at++;
        *end = at;
        if (index == 0 || *end == *start)
            return *end > *start;
    }
}

static void skip_space(struct text *t)
{
    while (t->at < t->bytes && pen_xml_is_space(t->s[t->at]))
        t->at++;
}

static json_t *no_memory(struct text *t)
{
    t->error->no_memory = true;
    return NULL;
}

/* Reserves the memory of a value before it is made. Fails if that exceeds the limit. */
static bool reserve(struct text *t, size_t bytes)
{
    t->error->over_limit = t->error->over_limit || bytes > *t->bytes_left;
    *t->bytes_left -= t->error->over_limit ? 0 : bytes;
    return !t->error->over_limit;
}

static json_t *fail(struct text *t, size_t offset, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static json_t *fail(struct text *t, size_t offset, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(t->error->msg.text, sizeof t->error->msg.text, format, args);
    va_end(args);
    t->error->offset = offset;
    return NULL;
}

/* Reads the token up to white space or a semicolon: a number, or a string if it is not a number. */
static json_t *next_token(struct text *t)
{
    size_t start = t->at;
    struct pen_json_decimal decimal;
    while (t->at < t->bytes && !pen_xml_is_space(t->s[t->at]) && t->s[t->at] != ';')
        t->at++;
    json_t *value = NULL;
    size_t bytes;
    bool number = pen_java_scan_number(t->s, start, t->at, &decimal, &bytes) == t->at;
    size_t cost = number ? PEN_JSON_NUMBER_BYTES : PEN_JSON_STRING_BYTES + (t->at - start);
    if (!reserve(t, cost + PEN_JSON_ELEMENT_BYTES))
        return NULL;
    if (!number)
        value = json_stringn(t->s + start, t->at - start);
    else if (!pen_json_number(t->numbers, t->s + start, bytes, &decimal, &value))
        return fail(t, start, "%.*s is too large for a number: they reach to about 1.8e308",
                    t->at - start > 60 ? 60 : (int)(t->at - start), t->s + start);
    return value ? value : no_memory(t);
}

/* Appends a value and takes ownership of it. If it is NULL, an error has been reported. */
static bool append(struct text *t, json_t *list, json_t *value)
{
    if (value && json_array_append_new(list, value) != 0)
        no_memory(t);
    return value && !t->error->no_memory;
}

/* Reads the tokens up to the end or a semicolon as a list. */
static json_t *read_tokens(struct text *t)
{
    if (!reserve(t, PEN_JSON_ARRAY_BYTES))
        return NULL;
    json_t *list = json_array();
    if (!list)
        return no_memory(t);
    for (skip_space(t); t->at < t->bytes && t->s[t->at] != ';'; skip_space(t)) {
        if (!append(t, list, next_token(t))) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

/* Frees the value and returns NULL. */
static json_t *discard(json_t *value)
{
    json_decref(value);
    return NULL;
}

static const char *plural(size_t count)
{
    return count == 1 ? "" : "s";
}

/* Reads exactly `wanted` tokens and nothing after them. */
static json_t *read_numbers(struct text *t, size_t wanted)
{
    json_t *list = read_tokens(t);
    size_t found = json_array_size(list);
    if (!list || (found == wanted && t->at == t->bytes))
        return list;
    if (t->at < t->bytes)
        fail(t, t->at, "must be %zu numbers separated by white space, found a semicolon", wanted);
    else if (found == 0)
        fail(t, 0, "must be %zu numbers separated by white space, found none", wanted);
    else
        fail(t, 0, "must be %zu numbers separated by white space, found %zu", wanted, found);
    return discard(list);
}

/* Divides numbers by 255. A token that is not a number stays a string, which the scene reader
 * refuses. */
static json_t *read_colour(struct text *t)
{
    json_t *list = read_numbers(t, 3);
    for (size_t i = 0; list && i < 3; i++) {
        json_t *number = json_array_get(list, i);
        if (!json_is_number(number))
            continue;
        double value = json_number_value(number);
        json_t *scaled = value == 0 ? json_integer(0) : json_real(value / 255);
        if (json_array_set_new(list, i, scaled) != 0) {
            no_memory(t);
            return discard(list);
        }
    }
    return list;
}

/* Takes the only element out of a list and frees the list with its share of the memory limit. */
static json_t *only_item(struct text *t, json_t *list)
{
    json_t *value = json_incref(json_array_get(list, 0));
    json_decref(list);
    *t->bytes_left += PEN_JSON_ARRAY_BYTES + PEN_JSON_ELEMENT_BYTES;
    return value;
}

static json_t *read_one(struct text *t)
{
    json_t *list = read_tokens(t);
    size_t found = json_array_size(list);
    if (!list)
        return NULL;
    if (found != 1 || t->at < t->bytes) {
        fail(t, 0, "must be one number, found %s", found ? "more" : "none");
        return discard(list);
    }
    return only_item(t, list);
}

static json_t *read_factor(struct text *t)
{
    json_t *list = read_tokens(t);
    size_t found = json_array_size(list);
    if (!list || (found == 3 && t->at == t->bytes))
        return list;
    if (found != 1 || t->at < t->bytes) {
        fail(t, 0, "must be a number from 0 to 1, or 3 such numbers (red, green, blue), found %zu",
             found);
        return discard(list);
    }
    return only_item(t, list);
}

static json_t *read_point(struct text *t, size_t number)
{
    skip_space(t);
    size_t start = t->at;
    json_t *point = reserve(t, PEN_JSON_ELEMENT_BYTES) ? read_tokens(t) : NULL;
    size_t found = json_array_size(point);
    if (!point || found == 3)
        return point;
    fail(t, start,
         "must be points of 3 numbers, separated by semicolons; point %zu has %zu number%s", number,
         found, plural(found));
    return discard(point);
}

static json_t *read_points(struct text *t)
{
    if (!reserve(t, PEN_JSON_ARRAY_BYTES))
        return NULL;
    json_t *list = json_array();
    if (!list)
        return no_memory(t);
    for (size_t number = 1;; number++) {
        if (!append(t, list, read_point(t, number)))
            return discard(list);
        if (t->at == t->bytes)
            return list;
        t->at++; /* the semicolon */
    }
}

static json_t *read_text(struct text *t)
{
    if (!reserve(t, PEN_JSON_STRING_BYTES + t->bytes))
        return NULL;
    json_t *value = json_stringn(t->s, t->bytes);
    return value ? value : no_memory(t);
}

static json_t *read_bool(struct text *t)
{
    bool yes = strcmp(t->s, "true") == 0;
    return yes || strcmp(t->s, "false") == 0 ? json_boolean(yes) : read_text(t);
}

static json_t *read_axis(struct text *t)
{
    skip_space(t);
    char c = t->s[t->at];
    if ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'))
        return read_text(t);
    return read_numbers(t, 3);
}

static json_t *read_shape(struct text *t, enum pen_xml_shape shape)
{
    switch (shape) {
    case PEN_XML_HIDDEN:
    case PEN_XML_TEXT:
        return read_text(t);
    case PEN_XML_NUMBER:
        return read_one(t);
    case PEN_XML_BOOL:
        return read_bool(t);
    case PEN_XML_TRIPLE:
        return read_numbers(t, 3);
    case PEN_XML_COLOUR:
        return read_colour(t);
    case PEN_XML_FACTOR:
        return read_factor(t);
    case PEN_XML_MATRIX:
        return read_numbers(t, 12);
    case PEN_XML_PAIR:
        return read_numbers(t, 2);
    case PEN_XML_POINTS:
        return read_points(t);
    case PEN_XML_AXIS:
        return read_axis(t);
    }
    return NULL;
}

json_t *pen_xml_value(enum pen_xml_shape shape, const char *text, struct pen_json_numbers *numbers,
                      size_t *bytes_left, struct pen_xml_value_error *error)
{
    struct text t = {.s = text,
                     .bytes = strlen(text),
                     .numbers = numbers,
                     .bytes_left = bytes_left,
                     .error = error};
    size_t before = *bytes_left;
    *error = (struct pen_xml_value_error){0};
    json_t *value = read_shape(&t, shape);
    if (!value) /* all values made for this attribute have been freed */
        *bytes_left = before;
    return value;
}
