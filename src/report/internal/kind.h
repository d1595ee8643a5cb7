/* SPDX-License-Identifier: MIT */
/* What a kind of report has to say, without form: titles, sentences and tables, which
 * table.c and page.c write in every format. */
#ifndef PEN_REPORT_INTERNAL_KIND_H
#define PEN_REPORT_INTERNAL_KIND_H

#include "report/values.h"

/* How people read a value. Programs read it as it is in the report. */
enum pen_cell {
    PEN_CELL_NUMBER, /* three digits: pen_write_number */
    PEN_CELL_COUNT,  /* all digits */
    PEN_CELL_SHORT,  /* "%.3g" */
    PEN_CELL_TENTH,  /* "%.1f" */
    PEN_CELL_FOURTH, /* "%.4f" */
    PEN_CELL_TEXT    /* aligned left */
};

typedef void pen_words_fn(const json_t *json, struct pen_buf *out);

/* A column of a table. */
struct pen_column {
    const char *name;  /* in CSV; NULL: CSV does not have it */
    const char *title; /* for people; NULL: CSV alone has it */
    const char *path;  /* of the value in a row; what is not there is empty */
    enum pen_cell cell;
    const char *to;      /* path of the other end of a range */
    pen_words_fn *write; /* what people read instead; given the row */
    bool aside;          /* people read it in the second table */
};

struct pen_report_kind {
    const char *name, *title;              /* title: of the page */
    const struct pen_column *columns;      /* the last one has neither name nor title */
    const char *caption, *aside;           /* of the tables; aside NULL: there is no second one */
    json_t *(*rows)(const json_t *report); /* the rows, a new list; NULL: the report's `rows` */
    /* Lines, each ended by a line feed: before the tables; NULL: none. And behind them. */
    pen_words_fn *answer, *notes;
};
extern const struct pen_report_kind pen_kind_benchmark, pen_kind_accuracy, pen_kind_effects,
    pen_kind_history, pen_kind_comparison;

/* Append to out; out->failed tells that memory ran out. */
enum pen_layout { PEN_LAYOUT_TEXT, PEN_LAYOUT_MARKDOWN, PEN_LAYOUT_HTML };
void pen_layout_text(enum pen_layout layout, const char *text, struct pen_buf *out);
void pen_layout_lines(enum pen_layout layout, pen_words_fn *words, const json_t *report,
                      struct pen_buf *out);
void pen_layout_tables(enum pen_layout layout, const struct pen_report_kind *kind,
                       const json_t *report, struct pen_buf *out);
void pen_csv_write(const struct pen_report_kind *kind, const json_t *report, struct pen_buf *out);

/* Appends the page. */
void pen_page_write(const struct pen_report_kind *kind, const json_t *report,
                    const struct pen_buf *figures, struct pen_buf *out);

#endif
