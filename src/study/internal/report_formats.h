/* SPDX-License-Identifier: MIT */
/* The formats of a report that have a file of their own. Each function appends to `out`;
 * out->failed tells that memory ran out. */
#ifndef PEN_STUDY_INTERNAL_REPORT_FORMATS_H
#define PEN_STUDY_INTERNAL_REPORT_FORMATS_H

#include <jansson.h>

#include "base/buf.h"

void pen_bench_report_write_markdown(const json_t *report, struct pen_buf *out);
void pen_bench_report_write_html(const json_t *report, struct pen_buf *out);

/* The head of a page and its heading, "TITLE: OF"; `title` is without markup. */
void pen_bench_page_begin(const char *title, const char *of, struct pen_buf *out);

/* The bar chart of the rows' medians, as an SVG element. */
void pen_bench_chart_write(const json_t *report, struct pen_buf *out);

/* The chart of speed-up over threads, as a section with a heading; nothing if no rows differ in
 * threads. */
void pen_bench_scaling_write(const json_t *report, struct pen_buf *out);

#endif
