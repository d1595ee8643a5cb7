/* SPDX-License-Identifier: MIT */
/* Reports as plain text with aligned tables, for a terminal, and as Markdown. A table that is wider
 * than a terminal of 80 columns goes on below itself: each part begins with the first column. */
#include <string.h>

#include "base/utf8.h"
#include "study/internal/report_formats.h"
#include "study/internal/table.h"
#include "study/report.h"

enum { TERMINAL_COLUMNS = 80, GAP = 2 };

void pen_bench_write_plain(const char *text, struct pen_buf *out)
{
    for (; *text; text++) {
        bool control = (unsigned char)*text < 0x20 || *text == 0x7F;
        pen_buf_add(out, control ? "?" : text, 1);
    }
}

static size_t width_of(const char *text)
{
    return pen_utf8_columns(text, strlen(text));
}

static size_t column_width(const struct pen_bench_table *table, size_t column)
{
    size_t width = 0;
    for (size_t row = 0; row < table->rows; row++) {
        size_t here = width_of(pen_bench_table_cell(table, row, column));
        width = here > width ? here : width;
    }
    return width;
}

static void write_aligned(const struct pen_bench_table *table, size_t row, size_t column, bool last,
                          struct pen_buf *out)
{
    const char *text = pen_bench_table_cell(table, row, column);
    const int blank = (int)(column_width(table, column) - width_of(text));
    const bool words = table->is_text[column];
    pen_buf_printf(out, "%*s", words ? 0 : blank, "");
    pen_bench_write_plain(text, out);
    pen_buf_printf(out, "%*s", words && !last ? blank : 0, "");
}

/* The column behind the last one that fits beside the first, from `begin` on: at least one does. */
static size_t part_end(const struct pen_bench_table *table, size_t begin)
{
    size_t width = column_width(table, 0), end = begin;
    while (end < table->columns) {
        width += GAP + column_width(table, end);
        if (width > TERMINAL_COLUMNS && end > begin)
            break;
        end++;
    }
    return end;
}

static void write_part(const struct pen_bench_table *table, size_t begin, size_t end,
                       struct pen_buf *out)
{
    for (size_t row = 0; row < table->rows; row++) {
        write_aligned(table, row, 0, begin == end, out);
        for (size_t column = begin; column < end; column++) {
            pen_buf_printf(out, "%*s", GAP, "");
            write_aligned(table, row, column, column + 1 == end, out);
        }
        pen_buf_puts(out, "\n");
    }
}

void pen_bench_write_text_table(const json_t *report, const struct pen_bench_column *columns,
                                struct pen_buf *out)
{
    struct pen_bench_table table;
    bool ok = pen_bench_table_init(report, columns, &table);
    for (size_t begin = 1, end; ok && begin < table.columns; begin = end) {
        end = part_end(&table, begin);
        pen_buf_puts(out, begin > 1 ? "\n" : "");
        write_part(&table, begin, end, out);
    }
    pen_bench_table_release(&table);
    out->failed |= !ok;
}

void pen_bench_report_write_text(const json_t *report, struct pen_buf *out)
{
    size_t i;
    json_t *note;
    pen_bench_write_text_table(report, pen_bench_time_columns, out);
    pen_buf_puts(out, "\n");
    pen_bench_write_method(report, out);
    pen_buf_puts(out, "\n");
    pen_bench_write_noise(report, out);
    pen_buf_puts(out, "\n");
    struct pen_buf host = {0};
    pen_bench_write_host(report, &host);
    pen_bench_write_plain(host.data ? (const char *)host.data : "", out);
    out->failed |= host.failed;
    pen_buf_release(&host);
    pen_buf_puts(out, "\n");
    json_array_foreach(json_object_get(report, "notes"), i, note)
    {
        pen_buf_puts(out, "note: ");
        pen_bench_write_plain(json_string_value(note) ? json_string_value(note) : "", out);
        pen_buf_puts(out, "\n");
    }
}

void pen_bench_write_markdown(const char *text, struct pen_buf *out)
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

static void write_markdown_row(const struct pen_bench_table *table, size_t row, struct pen_buf *out)
{
    for (size_t column = 0; column < table->columns; column++) {
        pen_buf_puts(out, "| ");
        pen_bench_write_markdown(pen_bench_table_cell(table, row, column), out);
        pen_buf_puts(out, " ");
    }
    pen_buf_puts(out, "|\n");
}

void pen_bench_write_markdown_table(const json_t *report, const struct pen_bench_column *columns,
                                    struct pen_buf *out)
{
    struct pen_bench_table table;
    bool ok = pen_bench_table_init(report, columns, &table);
    for (size_t row = 0; ok && row < table.rows; row++) {
        write_markdown_row(&table, row, out);
        for (size_t column = 0; row == 0 && column < table.columns; column++)
            pen_buf_puts(out, table.is_text[column] ? "|:---" : "|---:");
        if (row == 0)
            pen_buf_puts(out, "|\n");
    }
    pen_bench_table_release(&table);
    out->failed |= !ok;
}

void pen_bench_write_markdown_paragraph(const json_t *report,
                                        void (*write)(const json_t *report, struct pen_buf *out),
                                        struct pen_buf *out)
{
    struct pen_buf text = {0};
    write(report, &text);
    pen_buf_puts(out, "\n");
    pen_bench_write_markdown(text.data ? (const char *)text.data : "", out);
    pen_buf_puts(out, "\n");
    out->failed |= text.failed;
    pen_buf_release(&text);
}

void pen_bench_report_write_markdown(const json_t *report, struct pen_buf *out)
{
    size_t i;
    json_t *note;
    pen_buf_puts(out, "# Benchmark: ");
    pen_bench_write_markdown(pen_bench_report_string(report, "scene"), out);
    pen_buf_puts(out, "\n");
    pen_bench_write_markdown_paragraph(report, pen_bench_write_method, out);
    pen_bench_write_markdown_paragraph(report, pen_bench_write_noise, out);
    pen_buf_puts(out, "\n");
    pen_bench_write_markdown_table(report, pen_bench_time_columns, out);
    pen_buf_puts(out, "\n");
    pen_bench_write_markdown_table(report, pen_bench_ray_columns, out);
    pen_bench_write_markdown_paragraph(report, pen_bench_write_host, out);
    json_array_foreach(json_object_get(report, "notes"), i, note)
    {
        pen_buf_puts(out, i ? "- " : "\n- ");
        pen_bench_write_markdown(json_string_value(note) ? json_string_value(note) : "", out);
        pen_buf_puts(out, "\n");
    }
}
