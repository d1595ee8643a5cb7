/* SPDX-License-Identifier: MIT */
/* The contents of each kind of report: titles, sentences and tables. table.c and page.c write them
 * in every format. */
#ifndef PEN_REPORT_INTERNAL_KIND_H
#define PEN_REPORT_INTERNAL_KIND_H

#include "report/values.h"

/* The form of a value in tables for readers. CSV has the value as it is in the report. */
enum pen_cell {
    PEN_CELL_NUMBER, /* three significant digits */
    PEN_CELL_COUNT,  /* all digits */
    PEN_CELL_SHORT,  /* "%.3g" */
    PEN_CELL_TENTH,  /* "%.1f" */
    PEN_CELL_FOURTH, /* "%.4f" */
    PEN_CELL_TEXT    /* aligned left */
};

typedef void pen_words_fn(const json_t *json, struct pen_buf *out);

/* A column of a table. */
struct pen_column {
    const char *name;  /* in CSV; NULL: not in CSV */
    const char *title; /* in tables for readers; NULL: only in CSV */
    const char *path;  /* of the value in a row; a missing value is an empty cell */
    enum pen_cell cell;
    const char *to;      /* path of the upper end of a range */
    pen_words_fn *write; /* writes the cell for readers from the row, instead of the value */
    bool aside;          /* the column is in the second table for readers */
};

/* A kind of report. */
struct pen_report_kind {
    const char *name, *title;         /* title: of the page */
    const struct pen_column *columns; /* the last column has neither name nor title */
    /* Captions of the two tables. aside NULL: there is no second table. */
    const char *caption, *aside;
    /* Returns a new list of rows. NULL: the report's `rows`. */
    json_t *(*rows)(const json_t *report);
    /* Write lines, each of which ends with a line feed: `answer` before the tables, `notes` after
     * them. NULL: none. */
    pen_words_fn *answer, *notes;
};
extern const struct pen_report_kind pen_kind_benchmark, pen_kind_accuracy, pen_kind_effects,
    pen_kind_history, pen_kind_comparison;

/* Write text, lines, tables and CSV.
 * Fails: out->failed is set when out of memory. */
enum pen_layout { PEN_LAYOUT_TEXT, PEN_LAYOUT_MARKDOWN, PEN_LAYOUT_HTML };
void pen_layout_text(enum pen_layout layout, const char *text, struct pen_buf *out);
void pen_layout_lines(enum pen_layout layout, pen_words_fn *words, const json_t *report,
                      struct pen_buf *out);
void pen_layout_tables(enum pen_layout layout, const struct pen_report_kind *kind,
                       const json_t *report, struct pen_buf *out);
void pen_csv_write(const struct pen_report_kind *kind, const json_t *report, struct pen_buf *out);

/* Appends the page.
 * Fails: out->failed is set when out of memory. */
void pen_page_write(const struct pen_report_kind *kind, const json_t *report,
                    const struct pen_buf *figures, struct pen_buf *out);

#endif
