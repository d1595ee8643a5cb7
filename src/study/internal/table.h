/* SPDX-License-Identifier: MIT */
/* The rows of a report as a table of text, which Markdown, HTML and plain text then lay out. */
#ifndef PEN_STUDY_INTERNAL_TABLE_H
#define PEN_STUDY_INTERNAL_TABLE_H

#include "study/internal/report_values.h"

struct pen_bench_table {
    size_t rows, columns; /* row 0 has the titles */
    struct pen_buf *cell; /* cell[row * columns + column], neither escaped nor aligned */
    bool *is_text;        /* by column: it holds text, so it is aligned left; numbers right */
};

/* Makes the table of a report: the row's number, its settings, and the given columns.
 * Returns false when out of memory. Owns: release it in any case. */
bool pen_bench_table_init(const json_t *report, const struct pen_bench_column *columns,
                          struct pen_bench_table *table);
void pen_bench_table_release(struct pen_bench_table *table);

/* Appends such a table as aligned plain text. */
void pen_bench_write_text_table(const json_t *report, const struct pen_bench_column *columns,
                                struct pen_buf *out);

/* Appends text with `?` for control characters, which would act on a terminal. */
void pen_bench_write_plain(const char *text, struct pen_buf *out);

/* The text of a cell. */
const char *pen_bench_table_cell(const struct pen_bench_table *table, size_t row, size_t column);

/* Append the table of a report in Markdown; text with the characters escaped that Markdown, or HTML
 * in it, would read as markup; a paragraph with the text that `write` appends. */
void pen_bench_write_markdown_table(const json_t *report, const struct pen_bench_column *columns,
                                    struct pen_buf *out);
void pen_bench_write_markdown(const char *text, struct pen_buf *out);
void pen_bench_write_markdown_paragraph(const json_t *report,
                                        void (*write)(const json_t *report, struct pen_buf *out),
                                        struct pen_buf *out);

#endif
