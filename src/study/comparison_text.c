/* SPDX-License-Identifier: MIT */
/* A comparison as plain text: a table of rows, then all that a reader must know beside it. */
#include <string.h>

#include "study/comparison.h"
#include "study/internal/table.h"

static void write_row_ratio(const json_t *row, struct pen_buf *out)
{
    pen_bench_write_ratio(json_object_get(row, "ratio"), out);
}

static void write_calibrated(const json_t *row, struct pen_buf *out)
{
    const json_t *ratio = json_object_get(row, "calibrated_ratio");
    if (json_is_number(ratio))
        pen_buf_printf(out, "%.3f", json_number_value(ratio));
}

static void write_work(const json_t *row, struct pen_buf *out)
{
    const bool same = json_array_size(json_object_get(row, "differences")) == 0;
    pen_buf_puts(out, same ? "same" : "DIFFERENT");
}

static void write_picture(const json_t *row, struct pen_buf *out)
{
    const char *picture = pen_bench_report_string(row, "picture");
    pen_buf_puts(out, strcmp(picture, "different") == 0 ? "DIFFERENT" : picture);
}

static void write_verdict(const json_t *row, struct pen_buf *out)
{
    pen_buf_puts(out, pen_bench_report_string(row, "verdict"));
}

/* "0.0123 to 0.0045" of a metric of an accuracy study. */
static void write_errors(const json_t *row, const char *metric, struct pen_buf *out)
{
    const json_t *pair = json_object_get(json_object_get(row, "errors"), metric);
    if (json_array_size(pair) == 2)
        pen_buf_printf(out, "%.3g to %.3g", json_number_value(json_array_get(pair, 0)),
                       json_number_value(json_array_get(pair, 1)));
}

static void write_rmse(const json_t *row, struct pen_buf *out)
{
    write_errors(row, "rmse", out);
}

static void write_flip(const json_t *row, struct pen_buf *out)
{
    write_errors(row, "flip", out);
}

static const struct pen_bench_column accuracy_columns[] = {
    {"before ms", .number = "before_ms"},
    {"after ms", .number = "after_ms"},
    {"time ratio", .write = write_row_ratio},
    {"RMSE", .write = write_rmse},
    {"FLIP", .write = write_flip},
    {"counters", .write = write_work, .words = true},
    {"picture", .write = write_picture, .words = true},
    {"verdict", .write = write_verdict, .words = true},
    {0}};

static const struct pen_bench_column columns[] = {
    {"before ms", .number = "before_ms"},
    {"after ms", .number = "after_ms"},
    {"time ratio", .write = write_row_ratio},
    {"calibrated", .write = write_calibrated},
    {"counters", .write = write_work, .words = true},
    {"picture", .write = write_picture, .words = true},
    {"verdict", .write = write_verdict, .words = true},
    {0}};

/* "before 2026-…, version 0.1.0, build …" */
static void write_identity(const json_t *comparison, const char *which, struct pen_buf *out)
{
    static const char *const members[] = {"began_at", "version", "build"};
    static const char *const names[] = {"", ", version ", ", build "};
    const json_t *identity = json_object_get(comparison, which);
    pen_buf_printf(out, "%s: ", which);
    for (int i = 0; i < 3; i++) {
        pen_buf_puts(out, names[i]);
        pen_bench_write_plain(pen_bench_report_string(identity, members[i]), out);
    }
    pen_buf_puts(out, "\n");
}

/* "row 1: rays.shadow 100 before, 200 after" for each difference. */
static void write_differences(const json_t *row, size_t number, struct pen_buf *out)
{
    size_t i;
    json_t *d;
    json_array_foreach(json_object_get(row, "differences"), i, d)
    {
        pen_buf_printf(out, "row %zu: ", number);
        pen_bench_write_plain(pen_bench_report_string(d, "counter"), out);
        pen_buf_printf(out, " %.0f before, %.0f after\n", pen_bench_report_number(d, "before"),
                       pen_bench_report_number(d, "after"));
    }
    const char *reason = pen_bench_report_string(row, "reason");
    if (!*reason)
        return;
    pen_buf_printf(out, "row %zu is undecided: ", number);
    pen_bench_write_plain(reason, out);
    pen_buf_puts(out, "\n");
}

static void write_only(const json_t *comparison, const char *which, const char *words,
                       struct pen_buf *out)
{
    const size_t rows = json_array_size(json_object_get(comparison, which));
    if (rows > 0)
        pen_buf_printf(out, "%zu row%s in the report %s alone\n", rows, rows == 1 ? " is" : "s are",
                       words);
}

static void write_hosts(const json_t *comparison, struct pen_buf *out)
{
    const json_t *list = json_object_get(comparison, "host_differences");
    size_t i;
    json_t *name;
    if (json_array_size(list) == 0)
        return;
    pen_buf_puts(out, "different hosts, by");
    json_array_foreach(list, i, name)
    {
        pen_buf_puts(out, i ? ", " : " ");
        pen_bench_write_plain(json_string_value(name) ? json_string_value(name) : "", out);
    }
    pen_buf_puts(out, ": compare the calibrated ratio, each time over that of a fixed computation "
                      "on its host\n");
}

void pen_comparison_write_text(const json_t *comparison, struct pen_buf *out)
{
    size_t i;
    json_t *row;
    const json_t *first = pen_bench_report_row(comparison, 0);
    const bool accuracy = json_is_object(json_object_get(first, "errors"));
    pen_bench_write_text_table(comparison, accuracy ? accuracy_columns : columns, out);
    pen_buf_puts(out, "\n");
    write_identity(comparison, "before", out);
    write_identity(comparison, "after", out);
    write_hosts(comparison, out);
    json_array_foreach(json_object_get(comparison, "rows"), i, row)
    {
        write_differences(row, i, out);
    }
    write_only(comparison, "missing", "before", out);
    write_only(comparison, "added", "after", out);
}
