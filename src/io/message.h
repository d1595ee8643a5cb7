/* SPDX-License-Identifier: MIT */
/* Error texts that other rooms build too: the nearest valid name, a value in words, a whole error
 * as one line. */
#ifndef PEN_IO_MESSAGE_H
#define PEN_IO_MESSAGE_H

#include <jansson.h>
#include <stddef.h>

#include "base/status.h"

/* The member of names[] (NULL-terminated) nearest to `word`, the first of several, or NULL if none
 * is near: edit distance with transpositions <= 2 and less than half the word's length. Upper and
 * lower case count as equal, and so do - and _. */
const char *pen_nearest_name(const char *word, const char *const *names);

/* A value in words, for "found …": `the string "x"`, `an array of 3`, `2.5`. Cut to fit. */
void pen_value_describe(const json_t *value, char *out, size_t bytes);

/* One line for an error, for the command line: "FILE:LINE:COLUMN: message", "FILE: at POINTER:
 * message" or "FILE: message". `file` may be NULL or empty; a line that does not fit is cut. */
void pen_status_describe(const struct pen_status *st, const char *file, char *out, size_t bytes);

#endif
