/* SPDX-License-Identifier: MIT */
/* A history as text and as a page. Of each series there is a chart: the medians with their
 * intervals from report to report, a colour for each host, and a line where times have changed.
 * Units: pixels of the view box. */
#include <math.h>
#include <string.h>

#include "study/history.h"
#include "study/internal/axis.h"
#include "study/internal/html.h"
#include "study/internal/page.h"
#include "study/internal/report_formats.h"
#include "study/internal/table.h"

enum { WIDTH = 400, LEFT = 56, RIGHT = 390, TOP = 34, BOTTOM = 190, HEIGHT = 232, COLOURS = 6 };
enum { BUILD_LENGTH = 7 };

static const json_t *report_of(const json_t *history, const json_t *point)
{
    const double number = pen_bench_report_number(point, "report");
    return json_array_get(json_object_get(history, "reports"), number >= 0 ? (size_t)number : 0);
}

/* "2026-11-24 build 1234567" */
static void write_report_name(const json_t *report, struct pen_buf *out)
{
    pen_buf_printf(out, "%.10s build %.*s", pen_bench_report_string(report, "began_at"),
                   (int)BUILD_LENGTH, pen_bench_report_string(report, "build"));
}

/* The settings of a series in words. */
static void write_series_name(const json_t *row, struct pen_buf *out)
{
    const char *key, *separator = "";
    json_t *value;
    const size_t before = out->bytes;
    json_object_foreach(json_object_get(row, "settings"), key, value)
    {
        pen_buf_printf(out, "%s%s ", separator, key);
        pen_bench_write_value(value, out);
        separator = ", ";
    }
    if (out->bytes == before)
        pen_buf_puts(out, "all runs");
}

/* "2026-11-24 build 1234567: 105 ms, before 100 ms, +5.0 %" */
static void write_change(const json_t *history, const json_t *row, const json_t *change,
                         struct pen_buf *out)
{
    const size_t point = (size_t)pen_bench_report_number(change, "point");
    write_report_name(report_of(history, json_array_get(json_object_get(row, "points"), point)),
                      out);
    pen_buf_puts(out, ": ");
    pen_bench_write_number(pen_bench_report_number(change, "after_ms"), " ", out);
    pen_buf_puts(out, " ms, before ");
    pen_bench_write_number(pen_bench_report_number(change, "before_ms"), " ", out);
    pen_buf_printf(out, " ms, %+.1f %%", (pen_bench_report_number(change, "ratio") - 1) * 100);
}

static void write_plain_buf(struct pen_buf *text, struct pen_buf *out)
{
    pen_bench_write_plain(text->data ? (const char *)text->data : "", out);
    out->failed |= text->failed;
    pen_buf_release(text);
}

static void write_text_series(const json_t *history, const json_t *row, struct pen_buf *out)
{
    const json_t *points = json_object_get(row, "points"),
                 *changes = json_object_get(row, "changes");
    struct pen_buf name = {0};
    size_t i;
    json_t *item;
    write_series_name(row, &name);
    write_plain_buf(&name, out);
    pen_buf_puts(out, "\n");
    json_array_foreach(points, i, item)
    {
        struct pen_buf line = {0};
        write_report_name(report_of(history, item), &line);
        pen_buf_printf(&line, "  host %g  ",
                       pen_bench_report_number(report_of(history, item), "host"));
        pen_bench_write_number(pen_bench_report_number(item, "median_ms"), " ", &line);
        pen_buf_puts(&line, " ms");
        if (json_is_number(json_object_get(item, "low_ms"))) {
            pen_buf_puts(&line, " (");
            pen_bench_write_number(pen_bench_report_number(item, "low_ms"), " ", &line);
            pen_buf_puts(&line, "\xE2\x80\x93");
            pen_bench_write_number(pen_bench_report_number(item, "high_ms"), " ", &line);
            pen_buf_puts(&line, ")");
        }
        pen_buf_puts(out, "  ");
        write_plain_buf(&line, out);
        pen_buf_puts(out, "\n");
    }
    json_array_foreach(changes, i, item)
    {
        struct pen_buf line = {0};
        write_change(history, row, item, &line);
        pen_buf_puts(out, "  change at ");
        write_plain_buf(&line, out);
        pen_buf_puts(out, "\n");
    }
    if (json_array_size(changes) == 0)
        pen_buf_puts(out, "  no change found\n");
}

void pen_history_write_text(const json_t *history, struct pen_buf *out)
{
    size_t i;
    json_t *row;
    json_array_foreach(json_object_get(history, "rows"), i, row)
    {
        pen_buf_puts(out, i ? "\n" : "");
        write_text_series(history, row, out);
    }
}

/* A chart while it is drawn. */
struct chart {
    const json_t *history, *row, *points;
    struct pen_axis x, y; /* of points by number; of ms */
};

static double x_of(const struct chart *chart, double point)
{
    return pen_axis_place(&chart->x, point);
}

static void find_scale(struct chart *chart)
{
    const size_t count = json_array_size(chart->points);
    double least = HUGE_VAL, most = 0;
    size_t i;
    json_t *point;
    json_array_foreach(chart->points, i, point)
    {
        const double median = pen_bench_report_number(point, "median_ms");
        const double low = pen_bench_report_number(point, "low_ms");
        least = fmin(least, low > 0 ? low : median);
        most = fmax(most, fmax(median, pen_bench_report_number(point, "high_ms")));
    }
    const double margin = fmax((most - least) * 0.15, most * 0.02);
    chart->x =
        (struct pen_axis){.low = -0.5, .high = (double)count - 0.5, .first = LEFT, .end = RIGHT};
    chart->y = (struct pen_axis){.low = fmax(0, least - margin),
                                 .high = most > 0 ? most + margin : 1,
                                 .first = BOTTOM,
                                 .end = TOP};
}

static void write_axes(const struct chart *chart, struct pen_buf *out)
{
    const double step = pen_axis_step(chart->y.high - chart->y.low, 5);
    const size_t count = json_array_size(chart->points), each = (count + 2) / 3;
    for (double k = ceil(chart->y.low / step); step > 0 && k * step <= chart->y.high; k++) {
        const double y = pen_axis_place(&chart->y, k * step);
        pen_buf_printf(out,
                       "<path class=\"grid\" d=\"M%d %.1f H%d\"/><text class=\"tick\" x=\"%d\" "
                       "y=\"%.1f\" text-anchor=\"end\">%g</text>",
                       LEFT, y, RIGHT, LEFT - 6, y + 4, k * step);
    }
    for (size_t i = 0; i < count; i += each) {
        const json_t *report = report_of(chart->history, json_array_get(chart->points, i));
        const double x = x_of(chart, (double)i);
        struct pen_buf date = {0};
        pen_buf_printf(&date, "%.10s", pen_bench_report_string(report, "began_at"));
        pen_buf_printf(out,
                       "<path class=\"grid\" d=\"M%.1f %d v5\"/><text class=\"tick\" x=\"%.1f\" "
                       "y=\"%d\" text-anchor=\"middle\">",
                       x, BOTTOM, fmin(fmax(x, LEFT + 20), RIGHT - 32), BOTTOM + 18);
        pen_html_escape_buf(&date, out);
        pen_buf_puts(out, "</text>");
    }
    pen_buf_printf(out,
                   "<text class=\"tick\" x=\"4\" y=\"14\">median, ms</text><text class=\"tick\" "
                   "x=\"%d\" y=\"%d\" text-anchor=\"end\">reports in the order of time</text>",
                   RIGHT, BOTTOM + 36);
}

static void write_changes(const struct chart *chart, struct pen_buf *out)
{
    size_t i;
    json_t *change;
    json_array_foreach(json_object_get(chart->row, "changes"), i, change)
    {
        const double x = x_of(chart, pen_bench_report_number(change, "point") - 0.5);
        pen_buf_printf(out,
                       "<path class=\"ideal\" d=\"M%.1f %d V%d\"/><text x=\"%.1f\" y=\"%d\" "
                       "text-anchor=\"middle\">%+.1f %%</text>",
                       x, TOP - 4, BOTTOM, fmin(fmax(x, LEFT + 20), RIGHT - 24), TOP - 8,
                       (pen_bench_report_number(change, "ratio") - 1) * 100);
    }
}

static void write_point(const struct chart *chart, size_t number, struct pen_buf *out)
{
    const json_t *point = json_array_get(chart->points, number);
    const json_t *report = report_of(chart->history, point);
    const double x = x_of(chart, (double)number);
    const double host = pen_bench_report_number(report, "host");
    struct pen_buf name = {0};
    pen_buf_printf(out, "<g class=\"c%d\"><title>", (int)fmod(fabs(host), COLOURS));
    write_report_name(report, &name);
    pen_html_escape_buf(&name, out);
    pen_buf_puts(out, ": ");
    pen_bench_write_number(pen_bench_report_number(point, "median_ms"), " ", out);
    pen_buf_puts(out, " ms</title>");
    if (json_is_number(json_object_get(point, "low_ms")))
        pen_buf_printf(out, "<path class=\"whisker\" d=\"M%.1f %.1f V%.1f\"/>", x,
                       pen_axis_place(&chart->y, pen_bench_report_number(point, "low_ms")),
                       pen_axis_place(&chart->y, pen_bench_report_number(point, "high_ms")));
    pen_buf_printf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\"/></g>", x,
                   pen_axis_place(&chart->y, pen_bench_report_number(point, "median_ms")));
}

static void write_html_changes(const struct chart *chart, struct pen_buf *out)
{
    const json_t *changes = json_object_get(chart->row, "changes");
    size_t i;
    json_t *change;
    if (json_array_size(changes) == 0) {
        pen_buf_puts(out, "<p>No change found.</p>\n");
        return;
    }
    pen_buf_puts(out, "<ul>");
    json_array_foreach(changes, i, change)
    {
        struct pen_buf line = {0};
        pen_buf_puts(out, "<li>Change at ");
        write_change(chart->history, chart->row, change, &line);
        pen_html_escape_buf(&line, out);
        pen_buf_puts(out, "</li>");
    }
    pen_buf_puts(out, "</ul>\n");
}

static void write_html_series(const json_t *history, const json_t *row, size_t number,
                              struct pen_buf *out)
{
    struct chart chart = {.history = history, .row = row, .points = json_object_get(row, "points")};
    struct pen_buf name = {0}, again = {0};
    if (json_array_size(chart.points) == 0)
        return;
    find_scale(&chart);
    write_series_name(row, &name);
    write_series_name(row, &again);
    pen_buf_puts(out, "<h2>");
    pen_html_escape_buf(&name, out);
    pen_buf_printf(out,
                   "</h2>\n<figure class=\"small\"><svg viewBox=\"0 0 %d %d\" role=\"img\" "
                   "aria-labelledby=\"title-%zu\"><title id=\"title-%zu\">Median times of %zu "
                   "reports: ",
                   WIDTH, HEIGHT, number, number, json_array_size(chart.points));
    pen_html_escape_buf(&again, out);
    pen_buf_puts(out, "</title>");
    write_axes(&chart, out);
    write_changes(&chart, out);
    for (size_t i = 0; i < json_array_size(chart.points); i++)
        write_point(&chart, i, out);
    pen_buf_puts(out, "</svg></figure>\n");
    write_html_changes(&chart, out);
}

static void write_hosts(const json_t *history, struct pen_buf *out)
{
    size_t i;
    json_t *host;
    pen_buf_puts(out, "<h2>Hosts</h2>\n<ol start=\"0\">");
    json_array_foreach(json_object_get(history, "hosts"), i, host)
    {
        pen_buf_printf(out,
                       "<li><svg class=\"key c%zu\" viewBox=\"0 0 10 10\" aria-hidden=\"true\">"
                       "<circle cx=\"5\" cy=\"5\" r=\"4\"/></svg> ",
                       i % COLOURS);
        pen_html_escape(pen_bench_report_string(host, "cpu"), out);
        pen_buf_puts(out, ", ");
        pen_html_escape(pen_bench_report_string(host, "kernel"), out);
        pen_buf_puts(out, "</li>");
    }
    pen_buf_puts(out, "</ol>\n");
}

void pen_history_write_html(const json_t *history, struct pen_buf *out)
{
    size_t i;
    json_t *row;
    pen_page_begin("History", pen_bench_report_string(history, "scene"), out);
    pen_buf_puts(out, "<p class=\"soft\">Dot: a report's median. Bar: its 95 % interval, from 10 "
                      "runs on. Colour: the host. Dashed: a change, among reports of one host, "
                      "that chance alone would show in at most one of twenty histories.</p>\n");
    json_array_foreach(json_object_get(history, "rows"), i, row)
    {
        write_html_series(history, row, i, out);
    }
    write_hosts(history, out);
    pen_page_end(out);
}
