/* SPDX-License-Identifier: MIT */
/* The tokens of JSON text: their ends. */
#ifndef PEN_IO_JSON_TOKEN_H
#define PEN_IO_JSON_TOKEN_H

#include <stdbool.h>
#include <stddef.h>

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

#endif
