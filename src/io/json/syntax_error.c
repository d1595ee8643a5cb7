/* SPDX-License-Identifier: MIT */
#include "io/json/syntax_error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/utf8.h"
#include "io/error/text.h"
#include "io/json/number.h"

bool pen_json_error(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                    const char *format, ...)
{
    va_list args;
    va_start(args, format);
    bool ok = pen_text_fail(st, PEN_SYNTAX, json->text, offset, format, args);
    va_end(args);
    return ok;
}

/* The token at `offset` for a message: quoted, without control characters, cut if long. */
static struct pen_text show_token(const struct pen_json_text *json, size_t offset)
{
    enum { SHOWN = 48 };
    struct pen_text out = {"the end of the document"};
    char raw[SHOWN + 1];
    if (offset >= json->bytes)
        return out;
    char first = json->text[offset];
    size_t end = first == '"'                   ? pen_json_string_end(json, offset)
                 : pen_json_is_delimiter(first) ? offset + 1
                                                : pen_json_word_end(json, offset);
    size_t bytes = end - offset, length = bytes < SHOWN ? bytes : SHOWN;
    memcpy(raw, json->text + offset, length);
    raw[length] = '\0';
    if (first != '"')
        return pen_text_quote(raw);
    for (size_t i = 0; i < length; i++) /* a string keeps its own quotes and escapes */
        raw[i] = (unsigned char)raw[i] < 0x20 || raw[i] == 0x7F ? ' ' : raw[i];
    pen_utf8_copy(out.text, sizeof out.text, raw);
    if (length < bytes)
        strcat(out.text, "\xE2\x80\xA6\"");
    return out;
}

static bool same_word(const char *text, size_t bytes, const char *word)
{
    if (strlen(word) != bytes)
        return false;
    for (size_t i = 0; i < bytes; i++) {
        char c = text[i];
        if ((c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c) != word[i])
            return false;
    }
    return true;
}

static bool is_one_of(const char *text, size_t bytes, const char *const *words)
{
    while (*words && !same_word(text, bytes, *words))
        words++;
    return *words != NULL;
}

/* The error in the word at `offset`, if it is a word of another language; NULL if it is JSON. */
static const char *foreign_word(const struct pen_json_text *json, size_t offset)
{
    static const char *const not_finite[] = {"nan", "inf", "infinity", NULL};
    static const char *const literals[] = {"true", "false", "null", NULL};
    const char *word = json->text + offset;
    size_t end = pen_json_word_end(json, offset), bytes = end - offset;
    struct pen_json_decimal decimal;
    if (bytes == 0 || pen_json_scan_number(json->text, offset, end, &decimal) == end)
        return NULL;
    size_t sign = *word == '-' || *word == '+';
    if (is_one_of(word + sign, bytes - sign, not_finite))
        return "is not a number that JSON has: numbers are finite";
    if (is_one_of(word, bytes, literals))
        return *word >= 'a' ? NULL
                            : "is not JSON: true, false and null are written in small letters";
    if (*word == '/' || *word == '#')
        return "is not JSON, which has no comments";
    if (sign || *word == '.' || (*word >= '0' && *word <= '9'))
        return "is not a number as JSON writes them";
    if (bytes >= 3 && memcmp(word, "\xEF\xBB\xBF", 3) == 0)
        return "is a byte order mark: save the document without it";
    return "is not JSON: strings and keys are written in double quotes";
}

/* Reports a byte of the word at `offset` that JSON does not allow: invalid UTF-8, or zero. */
static bool bad_byte(const struct pen_json_text *json, size_t offset, struct pen_status *st)
{
    size_t end = pen_json_word_end(json, offset);
    for (size_t length; offset < end; offset += length) {
        length = pen_utf8_char(json->text + offset, json->bytes - offset);
        if (length == 0) {
            pen_json_error(json, offset, st, "byte 0x%02x is not UTF-8",
                           (unsigned char)json->text[offset]);
            return true;
        }
        if (json->text[offset] == '\0') {
            pen_json_error(json, offset, st, "a zero byte is not JSON");
            return true;
        }
    }
    return false;
}

bool pen_json_error_expected(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                             const char *expected)
{
    if (bad_byte(json, offset, st))
        return false;
    if (offset >= json->bytes)
        return pen_json_error(json, offset, st,
                              "the document ends before everything in it is closed");
    struct pen_text found = show_token(json, offset);
    const char *wrong = foreign_word(json, offset);
    if (wrong)
        return pen_json_error(json, offset, st, "%s %s", found.text, wrong);
    return pen_json_error(json, offset, st, "%s, found %s", expected, found.text);
}

bool pen_json_error_token(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                          const char *message)
{
    struct pen_text token = show_token(json, offset);
    return pen_json_error(json, offset, st, "%s %s", token.text, message);
}
