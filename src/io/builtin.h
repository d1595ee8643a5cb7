/* SPDX-License-Identifier: MIT */
/* The scenes that come with Penumbra, from scenes/ *.json at build time. All texts are constant. */
#ifndef PEN_IO_BUILTIN_H
#define PEN_IO_BUILTIN_H

#include <stddef.h>

/* The number of built-in scenes. */
size_t pen_builtin_count(void);

/* Name ("room") and JSON text of scene i; the text is followed by a zero byte. */
const char *pen_builtin_name(size_t i);
const char *pen_builtin_text(size_t i, size_t *bytes);

/* The text of the scene of that name, or NULL. */
const char *pen_builtin_find(const char *name, size_t *bytes);

/* The name most like `name`, as pen_nearest_name (io/scene_json.h) finds it, or NULL. */
const char *pen_builtin_nearest(const char *name);

#endif
