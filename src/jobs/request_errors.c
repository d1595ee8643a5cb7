/* SPDX-License-Identifier: MIT */
/* The place of an error is a JSON Pointer (RFC 6901) into the submission. */
#include "jobs/internal/request_errors.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { AT_BYTES = 2 * PEN_AT_BYTES };

/* Appends a key to a JSON Pointer, escaped: "a~b" becomes "/a~0b". */
static void append_token(char *at, size_t bytes, const char *key)
{
    size_t used = strlen(at);
    if (used + 1 < bytes)
        at[used++] = '/';
    for (; *key && used + 2 < bytes; key++) {
        if (*key == '~' || *key == '/') {
            at[used++] = '~';
            at[used++] = *key == '~' ? '0' : '1';
        } else {
            at[used++] = *key;
        }
    }
    at[used] = '\0';
}

void pen_request_fail(struct pen_errors *errors, enum pen_code code, const char *up,
                      const char *key, const char *format, ...)
{
    char at[AT_BYTES], text[2 * PEN_MSG_BYTES];
    struct pen_status st;
    va_list args;
    snprintf(at, sizeof at, "%s", up);
    if (key)
        append_token(at, sizeof at, key);
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    pen_fail_at(&st, code, at, "%s", text);
    pen_errors_add(errors, &st);
}

struct pen_found pen_found(const json_t *value)
{
    struct pen_found found;
    pen_value_describe(value, found.text, sizeof found.text);
    return found;
}
