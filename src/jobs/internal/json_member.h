/* SPDX-License-Identifier: MIT */
/* Finding the text of a member in the text of an object: a part of a document can then be stored as
 * it was sent, without writing it again. */
#ifndef PEN_JOBS_INTERNAL_JSON_MEMBER_H
#define PEN_JOBS_INTERNAL_JSON_MEMBER_H

#include <stddef.h>

/* The text of member `key` of an object, which must be well-formed JSON; *length becomes its
 * length. NULL if the object has no such member, or if its key is written with escapes. Owns: the
 * result points into `text`. */
const char *pen_json_member(const char *text, size_t bytes, const char *key, size_t *length);

#endif
