/* SPDX-License-Identifier: MIT */
/* A report in the forms that people and programs read: the JSON of bench.h as it is, as CSV (one
 * line a row), as Markdown, as a page of HTML that needs nothing else, and as a table of text.
 *
 * A report may come out of a store or a network: whatever text it holds is escaped, and whatever
 * is missing or of the wrong type in it reads as nothing. */
#ifndef PEN_STUDY_REPORT_H
#define PEN_STUDY_REPORT_H

#include <jansson.h>

#include "base/buf.h"
#include "base/status.h"

/* "json", "csv", "md", "html", NULL. */
extern const char *const pen_study_forms[];

/* The media type of a form. */
const char *pen_study_media_type(const char *form);

/* Appends a report in one of the forms. Fails: PEN_NO_MEMORY, PEN_INTERNAL (no such form). */
bool pen_study_write(const json_t *report, const char *form, struct pen_buf *out,
                     struct pen_status *st);

/* The forms one by one; out->failed tells of want of memory. */
void pen_study_csv(const json_t *report, struct pen_buf *out);
void pen_study_markdown(const json_t *report, struct pen_buf *out);
void pen_study_html(const json_t *report, struct pen_buf *out);
void pen_study_plain(const json_t *report, struct pen_buf *out); /* for a terminal */

#endif
