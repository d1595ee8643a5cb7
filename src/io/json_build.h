/* SPDX-License-Identifier: MIT */
/* Building JSON values such that running out of memory cannot leave out a part unnoticed. Each
 * function takes ownership of its JSON arguments and returns NULL if one of them is NULL or memory
 * runs out, so calls can be nested and only the result needs a check. */
#ifndef PEN_IO_JSON_BUILD_H
#define PEN_IO_JSON_BUILD_H

#include <jansson.h>
#include <stddef.h>

/* Returns the list if it has `count` elements, that is, if none failed to be appended; otherwise
 * frees it and returns NULL. */
json_t *pen_json_all(json_t *list, size_t count);

/* Adds a member to the object and returns the object. */
json_t *pen_json_with(json_t *object, const char *key, json_t *value);

#endif
