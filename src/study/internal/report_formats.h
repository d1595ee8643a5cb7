/* SPDX-License-Identifier: MIT */
/* The formats of a report that have a file of their own. Each function appends to `out`;
 * out->failed tells that memory ran out. */
#ifndef PEN_STUDY_INTERNAL_REPORT_FORMATS_H
#define PEN_STUDY_INTERNAL_REPORT_FORMATS_H

#include <jansson.h>

#include "base/buf.h"

/* A report as indented JSON. */
void pen_report_write_json(const json_t *report, struct pen_buf *out);

/* A report as CSV (RFC 4180): a line for each row, with its number, its settings, and what is at
 * the paths of the columns, of which the last has a NULL title. */
struct pen_csv_column {
    const char *title, *path;
};
void pen_report_write_csv(const json_t *report, const struct pen_csv_column *columns,
                          struct pen_buf *out);

void pen_bench_report_write_markdown(const json_t *report, struct pen_buf *out);
void pen_bench_report_write_html(const json_t *report, struct pen_buf *out);

/* The bar chart of the rows' medians, as an SVG element. */
void pen_bench_chart_write(const json_t *report, struct pen_buf *out);

/* The chart of speed-up over threads, as a section with a heading; nothing if no rows differ in
 * threads. */
void pen_bench_scaling_write(const json_t *report, struct pen_buf *out);

#endif
