/* SPDX-License-Identifier: MIT */
/* Parts of error messages for other modules: the nearest valid name, a value in words, a complete
 * error on one line. */
#ifndef PEN_IO_MESSAGE_H
#define PEN_IO_MESSAGE_H

#include <jansson.h>
#include <stddef.h>

#include "base/status.h"

/* The entry of names[] (NULL-terminated) that `word` most likely means: the one that other programs
 * call by that word, else the nearest. Of equally near entries it is the first; NULL if none is
 * near. Near means an edit distance, with transpositions, of at most 2 and of less than half the
 * word's length. Upper and lower case compare equal, as do - and _. */
const char *pen_nearest_name(const char *word, const char *const *names);

/* Describes a value for "found …": `the string "x"`, `an array of 3`, `2.5`. Text that does not fit
 * is cut. */
void pen_value_describe(const json_t *value, char *out, size_t bytes);

/* Writes an error as one line for the command line: "FILE:LINE:COLUMN: message", "FILE: at POINTER:
 * message" or "FILE: message". `file` may be NULL or empty. Control characters are escaped
 * (base/utf8.h), so the line is safe on a terminal. A line that does not fit is cut. */
void pen_status_describe(const struct pen_status *st, const char *file, char *out, size_t bytes);

#endif
