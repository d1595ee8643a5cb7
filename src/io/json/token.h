/* SPDX-License-Identifier: MIT */
/* The tokens of JSON text: where they end, and the values of numbers. Numbers in XML attributes are
 * written the same way. */
#ifndef PEN_IO_JSON_TOKEN_H
#define PEN_IO_JSON_TOKEN_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/buf.h"

struct pen_json_text {
    const char *text;
    size_t bytes;
};

/* Whether a character ends a word (a number or true, false, null): white space, a bracket, comma,
 * colon or quote. */
bool pen_json_is_delimiter(char c);

/* The end of the word at `offset`: the next delimiter, or the text's end. */
size_t pen_json_word_end(const struct pen_json_text *json, size_t offset);

/* The end of the string whose opening quote is at `offset`: after its closing quote, or the text's
 * end. */
size_t pen_json_string_end(const struct pen_json_text *json, size_t offset);

/* Whether the text from `offset` to `end` is a number by RFC 8259, section 6. *integer tells
 * whether it has neither fraction nor exponent. */
bool pen_json_is_number(const struct pen_json_text *json, size_t offset, size_t end, bool *integer);

/* Converts a text for which pen_json_is_number is true, in any locale. `scratch` is a buffer to
 * work in. Owns: the caller json_decref()s *out. Fails: returns false if the number overflows a
 * double; *out is NULL when out of memory. */
bool pen_json_number(const char *text, size_t bytes, bool integer, struct pen_buf *scratch,
                     json_t **out);

#endif
