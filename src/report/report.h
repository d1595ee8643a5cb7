/* SPDX-License-Identifier: MIT */
/* Writes a report of any kind: JSON as it is; CSV with one line for each row; Markdown; plain text
 * for a terminal; and a page that stands alone. All of them are made from the JSON, whose member
 * `kind` says what it is: "benchmark", "accuracy", "effects", "history" or "comparison".
 *
 * The page is the template api/page/report.html with the report's data and tables. Its script and
 * its style are known by their hashes, in the page and in pen_report_policy; no other may run.
 *
 * A report may come from a store or a network. All text in it is escaped as the format needs; a
 * member that is missing or of the wrong type reads as 0, "" or an empty list. */
#ifndef PEN_REPORT_REPORT_H
#define PEN_REPORT_REPORT_H

#include <jansson.h>

#include "base/buf.h"
#include "base/status.h"
#include "film/encode.h"

/* The names of the formats that a job has: "json", "csv", "md", "html", NULL. */
extern const char *const pen_report_formats[];

/* The media type of a format. */
const char *pen_report_media_type(const char *format);

/* Appends a report in one of the formats, or as "text", without control characters but line feeds.
 * `figures`: pictures for the page, by pen_report_figure; NULL: none. Fails: PEN_NO_MEMORY,
 * PEN_INTERNAL (no such format). */
bool pen_report_write(const json_t *report, const char *format, const struct pen_buf *figures,
                      struct pen_buf *out, struct pen_status *st);

/* Appends a picture for the page, as a <figure> of this class: "reference", "picture", "map" (of
 * errors) or "cost". A page shows the picture and the map of the row that a reader chooses beside
 * the reference. `row`: which one; -1: none. `caption` is escaped. Where the picture is wider than
 * 640 pixels, pixels are averaged. out->failed tells that memory ran out. */
struct pen_report_figure {
    const char *class;
    int row;
    const struct pen_film *film;
    enum pen_transfer transfer;
    const char *caption;
};
void pen_report_figure(const struct pen_report_figure *figure, struct pen_buf *out);

/* The value of Content-Security-Policy for a page. Threads: any. */
const char *pen_report_policy(void);

/* The hashes of a page's script and style as sources of that policy, 'sha256-…'. A page that shows
 * a report in a frame of its own (blob:) must allow them, too. Threads: any. */
enum { PEN_REPORT_SOURCE_BYTES = 64 };
void pen_report_sources(char script[PEN_REPORT_SOURCE_BYTES], char style[PEN_REPORT_SOURCE_BYTES]);

#endif
