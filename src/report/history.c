/* SPDX-License-Identifier: MIT */
/* The contents of a history. Its table has a row for each point of each series. */
#include "io/json_build.h"
#include "report/internal/kind.h"

/* The report of a point. */
static json_t *report_of(const json_t *history, const json_t *point)
{
    const int number = pen_report_whole(point, "report");
    return json_array_get(json_object_get(history, "reports"), number >= 0 ? (size_t)number : 0);
}

/* "2026-11-24 build 1234567" */
static void write_report_name(const json_t *report, struct pen_buf *out)
{
    pen_buf_printf(out, "%.10s build %.7s", pen_report_string(report, "began_at"),
                   pen_report_string(report, "build"));
}

/* "threads 2: change at 2026-11-24 build 1234567: 105 ms, before 100 ms, +5.0 %" for each change */
static void write_changes(const json_t *history, const json_t *row, struct pen_buf *out)
{
    const json_t *changes = json_object_get(row, "changes");
    size_t i;
    json_t *change;
    json_array_foreach(changes, i, change)
    {
        const int point = pen_report_whole(change, "point");
        pen_write_row_name(row, out);
        pen_buf_puts(out, ": change at ");
        write_report_name(
            report_of(history, json_array_get(json_object_get(row, "points"), (size_t)point)), out);
        pen_buf_puts(out, ": ");
        pen_write_number(pen_report_number(change, "after_ms"), out);
        pen_buf_puts(out, " ms, before ");
        pen_write_number(pen_report_number(change, "before_ms"), out);
        pen_buf_printf(out, " ms, %+.1f %%\n", (pen_report_number(change, "ratio") - 1) * 100);
    }
    if (json_array_size(changes) == 0) {
        pen_write_row_name(row, out);
        pen_buf_puts(out, ": no change found\n");
    }
}

static void write_answer(const json_t *history, struct pen_buf *out)
{
    for (size_t i = 0; i < pen_report_row_count(history); i++)
        write_changes(history, pen_report_row(history, i), out);
}

static void write_notes(const json_t *history, struct pen_buf *out)
{
    size_t i;
    json_t *host;
    pen_buf_puts(out, "A point is a report's median with its 95 % interval, from 10 runs on. A "
                      "change is among the reports of one host; chance alone shows one in at most "
                      "one of twenty histories.\n");
    json_array_foreach(json_object_get(history, "hosts"), i, host)
    {
        pen_buf_printf(out, "host %zu: %s, %s\n", i, pen_report_string(host, "cpu"),
                       pen_report_string(host, "kernel"));
    }
}

/* Adds the points of a series, each with the series' settings and its report. */
static void add_points(const json_t *history, const json_t *row, json_t *rows)
{
    size_t i;
    json_t *point;
    json_array_foreach(json_object_get(row, "points"), i, point)
    {
        json_t *settings = json_object_get(row, "settings"), *report = report_of(history, point),
               *flat = json_copy(point);
        flat = pen_json_with(flat, "settings", settings ? json_incref(settings) : json_object());
        flat = pen_json_with(flat, "of", report ? json_incref(report) : json_object());
        json_array_append_new(rows, flat);
    }
}

static json_t *make_rows(const json_t *history)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < pen_report_row_count(history); i++)
        add_points(history, pen_report_row(history, i), rows);
    return rows;
}

static void write_date(const json_t *row, struct pen_buf *out)
{
    pen_buf_printf(out, "%.10s", pen_report_string(row, "of.began_at"));
}

static void write_build(const json_t *row, struct pen_buf *out)
{
    pen_buf_printf(out, "%.7s", pen_report_string(row, "of.build"));
}

static const struct pen_column columns[] = {
    {"began_at", "date", "of.began_at", .cell = PEN_CELL_TEXT, .write = write_date},
    {"version", "version", "of.version", .cell = PEN_CELL_TEXT},
    {"build", "build", "of.build", .cell = PEN_CELL_TEXT, .write = write_build},
    {"host", "host", "of.host", .cell = PEN_CELL_COUNT},
    {"median_ms", "median ms", "median_ms", .cell = PEN_CELL_NUMBER},
    {"low_ms", "95 %", "low_ms", .to = "high_ms"},
    {"high_ms", NULL, "high_ms", .cell = PEN_CELL_NUMBER},
    {"calibrated", "over calibration", "calibrated", .cell = PEN_CELL_NUMBER},
    {0}};

const struct pen_report_kind pen_kind_history = {.name = "history",
                                                 .title = "History",
                                                 .columns = columns,
                                                 .caption = "All reports in the order of time",
                                                 .rows = make_rows,
                                                 .answer = write_answer,
                                                 .notes = write_notes};
