/* SPDX-License-Identifier: MIT */
/* Messages about text that is not JSON: what is wrong, what was found, and where. Line and column
 * count from 1, a column is a character, and the position is where the offending token begins. */
#ifndef PEN_IO_JSON_SYNTAX_ERROR_H
#define PEN_IO_JSON_SYNTAX_ERROR_H

#include "base/status.h"
#include "io/json/token.h"

/* A message about the text at `offset`. Returns false. */
bool pen_json_error(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                    const char *format, ...) __attribute__((format(printf, 4, 5)));

/* "EXPECTED, found TOKEN"; or, if the token is a word that JSON does not have (NaN, a comment,
 * TRUE, …), what is wrong with it. Returns false. */
bool pen_json_error_expected(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                             const char *expected);

/* "TOKEN message". Returns false. */
bool pen_json_error_token(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                          const char *message);

#endif
