/* SPDX-License-Identifier: MIT */
/* Render settings as JSON: the counterpart of pen_settings_read (io/scene_json.h). */
#ifndef PEN_IO_SETTINGS_JSON_H
#define PEN_IO_SETTINGS_JSON_H

#include <jansson.h>

#include "scene/settings.h"

/* All settings as a `render` object that pen_settings_read reads back to the same values.
 * Owns: the caller json_decref()s. Fails: NULL when out of memory. */
json_t *pen_settings_json(const struct pen_settings *settings);

#endif
