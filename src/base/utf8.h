/* SPDX-License-Identifier: MIT */
/* UTF-8 as Unicode defines it: shortest form, no surrogates, at most U+10FFFF. */
#ifndef PEN_BASE_UTF8_H
#define PEN_BASE_UTF8_H

#include <stdbool.h>
#include <stddef.h>

/* The length in bytes (1 to 4) of the character that begins at text, 0 if the `bytes` bytes there
 * do not begin with a whole valid one. A zero byte is a character of length 1. */
size_t pen_utf8_char(const char *text, size_t bytes);

/* Copies text into out as valid UTF-8 that fits with its end: each byte that is part of no valid
 * character becomes '?', and what does not fit is cut between characters. out_bytes is at least 1.
 * Returns whether all of the text fitted. Text and out do not overlap. */
bool pen_utf8_copy(char *out, size_t out_bytes, const char *text);

#endif
