/* SPDX-License-Identifier: MIT */
/* The built-in scenes: the files scenes/ *.json at build time.
 * Owns: all names and texts are constants of the program.
 * Threads: any. */
#ifndef PEN_IO_BUILTIN_H
#define PEN_IO_BUILTIN_H

#include <stddef.h>

/* The number of built-in scenes. */
size_t pen_builtin_count(void);

/* The name of scene i, such as "room", and its JSON text. A zero byte follows the text. */
const char *pen_builtin_name(size_t i);
const char *pen_builtin_text(size_t i, size_t *bytes);

/* A description of scene i in one line; its name if builtin.c has no line for it. */
const char *pen_builtin_summary(size_t i);

/* The text of the scene with this name, or NULL. */
const char *pen_builtin_find(const char *name, size_t *bytes);

/* The built-in name that pen_nearest_name (io/message.h) finds for `name`, or NULL. */
const char *pen_builtin_nearest(const char *name);

#endif
