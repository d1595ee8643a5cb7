/* SPDX-License-Identifier: MIT */
/* Text in HTML and SVG. */
#ifndef PEN_STUDY_INTERNAL_HTML_H
#define PEN_STUDY_INTERNAL_HTML_H

#include "base/buf.h"

/* Appends text with the characters escaped that HTML and SVG would read as markup, between tags or
 * inside quotes. */
void pen_html_escape(const char *text, struct pen_buf *out);

/* The same for a text that has been written into a buffer, which it releases. If that has failed,
 * `out` has, too. */
void pen_html_escape_buf(struct pen_buf *text, struct pen_buf *out);

#endif
