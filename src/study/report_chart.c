/* SPDX-License-Identifier: MIT */
/* The bar chart of a benchmark: a bar for each row's median, and a whisker from its least to its
 * largest time. Where the slowest row takes more than twenty times as long as the fastest, whose
 * bar would be too short to read, the axis is logarithmic.
 *
 * The page's style sheet sets the colours, by class. Units: pixels of the view box. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "study/internal/axis.h"
#include "study/internal/html.h"
#include "study/internal/report_formats.h"
#include "study/internal/report_values.h"

enum {
    WIDTH = 960,
    ROW = 30,
    BAR = 16,
    TOP = 30,
    VALUES = 190, /* the two columns of text right of the bars: median and speed-up */
    CHAR = 8,
    LABEL_MAX = 340
};

static const double logarithmic_above = 20; /* largest time / least time */

struct chart {
    const json_t *report;
    size_t rows;
    struct pen_axis axis; /* of times in ms */
};

static double x_of(const struct chart *chart, double ms)
{
    return pen_axis_place(&chart->axis, ms);
}

/* The width of the column of names, set by the longest. */
static double label_width(const struct chart *chart)
{
    size_t longest = 0;
    for (size_t i = 0; i < chart->rows; i++) {
        struct pen_buf name = {0};
        pen_bench_write_row_name(pen_bench_report_row(chart->report, i), &name);
        longest = name.bytes > longest ? name.bytes : longest;
        pen_buf_release(&name);
    }
    double width = 16 + (double)longest * CHAR;
    return width < LABEL_MAX ? width : LABEL_MAX;
}

static void find_scale(struct chart *chart)
{
    double least = HUGE_VAL, most = 0;
    for (size_t i = 0; i < chart->rows; i++) {
        const json_t *row = pen_bench_report_row(chart->report, i);
        least = fmin(least, pen_bench_report_number(row, "min_ms"));
        most = fmax(most, pen_bench_report_number(row, "max_ms"));
    }
    chart->axis.logarithmic = least > 0 && most > logarithmic_above * least;
    chart->axis.low = chart->axis.logarithmic ? pow(10, floor(log10(least / 1.5))) : 0;
    chart->axis.high = most > 0 ? most : 1;
}

static void write_tick(const struct chart *chart, double ms, double bottom, struct pen_buf *out)
{
    double x = x_of(chart, ms);
    pen_buf_printf(out,
                   "<path class=\"grid\" d=\"M%.1f %d V%.1f\"/><text class=\"tick\" x=\"%.1f\""
                   " y=\"%d\" text-anchor=\"middle\">",
                   x, TOP - 4, bottom, x, TOP - 10);
    if (ms >= 1000)
        pen_buf_printf(out, "%g s", ms / 1000);
    else
        pen_buf_printf(out, "%g ms", ms);
    pen_buf_puts(out, "</text>");
}

static void write_axis(const struct chart *chart, double bottom, struct pen_buf *out)
{
    if (chart->axis.logarithmic) {
        for (double ms = chart->axis.low; ms <= chart->axis.high; ms *= 10)
            write_tick(chart, ms, bottom, out);
        return;
    }
    double step = pen_axis_step(chart->axis.high, 6);
    for (int i = 0; i * step <= chart->axis.high; i++)
        write_tick(chart, i * step, bottom, out);
}

static void write_name(const json_t *row, double y, struct pen_buf *out)
{
    struct pen_buf name = {0};
    pen_bench_write_row_name(row, &name);
    pen_buf_printf(out, "<text class=\"name\" x=\"0\" y=\"%.1f\">", y);
    pen_html_escape_buf(&name, out);
    pen_buf_puts(out, "</text>");
}

static void write_bar(const struct chart *chart, size_t number, struct pen_buf *out)
{
    const json_t *row = pen_bench_report_row(chart->report, number);
    bool base = (double)number == pen_bench_report_number(chart->report, "baseline");
    double middle = TOP + ((double)number + 0.5) * ROW, text = middle + 5;
    double least = x_of(chart, pen_bench_report_number(row, "min_ms"));
    double most = x_of(chart, pen_bench_report_number(row, "max_ms"));
    double end = x_of(chart, pen_bench_report_number(row, "median_ms"));
    write_name(row, text, out);
    pen_buf_printf(out,
                   "<rect class=\"%s\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%d\"/>"
                   "<path class=\"whisker\" d=\"M%.1f %.1f H%.1f M%.1f %.1f v8 M%.1f %.1f v8\"/>",
                   base ? "bar base" : "bar", chart->axis.first, middle - BAR / 2.0,
                   fmax(end - chart->axis.first, 1), (int)BAR, least, middle, most, least,
                   middle - 4, most, middle - 4);
    pen_buf_printf(out, "<text class=\"figure\" x=\"%d\" y=\"%.1f\" text-anchor=\"end\">",
                   WIDTH - 80, text);
    pen_bench_write_number(pen_bench_report_number(row, "median_ms"), "\xE2\x80\xAF", out);
    pen_buf_printf(out, " ms</text><text class=\"figure\" x=\"%d\" y=\"%.1f\" text-anchor=\"end\">",
                   (int)WIDTH, text);
    pen_bench_write_speedup(row, out);
    pen_buf_puts(out, "</text>");
}

/* The chart in words, for readers who do not see it. */
static void describe(const struct chart *chart, struct pen_buf *out)
{
    pen_buf_printf(out,
                   "<title id=\"chart-title\">Median time of each row, %s axis</title>"
                   "<desc id=\"chart-desc\">",
                   chart->axis.logarithmic ? "logarithmic" : "linear");
    for (size_t i = 0; i < chart->rows; i++) {
        const json_t *row = pen_bench_report_row(chart->report, i);
        struct pen_buf name = {0};
        pen_bench_write_row_name(row, &name);
        pen_html_escape_buf(&name, out);
        pen_buf_puts(out, ": ");
        pen_bench_write_number(pen_bench_report_number(row, "median_ms"), "", out);
        pen_buf_puts(out, " ms. ");
    }
    pen_buf_puts(out, "</desc>");
}

void pen_bench_chart_write(const json_t *report, struct pen_buf *out)
{
    struct chart chart = {.report = report, .rows = pen_bench_report_row_count(report)};
    double bottom = TOP + (double)chart.rows * ROW;
    if (chart.rows == 0)
        return;
    chart.axis.first = label_width(&chart);
    chart.axis.end = WIDTH - VALUES;
    find_scale(&chart);
    pen_buf_printf(out,
                   "<svg viewBox=\"0 0 %d %.0f\" role=\"img\" aria-labelledby=\"chart-title"
                   " chart-desc\">",
                   (int)WIDTH, bottom + 8);
    describe(&chart, out);
    write_axis(&chart, bottom, out);
    for (size_t i = 0; i < chart.rows; i++)
        write_bar(&chart, i, out);
    if (chart.axis.logarithmic)
        pen_buf_printf(out, "<text class=\"tick\" x=\"0\" y=\"%d\">logarithmic axis</text>",
                       TOP - 10);
    pen_buf_puts(out, "</svg>");
}
