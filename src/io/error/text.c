/* SPDX-License-Identifier: MIT */
#include "io/error/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"
#include "io/message.h"

size_t pen_text_append(char *out, size_t bytes, size_t used, const char *text, bool escape)
{
    for (; *text; text++) {
        const char *escaped = escape && *text == '~' ? "~0" : escape && *text == '/' ? "~1" : NULL;
        size_t length = escaped ? 2 : 1;
        if (used + length >= bytes)
            break;
        memcpy(out + used, escaped ? escaped : text, length);
        used += length;
    }
    out[used] = '\0';
    return used;
}

/* Copies the first character of a string to `out`, escaped as in JSON. Characters that a terminal
 * might show differently are escaped too. Returns its length in the string. */
static size_t quote_char(const char *string, char out[PEN_UTF8_SHOWN_BYTES])
{
    size_t length = pen_utf8_show_char(string, strnlen(string, 4), out);
    if (*string == '"' || *string == '\\')
        snprintf(out, PEN_UTF8_SHOWN_BYTES, "\\%c", *string);
    return length;
}

struct pen_text pen_text_quote(const char *string)
{
    enum { SHOWN = 40 };
    struct pen_text out = {"\""};
    size_t used = 1;
    for (int shown = 0; *string && shown < SHOWN; shown++) {
        char quoted[PEN_UTF8_SHOWN_BYTES];
        string += quote_char(string, quoted);
        used = pen_text_append(out.text, sizeof out.text - 8, used, quoted, false);
    }
    if (*string)
        used = pen_text_append(out.text, sizeof out.text, used, "\xE2\x80\xA6", false);
    pen_text_append(out.text, sizeof out.text, used, "\"", false);
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
        pen_text_append(out.text, sizeof out.text,
                        pen_text_append(out.text, sizeof out.text, 0, "the string ", false),
                        quoted.text, false);
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
        size_t used = pen_text_append(out.text, sizeof out.text, 0, "; did you mean ", false);
        used = pen_text_append(out.text, sizeof out.text, used, quoted.text, false);
        pen_text_append(out.text, sizeof out.text, used, "?", false);
    }
    return out;
}

void pen_text_position(const char *text, size_t offset, int *line, int *column)
{
    size_t i = offset >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    *line = *column = 1;
    for (; i < offset; i++) {
        unsigned char c = (unsigned char)text[i];
        if (c == '\n') {
            ++*line;
            *column = 1;
        } else if ((c & 0xC0) != 0x80) {
            ++*column;
        }
    }
}

bool pen_text_fail(struct pen_status *st, enum pen_code code, const char *text, size_t offset,
                   const char *format, va_list args)
{
    char message[2 * PEN_MSG_BYTES];
    int line, column;
    if (vsnprintf(message, sizeof message, format, args) < 0)
        message[0] = '\0';
    pen_text_position(text, offset, &line, &column);
    return pen_fail_line(st, code, line, column, "%s", message);
}
