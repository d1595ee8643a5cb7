/* SPDX-License-Identifier: MIT */
/* Reports as CSV. */
#include <string.h>

#include "study/internal/report_formats.h"
#include "study/internal/report_values.h"

/* One cell, in quotes where RFC 4180 requires them. */
static void write_cell(const char *text, struct pen_buf *out)
{
    if (!strpbrk(text, ",\"\r\n")) {
        pen_buf_puts(out, text);
        return;
    }
    pen_buf_puts(out, "\"");
    for (; *text; text++)
        pen_buf_printf(out, *text == '"' ? "\"\"" : "%c", *text);
    pen_buf_puts(out, "\"");
}

static void write_value_cell(const json_t *value, struct pen_buf *out)
{
    struct pen_buf text = {0};
    if (value && !json_is_null(value))
        pen_bench_write_value(value, &text);
    write_cell(text.data ? (const char *)text.data : "", out);
    out->failed |= text.failed;
    pen_buf_release(&text);
}

/* `keys` are the settings of the first row; all rows have the same keys. */
static void write_csv_row(const json_t *row, size_t number, const json_t *keys,
                          const struct pen_csv_column *columns, struct pen_buf *out)
{
    const char *key;
    json_t *value;
    pen_buf_printf(out, "\n%zu", number);
    json_object_foreach((json_t *)(uintptr_t)keys, key, value)
    {
        pen_buf_puts(out, ",");
        write_value_cell(json_object_get(pen_bench_report_member(row, "settings"), key), out);
    }
    for (; columns->title; columns++) {
        pen_buf_puts(out, ",");
        write_value_cell(pen_bench_report_member(row, columns->path), out);
    }
}

void pen_report_write_csv(const json_t *report, const struct pen_csv_column *columns,
                          struct pen_buf *out)
{
    const char *key;
    json_t *value;
    const json_t *keys = pen_bench_report_member(pen_bench_report_row(report, 0), "settings");
    pen_buf_puts(out, "row");
    json_object_foreach((json_t *)(uintptr_t)keys, key, value)
    {
        pen_buf_puts(out, ",");
        write_cell(key, out);
    }
    for (int i = 0; columns[i].title; i++)
        pen_buf_printf(out, ",%s", columns[i].title);
    for (size_t row = 0; row < pen_bench_report_row_count(report); row++)
        write_csv_row(pen_bench_report_row(report, row), row, keys, columns, out);
    pen_buf_puts(out, "\n");
}
