/* SPDX-License-Identifier: MIT */
/* Scenes in XML that were saved in UTF-16, which some editors call Unicode. A byte-order mark at
 * the start identifies it, and gives the byte order. */
#ifndef PEN_IO_XML_UTF16_H
#define PEN_IO_XML_UTF16_H

#include <stddef.h>

#include "base/status.h"

/* Converts a text for which pen_text_is_utf16 is true to UTF-8, without the mark.
 * Owns: the caller frees the result.
 * Fails: NULL; PEN_SYNTAX with line and column, PEN_NO_MEMORY. */
char *pen_utf16_to_utf8(const char *text, size_t bytes, size_t *out_bytes, struct pen_status *st);

#endif
