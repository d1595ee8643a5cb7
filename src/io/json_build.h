/* SPDX-License-Identifier: MIT */
/* Building JSON values so that running out of memory never leaves a part out silently. Each
 * function takes ownership of its arguments and returns NULL if one of them is NULL or memory runs
 * out; so calls can be nested and the result checked once. */
#ifndef PEN_IO_JSON_BUILD_H
#define PEN_IO_JSON_BUILD_H

#include <jansson.h>
#include <stddef.h>

/* The list, if it has `count` elements; else frees it and returns NULL. */
json_t *pen_json_all(json_t *list, size_t count);

/* The object with one more member. */
json_t *pen_json_with(json_t *object, const char *key, json_t *value);

#endif
