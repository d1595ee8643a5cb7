/* SPDX-License-Identifier: MIT */
/* JSON values of a report. Each function returns a new reference.
 * Fails: NULL when out of memory. */
#ifndef PEN_STUDY_INTERNAL_REPORT_JSON_H
#define PEN_STUDY_INTERNAL_REPORT_JSON_H

#include <jansson.h>
#include <stdint.h>

#include "base/buf.h"

/* Adds the members of `more` to `object`.
 * Owns: takes the references to both. */
json_t *pen_joined_json(json_t *object, json_t *more);

/* A list of the lines of a text, each of which ends with a line feed. Releases the buffer. */
json_t *pen_lines_json(struct pen_buf *lines);

/* A hash as 16 hexadecimal digits, and a time in the form of RFC 3339. */
json_t *pen_report_hash_json(uint64_t hash);
json_t *pen_report_time_json(int64_t wall_ms);

#endif
