/* SPDX-License-Identifier: MIT */
/* Render settings as JSON: written as a whole, and read one at a time. pen_settings_read
 * (io/scene_json.h) reads a whole `render` object. */
#ifndef PEN_IO_SETTINGS_JSON_H
#define PEN_IO_SETTINGS_JSON_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"
#include "scene/settings.h"

/* All settings as a `render` object that pen_settings_read reads back to the same values.
 * Owns: the caller json_decref()s it.
 * Fails: NULL when out of memory. */
json_t *pen_settings_json(const struct pen_settings *settings);

/* Whether `key` is the name of a render setting. */
bool pen_settings_has(const char *key);

/* The name of a setting that pen_nearest_name (io/message.h) finds for `word`, or NULL. */
const char *pen_settings_nearest(const char *word);

/* Applies one member of a `render` object to *settings. `at` is the place of that object.
 * Fails: returns false with errors->count > 0; *settings is unchanged. */
bool pen_settings_read_member(const char *key, const json_t *value, const char *at,
                              struct pen_settings *settings, struct pen_errors *errors);

/* The value of a setting in the form of a command line: JSON if the text is JSON, otherwise the
 * text itself as a string. So `accelerator=none` needs no quotes.
 * Owns: the caller json_decref()s it.
 * Fails: PEN_USAGE for text that is not UTF-8, PEN_NO_MEMORY. */
json_t *pen_settings_parse_value(const char *text, size_t bytes, struct pen_status *st);

#endif
