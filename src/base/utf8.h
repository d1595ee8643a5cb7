/* SPDX-License-Identifier: MIT */
/* UTF-8 as Unicode defines it: shortest form, no surrogates, at most U+10FFFF. */
#ifndef PEN_BASE_UTF8_H
#define PEN_BASE_UTF8_H

#include <stdbool.h>
#include <stddef.h>

/* The length in bytes (1 to 4) of the character at the start of `bytes` bytes of text; 0 if there
 * is no complete and valid character. A zero byte is a character of length 1. */
size_t pen_utf8_char(const char *text, size_t bytes);

/* Returns true if `bytes` of text are valid characters. */
bool pen_utf8_is_valid(const char *text, size_t bytes);

/* Writes the character with this code point, at most 0x10FFFF, to out. Returns its length. */
size_t pen_utf8_encode(unsigned code, char out[4]);

/* The number of characters of text, as JSON Schema counts them: code points. Each byte that is not
 * part of a valid character counts as one. */
size_t pen_utf8_count(const char *text);

/* The number of columns that the character at the start of `bytes` (at least 1) of text takes on a
 * terminal. It is 2 for East Asian scripts and emoji, 0 for marks that are set over the preceding
 * character, else 1. *length is its length in bytes. A byte that is not part of a valid character
 * takes one column.
 * Source: Unicode Standard Annex #11, East Asian Width. */
int pen_utf8_char_columns(const char *text, size_t bytes, size_t *length);

/* The same for all characters of `bytes` of text. */
size_t pen_utf8_columns(const char *text, size_t bytes);

/* Copies text into out as valid UTF-8 with a terminating zero. Each byte that is not part of a
 * valid character becomes '?'. Text that does not fit is cut between characters. out_bytes is at
 * least 1, and text and out do not overlap. Returns whether all of the text fitted. */
bool pen_utf8_copy(char *out, size_t out_bytes, const char *text);

/* Copies the character at the start of `bytes` (at least 1) of text to out, with a terminating
 * zero, in a form that is safe on a terminal. Control characters, and characters that change the
 * direction or the visibility of other text, are written as in JSON: U+202E as the six characters
 * \u202e, U+E0001 as two such escapes, a line feed as \n. A byte that is not part of a valid
 * character becomes '?'. Returns the number of bytes of text that it has read. */
enum { PEN_UTF8_SHOWN_BYTES = 16 };
size_t pen_utf8_show_char(const char *text, size_t bytes, char out[PEN_UTF8_SHOWN_BYTES]);

/* Copies all characters of text in this form. Text that does not fit is cut between characters.
 * out_bytes is at least 1, and text and out do not overlap. Returns whether all of the text fitted.
 */
bool pen_utf8_show(char *out, size_t out_bytes, const char *text);

#endif
