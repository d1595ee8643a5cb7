/* SPDX-License-Identifier: MIT */
/* Writes a report of any kind: as JSON, as CSV with a line for each row, as Markdown, as plain text
 * for a terminal, or as a page that stands alone. All are made from the JSON, whose member `kind`
 * is "benchmark", "accuracy", "effects", "history" or "comparison".
 *
 * The page is the template api/page/report.html with the report's data and tables. The page and
 * pen_report_policy allow its script and its style by their hashes. No other script or style may
 * run.
 *
 * A report may come from a store or a network. All text in it is escaped as the format needs. A
 * member that is missing or of the wrong type reads as 0, "" or an empty list. */
#ifndef PEN_REPORT_REPORT_H
#define PEN_REPORT_REPORT_H

#include <jansson.h>

#include "base/buf.h"
#include "base/status.h"
#include "film/encode.h"

/* The names of the formats in which a job has its report: "json", "csv", "md", "html", NULL. */
extern const char *const pen_report_formats[];

/* The media type of a format. */
const char *pen_report_media_type(const char *format);

/* Appends a report in one of these formats or as "text". The text has no control characters except
 * line feeds. `figures` are pictures for the page, made by pen_report_figure; NULL: none.
 * Fails: PEN_NO_MEMORY, PEN_INTERNAL (no such format). */
bool pen_report_write(const json_t *report, const char *format, const struct pen_buf *figures,
                      struct pen_buf *out, struct pen_status *st);

/* Appends a picture for the page: a <figure> whose class is "reference", "picture", "map" (of
 * errors) or "cost". The page shows the picture and the map of a chosen row beside the reference.
 * `row` is the picture's row; -1: none. `caption` is escaped. Where a picture is wider than 640
 * pixels, pixels are averaged.
 * Fails: out->failed is set when out of memory. */
struct pen_report_figure {
    const char *class;
    int row;
    const struct pen_film *film;
    enum pen_transfer transfer;
    const char *caption;
};
void pen_report_figure(const struct pen_report_figure *figure, struct pen_buf *out);

/* The Content-Security-Policy of a page.
 * Threads: any. */
const char *pen_report_policy(void);

/* The hashes of a page's script and style, as sources of the policy: 'sha256-…'. A page that shows
 * a report in a frame (blob:) must allow them too.
 * Threads: any. */
enum { PEN_REPORT_SOURCE_BYTES = 64 };
void pen_report_sources(char script[PEN_REPORT_SOURCE_BYTES], char style[PEN_REPORT_SOURCE_BYTES]);

#endif
