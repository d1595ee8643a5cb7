/* SPDX-License-Identifier: MIT */
/* Errors in text that is not JSON: the error, the text found, and the place. All functions fill *st
 * with PEN_SYNTAX and the line and column of `offset`, where the offending token begins, and return
 * false. Line and column count from 1; a column is a character. */
#ifndef PEN_IO_JSON_SYNTAX_ERROR_H
#define PEN_IO_JSON_SYNTAX_ERROR_H

#include "base/status.h"
#include "io/json/token.h"

/* An error with its own message. */
bool pen_json_error(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                    const char *format, ...) __attribute__((format(printf, 4, 5)));

/* "EXPECTED, found TOKEN". For a word that is not JSON (NaN, a comment, TRUE, …), or a byte that
 * JSON does not allow, the message explains the error. */
bool pen_json_error_expected(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                             const char *expected);

/* "TOKEN message". */
bool pen_json_error_token(const struct pen_json_text *json, size_t offset, struct pen_status *st,
                          const char *message);

#endif
