/* SPDX-License-Identifier: MIT */
/* Building of JSON values that detects every failure. Each function takes ownership of its JSON
 * arguments. It returns NULL if one of them is NULL or memory runs out. So calls can be nested, and
 * only the result needs a check. */
#ifndef PEN_IO_JSON_BUILD_H
#define PEN_IO_JSON_BUILD_H

#include <jansson.h>
#include <stddef.h>

/* Returns the list if it has `count` elements, that is, if all were appended. Otherwise frees it
 * and returns NULL. */
json_t *pen_json_all(json_t *list, size_t count);

/* Adds a member to the object and returns the object. */
json_t *pen_json_with(json_t *object, const char *key, json_t *value);

#endif
