/* SPDX-License-Identifier: MIT */
#include "io/json/token.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

bool pen_json_is_delimiter(char c)
{
    switch (c) {
    case '[':
    case ']':
    case '{':
    case '}':
    case ',':
    case ':':
    case '"':
    case ' ':
    case '\t':
    case '\n':
    case '\r':
        return true;
    default:
        return false;
    }
}

size_t pen_json_word_end(const struct pen_json_text *json, size_t offset)
{
    while (offset < json->bytes && !pen_json_is_delimiter(json->text[offset]))
        offset++;
    return offset;
}

size_t pen_json_string_end(const struct pen_json_text *json, size_t offset)
{
    size_t i = offset + 1;
    while (i < json->bytes && json->text[i] != '"')
        i += json->text[i] == '\\' ? 2 : 1;
    return i < json->bytes ? i + 1 : json->bytes;
}

static size_t skip_digits(const struct pen_json_text *json, size_t at, size_t end)
{
    while (at < end && json->text[at] >= '0' && json->text[at] <= '9')
        at++;
    return at;
}

bool pen_json_is_number(const struct pen_json_text *json, size_t offset, size_t end, bool *integer)
{
    const char *s = json->text;
    size_t digits = offset + (offset < end && s[offset] == '-');
    size_t at = skip_digits(json, digits, end);
    *integer = at == end;
    if (at == digits || (s[digits] == '0' && at - digits > 1))
        return false;
    if (at < end && s[at] == '.') {
        size_t fraction = at + 1;
        at = skip_digits(json, fraction, end);
        if (at == fraction)
            return false;
    }
    if (at < end && (s[at] == 'e' || s[at] == 'E')) {
        size_t exponent = at + 1;
        exponent += exponent < end && (s[exponent] == '-' || s[exponent] == '+');
        at = skip_digits(json, exponent, end);
        if (at == exponent)
            return false;
    }
    return at == end;
}

bool pen_json_number(const char *text, size_t bytes, bool integer, struct pen_buf *scratch,
                     json_t **out)
{
    *out = NULL;
    scratch->bytes = 0;
    if (!pen_buf_add(scratch, text, bytes))
        return true;
    errno = 0;
    long long whole = integer ? strtoll((char *)scratch->data, NULL, 10) : 0;
    if (integer && errno == 0) {
        *out = json_integer(whole);
        return true;
    }
    double value = strtod((char *)scratch->data, NULL); /* in the locale "C", see io/document.h */
    if (!isfinite(value))
        return false;
    *out = json_real(value);
    return true;
}
