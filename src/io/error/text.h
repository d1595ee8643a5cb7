/* SPDX-License-Identifier: MIT */
/* Parts of error messages: values, names and positions as text. Text from a document is quoted,
 * escaped and cut, so that no input can forge a message or make it too long. */
#ifndef PEN_IO_ERROR_TEXT_H
#define PEN_IO_ERROR_TEXT_H

#include <jansson.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

/* A part of a message. It holds its own buffer, so one call of printf can use several parts. */
enum { PEN_TEXT_BYTES = 192 };
struct pen_text {
    char text[PEN_TEXT_BYTES];
};

/* The string in double quotes, escaped as in JSON, cut with "…" after about 40 characters. */
struct pen_text pen_text_quote(const char *string);

/* A number in the fewest digits that read back as the same double. */
struct pen_text pen_text_number(double value);

/* A value in words: `the string "abc"`, "-3", "an array of 2", "null". */
struct pen_text pen_text_value(const json_t *value);

/* `; did you mean "radius"?`, or "" if no name is near. `names` ends with NULL. */
struct pen_text pen_text_nearest(const char *word, const char *const *names);

/* Writes `text` and a zero byte at out[used]; text beyond `bytes` is cut. If `escape` is set, the
 * text becomes part of a JSON Pointer (RFC 6901: ~ becomes ~0 and / becomes ~1). Returns the new
 * length. */
size_t pen_text_append(char *out, size_t bytes, size_t used, const char *text, bool escape);

/* Computes the line and column, from 1, of the byte at `offset`. A column is a character. A byte
 * order mark at the beginning of the text has no width. */
void pen_text_position(const char *text, size_t offset, int *line, int *column);

/* Fills *st with a message and the line and column of the byte at `offset` of `text`. Returns
 * false. */
bool pen_text_fail(struct pen_status *st, enum pen_code code, const char *text, size_t offset,
                   const char *format, va_list args) __attribute__((format(printf, 5, 0)));

#endif
