/* SPDX-License-Identifier: MIT */
/* Reports as tables of text: for a terminal, aligned, and as Markdown. */
#include <string.h>

#include "study/internal/grid.h"
#include "study/report.h"

/* Characters of a text in UTF-8. */
static size_t width_of(const char *text)
{
    size_t width = 0;
    for (; *text; text++)
        width += ((unsigned char)*text & 0xC0) != 0x80;
    return width;
}

static size_t column_width(const struct pen_grid *grid, size_t column)
{
    size_t width = 0;
    for (size_t row = 0; row < grid->rows; row++) {
        size_t here = width_of(pen_grid_text(grid, row, column));
        width = here > width ? here : width;
    }
    return width;
}

static void write_aligned(const struct pen_grid *grid, size_t row, size_t column,
                          struct pen_buf *out)
{
    const char *text = pen_grid_text(grid, row, column);
    int blank = (int)(column_width(grid, column) - width_of(text));
    if (!grid->words[column])
        pen_buf_printf(out, "%*s%s", blank, "", text);
    else if (column + 1 < grid->columns)
        pen_buf_printf(out, "%s%*s", text, blank, "");
    else
        pen_buf_puts(out, text);
}

static void write_text_table(const json_t *report, const struct pen_column *columns,
                             struct pen_buf *out)
{
    struct pen_grid grid;
    bool ok = pen_grid_make(report, columns, &grid);
    for (size_t row = 0; ok && row < grid.rows; row++) {
        for (size_t column = 0; column < grid.columns; column++) {
            pen_buf_puts(out, column ? "  " : "");
            write_aligned(&grid, row, column, out);
        }
        pen_buf_puts(out, "\n");
    }
    pen_grid_release(&grid);
    out->failed |= !ok;
}

/* Text that cannot play with a terminal. */
static void write_plain(const char *text, struct pen_buf *out)
{
    for (; *text; text++) {
        bool control = (unsigned char)*text < 0x20 || *text == 0x7F;
        pen_buf_add(out, control ? "?" : text, 1);
    }
}

void pen_study_plain(const json_t *report, struct pen_buf *out)
{
    size_t i;
    json_t *note;
    write_text_table(report, pen_time_columns, out);
    pen_buf_puts(out, "\n");
    pen_write_method(report, out);
    pen_buf_puts(out, "\n");
    struct pen_buf host = {0};
    pen_write_host(report, &host);
    write_plain(host.data ? (const char *)host.data : "", out);
    out->failed |= host.failed;
    pen_buf_release(&host);
    pen_buf_puts(out, "\n");
    json_array_foreach(json_object_get(report, "notes"), i, note)
    {
        pen_buf_puts(out, "note: ");
        write_plain(json_string_value(note) ? json_string_value(note) : "", out);
        pen_buf_puts(out, "\n");
    }
}

/* Text as it is: what Markdown or the HTML in it would read as something else is escaped. */
static void write_escaped(const char *text, struct pen_buf *out)
{
    for (; *text; text++) {
        if (*text == '<')
            pen_buf_puts(out, "&lt;");
        else if (*text == '&')
            pen_buf_puts(out, "&amp;");
        else if ((unsigned char)*text < 0x20)
            pen_buf_puts(out, " ");
        else
            pen_buf_printf(out, strchr("\\`*_[]|#!~>", *text) ? "\\%c" : "%c", *text);
    }
}

static void write_markdown_row(const struct pen_grid *grid, size_t row, struct pen_buf *out)
{
    for (size_t column = 0; column < grid->columns; column++) {
        pen_buf_puts(out, "| ");
        write_escaped(pen_grid_text(grid, row, column), out);
        pen_buf_puts(out, " ");
    }
    pen_buf_puts(out, "|\n");
}

static void write_markdown_table(const json_t *report, const struct pen_column *columns,
                                 struct pen_buf *out)
{
    struct pen_grid grid;
    bool ok = pen_grid_make(report, columns, &grid);
    for (size_t row = 0; ok && row < grid.rows; row++) {
        write_markdown_row(&grid, row, out);
        for (size_t column = 0; row == 0 && column < grid.columns; column++)
            pen_buf_puts(out, grid.words[column] ? "|:---" : "|---:");
        if (row == 0)
            pen_buf_puts(out, "|\n");
    }
    pen_grid_release(&grid);
    out->failed |= !ok;
}

/* A paragraph of what `write` says. */
static void write_paragraph(const json_t *report,
                            void (*write)(const json_t *report, struct pen_buf *out),
                            struct pen_buf *out)
{
    struct pen_buf text = {0};
    write(report, &text);
    pen_buf_puts(out, "\n");
    write_escaped(text.data ? (const char *)text.data : "", out);
    pen_buf_puts(out, "\n");
    out->failed |= text.failed;
    pen_buf_release(&text);
}

void pen_study_markdown(const json_t *report, struct pen_buf *out)
{
    size_t i;
    json_t *note;
    pen_buf_puts(out, "# Benchmark: ");
    write_escaped(pen_study_text(report, "scene"), out);
    pen_buf_puts(out, "\n");
    write_paragraph(report, pen_write_method, out);
    pen_buf_puts(out, "\n");
    write_markdown_table(report, pen_time_columns, out);
    pen_buf_puts(out, "\n");
    write_markdown_table(report, pen_ray_columns, out);
    write_paragraph(report, pen_write_host, out);
    json_array_foreach(json_object_get(report, "notes"), i, note)
    {
        pen_buf_puts(out, i ? "- " : "\n- ");
        write_escaped(json_string_value(note) ? json_string_value(note) : "", out);
        pen_buf_puts(out, "\n");
    }
}
