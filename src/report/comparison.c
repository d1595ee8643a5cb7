/* SPDX-License-Identifier: MIT */
/* The contents of a comparison of two reports. */
#include <string.h>

#include "report/internal/kind.h"

/* "before: 2026-…, version 0.1.0, build …" */
static void write_identity(const json_t *comparison, const char *which, struct pen_buf *out)
{
    const json_t *identity = json_object_get(comparison, which);
    pen_buf_printf(out, "%s: %s, version %s, build %s\n", which,
                   pen_report_string(identity, "began_at"), pen_report_string(identity, "version"),
                   pen_report_string(identity, "build"));
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
        pen_buf_printf(out, "%s%s", i ? ", " : " ",
                       json_string_value(name) ? json_string_value(name) : "");
    }
    pen_buf_puts(out, ": compare the calibrated ratio, each time over that of a fixed computation "
                      "on its host\n");
}

/* "row 1: rays.shadow 100 before, 200 after" for each difference. */
static void write_differences(const json_t *row, size_t number, struct pen_buf *out)
{
    size_t i;
    json_t *d;
    json_array_foreach(json_object_get(row, "differences"), i, d)
    {
        pen_buf_printf(out, "row %zu: %s %.0f before, %.0f after\n", number,
                       pen_report_string(d, "counter"), pen_report_number(d, "before"),
                       pen_report_number(d, "after"));
    }
    const char *reason = pen_report_string(row, "reason");
    if (*reason)
        pen_buf_printf(out, "row %zu is undecided: %s\n", number, reason);
}

static void write_only(const json_t *comparison, const char *which, const char *words,
                       struct pen_buf *out)
{
    const size_t rows = json_array_size(json_object_get(comparison, which));
    if (rows > 0)
        pen_buf_printf(out, "%zu row%s in the report %s alone\n", rows, rows == 1 ? " is" : "s are",
                       words);
}

static void write_notes(const json_t *comparison, struct pen_buf *out)
{
    write_identity(comparison, "before", out);
    write_identity(comparison, "after", out);
    write_hosts(comparison, out);
    for (size_t i = 0; i < pen_report_row_count(comparison); i++)
        write_differences(pen_report_row(comparison, i), i, out);
    write_only(comparison, "missing", "before", out);
    write_only(comparison, "added", "after", out);
}

static void write_ratio(const json_t *row, struct pen_buf *out)
{
    pen_write_ratio(json_object_get(row, "ratio"), out);
}

static void write_work(const json_t *row, struct pen_buf *out)
{
    const bool same = json_array_size(json_object_get(row, "differences")) == 0;
    pen_buf_puts(out, same ? "same" : "DIFFERENT");
}

static void write_picture(const json_t *row, struct pen_buf *out)
{
    const char *picture = pen_report_string(row, "picture");
    pen_buf_puts(out, strcmp(picture, "different") == 0 ? "DIFFERENT" : picture);
}

static const struct pen_column columns[] = {
    {"before_ms", "before ms", "before_ms", .cell = PEN_CELL_NUMBER},
    {"after_ms", "after ms", "after_ms", .cell = PEN_CELL_NUMBER},
    {"ratio", "time ratio", "ratio.median", .write = write_ratio},
    {"calibrated_ratio", "calibrated", "calibrated_ratio", .cell = PEN_CELL_FOURTH},
    {NULL, "counters", NULL, .cell = PEN_CELL_TEXT, .write = write_work},
    {"picture", "picture", "picture", .cell = PEN_CELL_TEXT, .write = write_picture},
    {"rmse_before", "RMSE", "errors.rmse.0", .cell = PEN_CELL_SHORT, .to = "errors.rmse.1"},
    {"rmse_after", NULL, "errors.rmse.1", .cell = PEN_CELL_NUMBER},
    {"flip_before", "FLIP", "errors.flip.0", .cell = PEN_CELL_SHORT, .to = "errors.flip.1"},
    {"flip_after", NULL, "errors.flip.1", .cell = PEN_CELL_NUMBER},
    {"verdict", "verdict", "verdict", .cell = PEN_CELL_TEXT},
    {0}};

const struct pen_report_kind pen_kind_comparison = {.name = "comparison",
                                                    .title = "Comparison",
                                                    .columns = columns,
                                                    .caption = "Before and after",
                                                    .notes = write_notes};
