/* SPDX-License-Identifier: MIT */
/* Adding errors about a submission, each with its place. */
#ifndef PEN_JOBS_INTERNAL_REQUEST_ERRORS_H
#define PEN_JOBS_INTERNAL_REQUEST_ERRORS_H

#include <jansson.h>

#include "base/status.h"
#include "io/scene_json.h"

/* Adds an error at up/key, or at `up` if key is NULL. The key is escaped by RFC 6901. */
void pen_request_fail(struct pen_errors *errors, enum pen_code code, const char *up,
                      const char *key, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

/* The text by which messages show a value that was found. */
struct pen_found {
    char text[256];
};
struct pen_found pen_found(const json_t *value);

#endif
