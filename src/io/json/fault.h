/* SPDX-License-Identifier: MIT */
/* What is wrong with text that is not JSON, in words, and where: line and column count from 1, a
 * column is a character, and the place is where the offending piece begins. */
#ifndef PEN_IO_JSON_FAULT_H
#define PEN_IO_JSON_FAULT_H

#include <jansson.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/buf.h"
#include "base/status.h"

/* What jansson takes for values, as measured of 2.14 and glibc's malloc: a text of `{},{},…` takes
 * 80 times its size. An element's and a member's share holds the growth of tables by doubling. */
enum {
    PEN_JSON_OBJECT_BYTES = 224,
    PEN_JSON_MEMBER_BYTES = 112, /* and its key */
    PEN_JSON_ARRAY_BYTES = 128,
    PEN_JSON_ELEMENT_BYTES = 16,
    PEN_JSON_NUMBER_BYTES = 32,
    PEN_JSON_STRING_BYTES = 80 /* and its text */
};

struct pen_json_text {
    const char *text;
    size_t bytes;
};

/* A message about the text at `offset`. Returns false. */
bool pen_json_fault(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                    const char *format, ...) __attribute__((format(printf, 4, 5)));

/* The same about the piece that begins at `offset`, which the message shows at its end: "…, found
 * PIECE"; or, if the piece is a word that no JSON has, what is wrong with that. */
bool pen_json_fault_found(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                          const char *expected);

/* A message that begins with the piece: "PIECE message". */
bool pen_json_fault_piece(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                          const char *message);

/* Where the word at `offset` ends: before white space, a bracket, comma, colon or quote. */
size_t pen_json_word_end(const struct pen_json_text *json, size_t offset);

/* Where the string that opens at `offset` ends: after its quote, or at the text's end. */
size_t pen_json_string_end(const struct pen_json_text *json, size_t offset);

/* Whether the text at `offset` up to `end` is a number by RFC 8259, section 6; *integer: without
 * fraction and exponent. */
bool pen_json_is_number(const struct pen_json_text *json, size_t offset, size_t end, bool *integer);

/* The value of such a text, whatever the locale; NULL in *out when out of memory. Returns false if
 * it is too large for a number. */
bool pen_json_number(const char *text, size_t bytes, bool integer, struct pen_buf *scratch,
                     json_t **out);

/* A message about a text at `offset`, which is given its line and column. Returns false. */
bool pen_text_fail(struct pen_status *st, enum pen_code code, const char *text, size_t offset,
                   const char *format, va_list args) __attribute__((format(printf, 5, 0)));

/* Line and column of the byte at `offset`. A byte order mark at the beginning has no width. */
void pen_text_position(const char *text, size_t offset, int *line, int *column);

#endif
