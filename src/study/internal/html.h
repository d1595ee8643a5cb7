/* SPDX-License-Identifier: MIT */
#ifndef PEN_STUDY_INTERNAL_HTML_H
#define PEN_STUDY_INTERNAL_HTML_H

#include <jansson.h>

#include "base/buf.h"

/* Appends text that HTML and SVG read as that text, between tags or inside quotes. */
void pen_html_text(const char *text, struct pen_buf *out);

/* Appends the bar chart of a report's medians as an SVG element. */
void pen_html_chart(const json_t *report, struct pen_buf *out);

#endif
