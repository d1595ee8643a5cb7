/* SPDX-License-Identifier: MIT */
/* Values of a report that is made. Each function returns a new reference; NULL when out of memory.
 */
#ifndef PEN_STUDY_INTERNAL_REPORT_JSON_H
#define PEN_STUDY_INTERNAL_REPORT_JSON_H

#include <jansson.h>
#include <stdint.h>

#include "base/buf.h"

/* The first object with the members of the second. Takes the references to both. */
json_t *pen_joined_json(json_t *object, json_t *more);

/* A list of lines, each ended by a line feed. Releases the buffer. */
json_t *pen_lines_json(struct pen_buf *lines);

/* A hash in 16 hexadecimal digits; a time as RFC 3339 has it. */
json_t *pen_report_hash_json(uint64_t hash);
json_t *pen_report_time_json(int64_t wall_ms);

#endif
