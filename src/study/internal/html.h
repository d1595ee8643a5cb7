/* SPDX-License-Identifier: MIT */
/* Text in HTML and SVG. */
#ifndef PEN_STUDY_INTERNAL_HTML_H
#define PEN_STUDY_INTERNAL_HTML_H

#include "base/buf.h"

/* Appends text with the characters escaped that HTML and SVG would read as markup, between tags or
 * inside quotes. */
void pen_html_escape(const char *text, struct pen_buf *out);

#endif
