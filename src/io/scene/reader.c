/* SPDX-License-Identifier: MIT */
/* Errors of the scene reader: how a place becomes a JSON Pointer, and how values are worded.
 * Text from the document goes into messages quoted, escaped and cut: no input can forge or flood
 * one. */
#include "io/scene/reader.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"
#include "io/xml/places.h"

/* Writes text at out[used], as much as fits with an end, escaping as RFC 6901 asks if set. */
static size_t append(char *out, size_t bytes, size_t used, const char *text, bool escape)
{
    for (; *text; text++) {
        const char *piece = escape && *text == '~' ? "~0" : escape && *text == '/' ? "~1" : NULL;
        size_t length = piece ? 2 : 1;
        if (used + length >= bytes)
            break;
        memcpy(out + used, piece ? piece : text, length);
        used += length;
    }
    out[used] = '\0';
    return used;
}

static size_t append_place(const struct pen_place *at, const char *prefix, char *out, size_t bytes)
{
    if (!at->up)
        return append(out, bytes, 0, prefix, false);
    size_t used = append_place(at->up, prefix, out, bytes);
    used = append(out, bytes, used, "/", false);
    if (at->key)
        return append(out, bytes, used, at->key, true);
    char digits[24];
    snprintf(digits, sizeof digits, "%zu", at->index);
    return append(out, bytes, used, digits, false);
}

void pen_place_text(const struct pen_place *at, const char *prefix, char *out, size_t bytes)
{
    append_place(at, prefix, out, bytes);
}

bool pen_reader_fail(struct pen_reader *r, const struct pen_place *at, enum pen_code code,
                     const char *format, ...)
{
    struct pen_status st = {.code = code};
    if (r->xml && pen_xml_is_reported(r->xml, at))
        return false;
    if (pen_reader_explains(r)) {
        /* Longer than a status keeps, so that pen_fail_at sees what it must cut. */
        char pointer[2 * PEN_AT_BYTES], message[2 * PEN_MSG_BYTES];
        pen_place_text(at, r->prefix, pointer, sizeof pointer);
        va_list args;
        va_start(args, format);
        if (vsnprintf(message, sizeof message, format, args) < 0)
            message[0] = '\0';
        va_end(args);
        if (r->xml && code != PEN_NO_MEMORY)
            pen_xml_fail(r->xml, at, code, message, &st);
        else
            pen_fail_at(&st, code, pointer, "%s", message);
    }
    pen_errors_add(r->errors, &st);
    return false;
}

void *pen_reader_alloc(struct pen_reader *r, size_t count, size_t size)
{
    void *memory = r->no_memory ? NULL : pen_arena_alloc(r->arena, count, size);
    if (!memory && !r->no_memory) {
        const struct pen_place root = {0};
        r->no_memory = true;
        pen_reader_fail(r, &root, PEN_NO_MEMORY, "the scene does not fit into the memory allowed");
    }
    return memory;
}

bool pen_reader_later(struct pen_reader *r, const struct pen_place *at, const char *feature)
{
    return pen_reader_fail(r, at, PEN_UNSUPPORTED, "known, not supported yet: %s", feature);
}

/* Copies one character of a string, escaped as in JSON. Returns its length in the source. */
static size_t quote_char(const char *string, char piece[8])
{
    size_t length = pen_utf8_char(string, strnlen(string, 4));
    unsigned char c = (unsigned char)*string;
    if (c == '"' || c == '\\')
        snprintf(piece, 8, "\\%c", c);
    else if (c < 0x20 || c == 0x7F)
        snprintf(piece, 8, "\\u%04x", c);
    else if (length == 0)
        snprintf(piece, 8, "?");
    else
        snprintf(piece, 8, "%.*s", (int)length, string);
    return length ? length : 1;
}

struct pen_text pen_text_quote(const char *string)
{
    enum { SHOWN = 40 };
    struct pen_text out = {"\""};
    size_t used = 1;
    for (int shown = 0; *string && shown < SHOWN; shown++) {
        char piece[8];
        string += quote_char(string, piece);
        used = append(out.text, sizeof out.text - 8, used, piece, false);
    }
    if (*string)
        used = append(out.text, sizeof out.text, used, "\xE2\x80\xA6", false);
    append(out.text, sizeof out.text, used, "\"", false);
    return out;
}

struct pen_text pen_text_number(double value)
{
    struct pen_text out;
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(out.text, sizeof out.text, "%.*g", digits, value);
        if (strtod(out.text, NULL) == value)
            break;
    }
    return out;
}

struct pen_text pen_text_value(const json_t *value)
{
    struct pen_text out = {""};
    size_t count;
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        snprintf(out.text, sizeof out.text, "an object");
        break;
    case JSON_ARRAY:
        count = json_array_size(value);
        snprintf(out.text, sizeof out.text, count ? "an array of %zu" : "an empty array", count);
        break;
    case JSON_STRING: {
        struct pen_text quoted = pen_text_quote(json_string_value(value));
        append(out.text, sizeof out.text,
               append(out.text, sizeof out.text, 0, "the string ", false), quoted.text, false);
        break;
    }
    case JSON_INTEGER:
        snprintf(out.text, sizeof out.text, "%" JSON_INTEGER_FORMAT, json_integer_value(value));
        break;
    case JSON_REAL:
        return pen_text_number(json_real_value(value));
    case JSON_TRUE:
        return (struct pen_text){"true"};
    case JSON_FALSE:
        return (struct pen_text){"false"};
    case JSON_NULL:
        return (struct pen_text){"null"};
    }
    return out;
}

struct pen_text pen_text_nearest(const char *word, const char *const *names)
{
    struct pen_text out = {""};
    const char *near = pen_nearest_name(word, names);
    if (near) {
        struct pen_text quoted = pen_text_quote(near);
        size_t used = append(out.text, sizeof out.text, 0, "; did you mean ", false);
        used = append(out.text, sizeof out.text, used, quoted.text, false);
        append(out.text, sizeof out.text, used, "?", false);
    }
    return out;
}

struct pen_text pen_reader_found(const struct pen_reader *r, const struct pen_place *at,
                                 const json_t *value)
{
    return r->xml ? pen_xml_found(r->xml, at, value) : pen_text_value(value);
}

struct pen_text pen_reader_name(const struct pen_reader *r, const struct pen_place *up,
                                const char *key)
{
    return r->xml ? pen_xml_name(r->xml, up, key) : pen_text_quote(key);
}

void pen_reader_place(const struct pen_reader *r, const struct pen_place *at, char *out,
                      size_t bytes)
{
    if (r->xml)
        pen_xml_place_text(r->xml, at, out, bytes);
    else
        pen_place_text(at, r->prefix, out, bytes);
}

bool pen_reader_missing(struct pen_reader *r, const struct pen_place *up, const char *key,
                        const char *other)
{
    const char *noun = r->xml ? "attribute" : "key";
    struct pen_text one = pen_reader_name(r, up, key);
    if (!other)
        return pen_reader_fail(r, up, PEN_INVALID, "missing %s %s", noun, one.text);
    return pen_reader_fail(r, up, PEN_INVALID, "missing %s %s or %s", noun, one.text,
                           pen_reader_name(r, up, other).text);
}
