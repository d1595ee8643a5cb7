/* SPDX-License-Identifier: MIT */
/* Errors in text that is not JSON: what is wrong, what was found, and where. All fill *st with
 * PEN_SYNTAX, the line and the column (from 1, a column is a character) of `offset`, where the
 * offending token begins, and return false. */
#ifndef PEN_IO_JSON_SYNTAX_ERROR_H
#define PEN_IO_JSON_SYNTAX_ERROR_H

#include "base/status.h"
#include "io/json/token.h"

/* An error with a message of its own. */
bool pen_json_error(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                    const char *format, ...) __attribute__((format(printf, 4, 5)));

/* "EXPECTED, found TOKEN"; for a word that is not JSON (NaN, a comment, TRUE, …) or a byte that no
 * JSON may have, what is wrong with it. */
bool pen_json_error_expected(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                             const char *expected);

/* "TOKEN message". */
bool pen_json_error_token(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                          const char *message);

#endif
