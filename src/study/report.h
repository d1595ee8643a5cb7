/* SPDX-License-Identifier: MIT */
/* Writes a report, the JSON of bench.h, in the formats that people and programs read: JSON, CSV
 * with one line for each row, Markdown, a self-contained HTML page, and plain text.
 *
 * A report may come from a store or a network. All text in it is escaped as the format needs; a
 * member that is missing or of the wrong type reads as 0, "" or an empty list. */
#ifndef PEN_STUDY_REPORT_H
#define PEN_STUDY_REPORT_H

#include <jansson.h>

#include "base/buf.h"
#include "base/status.h"

/* The names of the formats: "json", "csv", "md", "html", NULL. */
extern const char *const pen_bench_report_formats[];

/* The media type of a format. */
const char *pen_bench_report_media_type(const char *format);

/* Appends a report in one of the formats. Fails: PEN_NO_MEMORY, PEN_INTERNAL (no such format). */
bool pen_bench_report_write(const json_t *report, const char *format, struct pen_buf *out,
                            struct pen_status *st);

/* Appends a report as plain text for a terminal, without control characters but line feeds;
 * out->failed tells that memory ran out. */
void pen_bench_report_write_text(const json_t *report, struct pen_buf *out);

#endif
