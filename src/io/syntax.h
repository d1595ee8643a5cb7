/* SPDX-License-Identifier: MIT */
/* Text that is not JSON, explained: jansson decides, this room finds the place and the words. */
#ifndef PEN_SRC_IO_SYNTAX_H
#define PEN_SRC_IO_SYNTAX_H

#include <jansson.h>
#include <stddef.h>

#include "pen/base/status.h"

/* The offset of the first bracket that opens a container deeper than `nesting`, or SIZE_MAX.
 * Cost: linear; nothing is allocated. The text need not be JSON. */
size_t pen_syntax_too_deep(const char *text, size_t bytes, int nesting);

/* Fills *st for the container that opens at `offset`, with a pointer to it. */
void pen_syntax_fail_deep(const char *text, size_t offset, int nesting, struct pen_status *st);

/* Fills *st for what jansson found wrong in the text: line and column (both from 1, columns in
 * characters) of where the offending piece begins, and what it is. */
void pen_syntax_fail(const char *text, size_t bytes, const json_error_t *error,
                     struct pen_status *st);

#endif
