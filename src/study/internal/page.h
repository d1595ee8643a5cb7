/* SPDX-License-Identifier: MIT */
/* The parts of reports that are pages of HTML: without scripts and references to other files, in
 * the light or dark colours that the reader's browser prefers. Each function appends to `out`;
 * out->failed tells that memory ran out. */
#ifndef PEN_STUDY_INTERNAL_PAGE_H
#define PEN_STUDY_INTERNAL_PAGE_H

#include <jansson.h>

#include "base/buf.h"
#include "film/encode.h"
#include "study/internal/report_values.h"

/* Appends words about a report, without markup. */
typedef void pen_page_words(const json_t *report, struct pen_buf *out);

/* The head of a page and its heading, "TITLE: OF"; `title` is without markup. */
void pen_page_begin(const char *title, const char *of, struct pen_buf *out);
static inline void pen_page_end(struct pen_buf *out)
{
    pen_buf_puts(out, "</body>\n</html>\n");
}

void pen_page_paragraph(const json_t *report, const char *class, pen_page_words *words,
                        struct pen_buf *out);

/* The rows of a report as a table. */
void pen_page_table(const json_t *report, const struct pen_bench_column *columns,
                    const char *caption, struct pen_buf *out);

/* A list of sentences under a heading; nothing if there are none. */
void pen_page_list(const json_t *sentences, const char *heading, struct pen_buf *out);

/* The members of a `render` object under a heading. */
void pen_page_settings(const json_t *render, const char *heading, struct pen_buf *out);

/* A picture as an <img> that holds its PNG. Where it is wider than `width`, pixels are averaged, so
 * that it is at most as wide. `alt` is escaped. */
void pen_page_picture(const struct pen_film *film, enum pen_transfer transfer, int width,
                      const char *alt, struct pen_buf *out);

#endif
