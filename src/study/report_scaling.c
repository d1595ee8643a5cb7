/* SPDX-License-Identifier: MIT */
/* The chart of a benchmark whose rows differ in threads: the speed-up over the row of the fewest
 * threads, for each set of the other settings, beside the ideal, which is as many times as fast.
 *
 * It is drawn to be read at 400 pixels. The page's style sheet sets the colours, by class. Units:
 * pixels of the view box. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "study/internal/axis.h"
#include "study/internal/html.h"
#include "study/internal/report_formats.h"
#include "study/internal/report_values.h"
#include "study/verdict.h"

enum { WIDTH = 400, LEFT = 44, RIGHT = 386, TOP = 24, BOTTOM = 250, LEGEND = 300, LINE = 18 };
enum { SERIES_MAX = 6, COLOURS = 6, THREADS_MAX = 4096 };

static const double logarithmic_above = 8; /* most threads / fewest threads */

/* Rows that differ in threads alone. */
struct series {
    size_t first; /* a row of it */
    size_t base;  /* the row of the fewest threads */
};

struct chart {
    const json_t *report;
    size_t rows;
    struct series series[SERIES_MAX];
    int series_count, left_out; /* left_out: series beyond SERIES_MAX */
    struct pen_axis x, y;
};

static const json_t *row_of(const struct chart *chart, size_t i)
{
    return pen_bench_report_row(chart->report, i);
}

/* The threads that worked on a row; 0, which takes the row out of the chart, if the number cannot
 * be that of threads. */
static double threads_of(const struct chart *chart, size_t i)
{
    const double threads = pen_bench_report_number(row_of(chart, i), "threads");
    return threads >= 1 && threads <= THREADS_MAX ? floor(threads) : 0;
}

/* The settings of a row without threads. */
static json_t *others_of(const struct chart *chart, size_t i)
{
    json_t *settings = json_copy(json_object_get(row_of(chart, i), "settings"));
    json_object_del(settings, "threads");
    return settings;
}

static bool same_series(const struct chart *chart, size_t a, size_t b)
{
    json_t *of_a = others_of(chart, a), *of_b = others_of(chart, b);
    const bool same = of_a && of_b && json_equal(of_a, of_b);
    json_decref(of_a);
    json_decref(of_b);
    return same;
}

static void find_series(struct chart *chart)
{
    for (size_t row = 0; row < chart->rows; row++) {
        int s = 0;
        if (!(threads_of(chart, row) > 0))
            continue;
        while (s < chart->series_count && !same_series(chart, row, chart->series[s].first))
            s++;
        if (s == SERIES_MAX) {
            chart->left_out++;
            continue;
        }
        if (s == chart->series_count)
            chart->series[chart->series_count++] = (struct series){.first = row, .base = row};
        if (threads_of(chart, row) < threads_of(chart, chart->series[s].base))
            chart->series[s].base = row;
    }
}

static bool is_spoiled(const json_t *row, size_t run)
{
    size_t i;
    json_t *number;
    json_array_foreach(json_object_get(row, "spoiled_runs"), i, number)
    {
        if (json_is_integer(number) && (size_t)json_integer_value(number) == run)
            return true;
    }
    return false;
}

/* The speed-up of a row over another, by pairs of runs of one repeat: median and 95 % interval, or
 * where there is none, least and largest. */
static struct pen_confidence speedup_of(const json_t *base, const json_t *row)
{
    double values[PEN_PAIRS_MAX];
    const json_t *of_base = json_object_get(base, "runs_ms"),
                 *of_row = json_object_get(row, "runs_ms");
    int count = 0, spoiled = 0;
    for (size_t i = 0; i < json_array_size(of_row) && count < PEN_PAIRS_MAX; i++) {
        const double a = json_number_value(json_array_get(of_base, i));
        const double b = json_number_value(json_array_get(of_row, i));
        if (!(a > 0) || !(b > 0))
            continue;
        values[count++] = a / b;
        spoiled += is_spoiled(base, i) || is_spoiled(row, i);
    }
    if (count == 0)
        return (struct pen_confidence){0};
    struct pen_confidence out = pen_median_interval(values, count, spoiled, 0.05);
    if (!out.bounded) {
        out.low = values[0];
        out.high = values[count - 1];
    }
    return out;
}

static struct pen_confidence point_of(const struct chart *chart, const struct series *series,
                                      size_t row)
{
    return speedup_of(row_of(chart, series->base), row_of(chart, row));
}

/* Whether a row is one of a series. */
static bool is_in(const struct chart *chart, const struct series *series, size_t row)
{
    return threads_of(chart, row) > 0 && same_series(chart, row, series->first);
}

static void find_scales(struct chart *chart)
{
    double fewest = HUGE_VAL, most = 0, best = 1, ideal = 1, worst = 1;
    for (int s = 0; s < chart->series_count; s++) {
        const double base = threads_of(chart, chart->series[s].base);
        for (size_t row = 0; row < chart->rows; row++) {
            if (!is_in(chart, &chart->series[s], row))
                continue;
            const struct pen_confidence p = point_of(chart, &chart->series[s], row);
            fewest = fmin(fewest, threads_of(chart, row));
            most = fmax(most, threads_of(chart, row));
            ideal = fmax(ideal, threads_of(chart, row) / base);
            best = fmax(best, p.high);
            worst = p.low > 0 ? fmin(worst, p.low) : worst;
        }
    }
    const bool logarithmic = most > logarithmic_above * fewest;
    chart->x = (struct pen_axis){.low = logarithmic ? fewest : 0,
                                 .high = most,
                                 .first = LEFT,
                                 .end = RIGHT,
                                 .logarithmic = logarithmic};
    chart->y = (struct pen_axis){.low = logarithmic ? fmin(worst, 1) : 0,
                                 .high = fmax(ideal, fmin(best, 2 * ideal)) * 1.05,
                                 .first = BOTTOM,
                                 .end = TOP,
                                 .logarithmic = logarithmic};
}

static void write_y_tick(const struct chart *chart, double value, struct pen_buf *out)
{
    const double y = pen_axis_place(&chart->y, value);
    pen_buf_printf(out,
                   "<path class=\"grid\" d=\"M%d %.1f H%d\"/><text class=\"tick\" x=\"%d\" "
                   "y=\"%.1f\" text-anchor=\"end\">%g\xC3\x97</text>",
                   LEFT, y, RIGHT, LEFT - 6, y + 4, value);
}

static void write_axes(const struct chart *chart, struct pen_buf *out)
{
    if (chart->y.logarithmic)
        for (double value = 1; value <= chart->y.high; value *= 2)
            write_y_tick(chart, value, out);
    const double step = pen_axis_step(chart->y.high, 5);
    for (int i = 0; !chart->y.logarithmic && i * step <= chart->y.high; i++)
        write_y_tick(chart, i * step, out);
    double last = -HUGE_VAL;
    for (double threads = 1; threads <= chart->x.high; threads += 1) {
        const double x = pen_axis_place(&chart->x, threads);
        bool there = false;
        for (size_t row = 0; row < chart->rows; row++)
            there |= threads_of(chart, row) == threads;
        if (!there || x - last < 20)
            continue;
        last = x;
        pen_buf_printf(out,
                       "<path class=\"grid\" d=\"M%.1f %d v5\"/><text class=\"tick\" x=\"%.1f\" "
                       "y=\"%d\" text-anchor=\"middle\">%g</text>",
                       x, BOTTOM, x, BOTTOM + 18, threads);
    }
    pen_buf_printf(out,
                   "<text class=\"tick\" x=\"%d\" y=\"%d\" text-anchor=\"end\">threads%s</text>"
                   "<text class=\"tick\" x=\"4\" y=\"14\">speed-up over the fewest threads</text>",
                   RIGHT, BOTTOM + 34, chart->x.logarithmic ? ", both axes logarithmic" : "");
}

static void write_ideal(const struct chart *chart, const struct series *series, struct pen_buf *out)
{
    const double base = threads_of(chart, series->base);
    pen_buf_printf(out, "<path class=\"ideal\" d=\"M%.1f %.1f L%.1f %.1f\"/>",
                   pen_axis_place(&chart->x, base), pen_axis_place(&chart->y, 1),
                   pen_axis_place(&chart->x, chart->x.high),
                   pen_axis_place(&chart->y, chart->x.high / base));
}

/* The row of a series with the fewest threads above `above`; or rows itself. */
static size_t next_row(const struct chart *chart, const struct series *series, double above)
{
    size_t next = chart->rows;
    for (size_t row = 0; row < chart->rows; row++) {
        if (is_in(chart, series, row) && threads_of(chart, row) > above &&
            (next == chart->rows || threads_of(chart, row) < threads_of(chart, next)))
            next = row;
    }
    return next;
}

static void write_line(const struct chart *chart, int number, struct pen_buf *out)
{
    const struct series *series = &chart->series[number];
    double threads = 0;
    pen_buf_printf(out, "<g class=\"c%d\"><path class=\"curve\" d=\"", number % COLOURS);
    for (size_t row; (row = next_row(chart, series, threads)) < chart->rows;) {
        const struct pen_confidence p = point_of(chart, series, row);
        pen_buf_printf(out, "%s%.1f %.1f", threads > 0 ? " L" : "M",
                       pen_axis_place(&chart->x, threads_of(chart, row)),
                       pen_axis_place(&chart->y, p.median));
        threads = threads_of(chart, row);
    }
    pen_buf_puts(out, "\"/>");
    for (size_t row = 0; row < chart->rows; row++) {
        if (!is_in(chart, series, row))
            continue;
        const struct pen_confidence p = point_of(chart, series, row);
        const double x = pen_axis_place(&chart->x, threads_of(chart, row));
        pen_buf_printf(out,
                       "<path class=\"whisker\" d=\"M%.1f %.1f V%.1f M%.1f %.1f h6 M%.1f %.1f "
                       "h6\"/><circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.5\"/>",
                       x, pen_axis_place(&chart->y, p.low), pen_axis_place(&chart->y, p.high),
                       x - 3, pen_axis_place(&chart->y, p.low), x - 3,
                       pen_axis_place(&chart->y, p.high), x, pen_axis_place(&chart->y, p.median));
    }
    pen_buf_puts(out, "</g>");
}

/* The settings that a series is told by, in words. */
static void write_name(const struct chart *chart, const struct series *series, struct pen_buf *out)
{
    const char *key, *separator = "";
    json_t *value, *settings = others_of(chart, series->first);
    struct pen_buf text = {0};
    json_object_foreach(settings, key, value)
    {
        pen_buf_puts(&text, separator);
        if (!json_is_string(value))
            pen_buf_printf(&text, "%s ", key);
        pen_bench_write_value(value, &text);
        separator = ", ";
    }
    json_decref(settings);
    if (text.bytes == 0)
        pen_buf_puts(&text, "measured");
    pen_html_escape_buf(&text, out);
}

static void write_legend(const struct chart *chart, struct pen_buf *out)
{
    int y = LEGEND;
    for (int s = 0; s < chart->series_count; s++, y += LINE) {
        pen_buf_printf(out,
                       "<g class=\"c%d\"><path class=\"curve\" d=\"M%d %d h22\"/><circle cx=\"%d\""
                       " cy=\"%d\" r=\"3.5\"/></g><text x=\"%d\" y=\"%d\">",
                       s % COLOURS, LEFT, y - 4, LEFT + 11, y - 4, LEFT + 30, y);
        write_name(chart, &chart->series[s], out);
        pen_buf_puts(out, "</text>");
    }
    pen_buf_printf(
        out, "<path class=\"ideal\" d=\"M%d %d h22\"/><text x=\"%d\" y=\"%d\">ideal%s</text>", LEFT,
        y - 4, LEFT + 30, y, chart->left_out ? "; further settings are in the table alone" : "");
}

/* The chart in words, for readers who do not see it. */
static void describe(const struct chart *chart, struct pen_buf *out)
{
    pen_buf_puts(out, "<title id=\"scaling-title\">Speed-up over the number of threads</title>"
                      "<desc id=\"scaling-desc\">");
    for (int s = 0; s < chart->series_count; s++) {
        double threads = 0;
        write_name(chart, &chart->series[s], out);
        for (size_t row; (row = next_row(chart, &chart->series[s], threads)) < chart->rows;) {
            threads = threads_of(chart, row);
            pen_buf_printf(out, "; %g thread%s: %.2f times", threads, threads == 1 ? "" : "s",
                           point_of(chart, &chart->series[s], row).median);
        }
        pen_buf_puts(out, ". ");
    }
    pen_buf_puts(out, "</desc>");
}

/* Whether a series has rows of two numbers of threads. */
static bool is_worth_drawing(const struct chart *chart)
{
    for (int s = 0; s < chart->series_count; s++) {
        const struct series *series = &chart->series[s];
        if (next_row(chart, series, threads_of(chart, series->base)) < chart->rows)
            return true;
    }
    return false;
}

void pen_bench_scaling_write(const json_t *report, struct pen_buf *out)
{
    struct chart chart = {.report = report, .rows = pen_bench_report_row_count(report)};
    find_series(&chart);
    if (!is_worth_drawing(&chart))
        return;
    find_scales(&chart);
    pen_buf_printf(out,
                   "<h2>Threads</h2>\n<figure class=\"small\"><svg viewBox=\"0 0 %d %d\" "
                   "role=\"img\" aria-labelledby=\"scaling-title scaling-desc\">",
                   WIDTH, LEGEND + LINE * chart.series_count + 8);
    describe(&chart, out);
    write_axes(&chart, out);
    for (int s = 0; s < chart.series_count; s++)
        write_ideal(&chart, &chart.series[s], out);
    for (int s = 0; s < chart.series_count; s++)
        write_line(&chart, s, out);
    write_legend(&chart, out);
    pen_buf_puts(out, "</svg><figcaption>Dot: median of the pairs of runs of one repeat. Bar: its "
                      "95 % interval; of fewer than 10 pairs, or with too many spoiled runs, least "
                      "to largest. Dashed: as many "
                      "times as fast as there are threads.</figcaption></figure>\n");
}
