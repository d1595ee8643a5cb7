/* SPDX-License-Identifier: MIT */
/* The plots are drawn to be read at 400 pixels. Units: pixels of the view box. */
#include "study/internal/accuracy_plot.h"

#include <math.h>
#include <string.h>

#include "study/internal/accuracy_words.h"
#include "study/internal/axis.h"
#include "study/internal/html.h"

enum { WIDTH = 420, HEIGHT = 330, LEFT = 58, RIGHT = 408, TOP = 28, BOTTOM = 276 };
enum { COLOURS = 6, EDGE = 36 };

static const char file_style[] =
    "<style>text{font:12px system-ui,sans-serif;fill:#1b1f24}.tick{fill:#5a6370;font-size:11px}"
    ".grid{stroke:#d6dbe1;fill:none}.curve{stroke:#3573b9;fill:none;stroke-width:2}"
    ".dot{fill:#8a94a3}.front{fill:#3573b9}.best{fill:none;stroke:#1b1f24;stroke-width:1.5}"
    ".ideal{stroke:#5a6370;stroke-dasharray:4 4;fill:none}"
    ".whisker{stroke:#1b1f24;stroke-width:1;fill:none}"
    "@media(prefers-color-scheme:dark){text{fill:#e7eaee}.tick{fill:#a3adb9}.grid{stroke:#39424d}"
    ".curve{stroke:#5b9ae0}.front{fill:#5b9ae0}.best,.whisker{stroke:#f2f4f6}}</style>";

/* A plot with two logarithmic axes. */
struct plot {
    const json_t *report;
    const char *metric;
    struct pen_axis x, y;
};

/* The values on an axis, from the least to the largest. */
struct range {
    double low, high;
};

static void widen(struct range *range, double value)
{
    if (!(value > 0) || !isfinite(value))
        return;
    range->low = range->low > 0 ? fmin(range->low, value) : value;
    range->high = fmax(range->high, value);
}

/* A logarithmic axis over a range, with a margin, and at least a factor of three. */
static struct pen_axis axis_over(struct range range, double first, double end)
{
    if (!(range.low > 0))
        range = (struct range){1, 1};
    const double least = sqrt(3 / fmin(range.high / range.low, 3)), margin = 1.25 * least;
    return (struct pen_axis){.low = range.low / margin,
                             .high = range.high * margin,
                             .first = first,
                             .end = end,
                             .logarithmic = true};
}

static bool has(const json_t *row, const char *metric)
{
    return pen_bench_report_number(row, metric) > 0;
}

/* What a row shows: its error, or the bound of one that is unresolved. */
static double error_of(const struct plot *plot, const json_t *row)
{
    if (has(row, plot->metric))
        return pen_bench_report_number(row, plot->metric);
    return strcmp(plot->metric, "rmse") == 0 ? pen_bench_report_number(row, "rmse_below") : 0;
}

static struct range spread_of(const struct plot *plot, const json_t *row)
{
    const json_t *spread = json_object_get(json_object_get(row, "spread"), plot->metric);
    return (struct range){json_number_value(json_array_get(spread, 0)),
                          json_number_value(json_array_get(spread, 1))};
}

static const json_t *row_of(const struct plot *plot, size_t i)
{
    return pen_bench_report_row(plot->report, i);
}

static double x_at(const struct plot *plot, double value)
{
    return pen_axis_place(&plot->x, value);
}

static double y_at(const struct plot *plot, double value)
{
    return pen_axis_place(&plot->y, value);
}

/* Whether to label the ticks of 2 and 5, too: where the axis spans less than two decades.
 */
static bool is_short(const struct pen_axis *axis)
{
    return axis->high / axis->low < 100;
}

/* Time of a tick: "20 ms", "2 s". */
static void write_time(double ms, struct pen_buf *out)
{
    if (ms >= 1000)
        pen_buf_printf(out, "%g s", ms / 1000);
    else
        pen_buf_printf(out, "%g ms", ms);
}

static void write_count(double count, struct pen_buf *out)
{
    pen_buf_printf(out, "%.0f", count);
}

typedef void tick_fn(double value, struct pen_buf *out);

static void write_x_tick(const struct plot *plot, double value, tick_fn *label, struct pen_buf *out)
{
    const double x = x_at(plot, value);
    pen_buf_printf(out,
                   "<path class=\"grid\" d=\"M%.1f %d V%d\"/><text class=\"tick\" x=\"%.1f\" "
                   "y=\"%d\" text-anchor=\"middle\">",
                   x, TOP, BOTTOM, x, BOTTOM + 16);
    label(value, out);
    pen_buf_puts(out, "</text>");
}

static void write_y_tick(const struct plot *plot, double value, struct pen_buf *out)
{
    const double y = y_at(plot, value);
    pen_buf_printf(out,
                   "<path class=\"grid\" d=\"M%d %.1f H%d\"/><text class=\"tick\" x=\"%d\" "
                   "y=\"%.1f\" text-anchor=\"end\">%g</text>",
                   LEFT, y, RIGHT, LEFT - 6, y + 4, value);
}

/* Calls `write` for the values 1, 2 and 5 times a power of ten that an axis shows; on a long axis
 * for the powers alone. */
static void write_ticks(const struct plot *plot, const struct pen_axis *axis, tick_fn *label,
                        struct pen_buf *out)
{
    static const double steps[] = {1, 2, 5};
    for (double unit = pow(10, floor(log10(axis->low))); unit <= axis->high; unit *= 10) {
        for (int i = 0; i < (is_short(axis) ? 3 : 1); i++) {
            const double value = unit * steps[i];
            if (value < axis->low || value > axis->high)
                continue;
            if (axis == &plot->x)
                write_x_tick(plot, value, label, out);
            else
                write_y_tick(plot, value, out);
        }
    }
}

/* The beginning of a plot: the element, what it shows in words, and its axes. */
static void begin(const struct plot *plot, const char *id, const char *title, const char *x_title,
                  tick_fn *label, bool style, struct pen_buf *out)
{
    pen_buf_printf(out,
                   "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" role=\"img\" "
                   "aria-labelledby=\"%s\">%s<title id=\"%s\">%s</title>",
                   (int)WIDTH, (int)HEIGHT, id, style ? file_style : "", id, title);
    write_ticks(plot, &plot->x, label, out);
    write_ticks(plot, &plot->y, label, out);
    pen_buf_printf(out,
                   "<text x=\"%d\" y=\"%d\" text-anchor=\"end\">%s</text>"
                   "<text x=\"4\" y=\"14\">%s</text>",
                   (int)RIGHT, (int)HEIGHT - 14, x_title, pen_accuracy_metric_title(plot->metric));
}

/* A row's place in the plot: what it changes, in few words. */
static void write_label(const json_t *row, struct pen_buf *out)
{
    const json_t *settings = json_object_get(row, "settings");
    struct pen_buf text = {0};
    if (json_object_size(settings) == 1) {
        const char *key;
        json_t *value;
        json_object_foreach((json_t *)(uintptr_t)settings, key, value)
        {
            pen_bench_write_value(value, &text);
        }
    } else {
        pen_buf_printf(&text, "%.0f", pen_bench_report_number(row, "row"));
    }
    pen_html_escape_buf(&text, out);
}

static void write_whiskers(const struct plot *plot, const json_t *row, struct pen_buf *out)
{
    const double x = x_at(plot, pen_bench_report_number(row, "median_ms")),
                 y = y_at(plot, error_of(plot, row));
    const struct range spread = spread_of(plot, row);
    pen_buf_printf(out, "<path class=\"whisker\" d=\"M%.1f %.1f H%.1f",
                   x_at(plot, pen_bench_report_number(row, "min_ms")), y,
                   x_at(plot, pen_bench_report_number(row, "max_ms")));
    if (spread.low > 0)
        pen_buf_printf(out, " M%.1f %.1f V%.1f", x, y_at(plot, spread.low),
                       y_at(plot, spread.high));
    pen_buf_puts(out, "\"/>");
}

static void write_point(const struct plot *plot, const json_t *row, struct pen_buf *out)
{
    const double x = x_at(plot, pen_bench_report_number(row, "median_ms")),
                 y = y_at(plot, error_of(plot, row));
    const bool front = json_is_true(json_object_get(row, "pareto")),
               resolved = has(row, plot->metric);
    write_whiskers(plot, row, out);
    if (resolved)
        pen_buf_printf(out, "<circle class=\"%s\" cx=\"%.1f\" cy=\"%.1f\" r=\"4\"/>",
                       front ? "front" : "dot", x, y);
    else /* somewhere below */
        pen_buf_printf(out, "<path class=\"%s\" d=\"M%.1f %.1f h8 l-4 7 z\"/>",
                       front ? "front" : "dot", x - 4, y);
    if (pen_accuracy_is_recommended(plot->report, row))
        pen_buf_printf(out, "<circle class=\"best\" cx=\"%.1f\" cy=\"%.1f\" r=\"8\"/>", x, y);
    const bool at_edge = x > RIGHT - EDGE; /* there is room to the left */
    pen_buf_printf(out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">", at_edge ? x + 5 : x + 7,
                   at_edge ? y - 10 : y - 7, at_edge ? "end" : "start");
    write_label(row, out);
    pen_buf_puts(out, "</text>");
}

/* The row of the front with the shortest time above this one; NULL: none. */
static const json_t *next_of_front(const struct plot *plot, double above_ms)
{
    const json_t *next = NULL;
    for (size_t i = 0; i < pen_bench_report_row_count(plot->report); i++) {
        const json_t *row = row_of(plot, i);
        const double ms = pen_bench_report_number(row, "median_ms");
        if (json_is_true(json_object_get(row, "pareto")) && ms > above_ms &&
            error_of(plot, row) > 0 && (!next || ms < pen_bench_report_number(next, "median_ms")))
            next = row;
    }
    return next;
}

static void write_front(const struct plot *plot, struct pen_buf *out)
{
    const json_t *row = next_of_front(plot, 0);
    char step = 'M';
    if (!row)
        return;
    pen_buf_puts(out, "<path class=\"curve c0\" d=\"");
    while (row) {
        const double ms = pen_bench_report_number(row, "median_ms");
        pen_buf_printf(out, "%c%.1f %.1f ", step, x_at(plot, ms), y_at(plot, error_of(plot, row)));
        row = next_of_front(plot, ms);
        step = 'L';
    }
    pen_buf_puts(out, "\"/>");
}

static void write_target(const struct plot *plot, struct pen_buf *out)
{
    const double target = pen_bench_report_number(plot->report, "target.value"),
                 y = y_at(plot, target);
    if (strcmp(pen_bench_report_string(plot->report, "target.metric"), plot->metric) != 0)
        return;
    pen_buf_printf(out,
                   "<path class=\"ideal\" d=\"M%d %.1f H%d\"/><text class=\"tick\" x=\"%d\" "
                   "y=\"%.1f\" text-anchor=\"end\">target %g</text>",
                   (int)LEFT, y, (int)RIGHT, (int)RIGHT, y - 4, target);
}

void pen_accuracy_plot_time(const json_t *report, const char *metric, bool style,
                            struct pen_buf *out)
{
    struct plot plot = {.report = report, .metric = metric};
    struct range times = {0}, errors = {0};
    char id[32], title[80];
    for (size_t i = 0; i < pen_bench_report_row_count(report); i++) {
        const json_t *row = row_of(&plot, i);
        const struct range spread = spread_of(&plot, row);
        widen(&times, pen_bench_report_number(row, "min_ms"));
        widen(&times, pen_bench_report_number(row, "max_ms"));
        widen(&errors, error_of(&plot, row));
        widen(&errors, spread.low);
        widen(&errors, spread.high);
    }
    if (strcmp(pen_bench_report_string(report, "target.metric"), metric) == 0)
        widen(&errors, pen_bench_report_number(report, "target.value"));
    plot.x = axis_over(times, LEFT, RIGHT);
    plot.y = axis_over(errors, BOTTOM, TOP);
    snprintf(id, sizeof id, "time-%s", metric);
    snprintf(title, sizeof title, "%s against time, both axes logarithmic",
             pen_accuracy_metric_title(metric));
    begin(&plot, id, title, "time to render", write_time, style, out);
    write_target(&plot, out);
    write_front(&plot, out);
    for (size_t i = 0; i < pen_bench_report_row_count(report); i++)
        if (error_of(&plot, row_of(&plot, i)) > 0)
            write_point(&plot, row_of(&plot, i), out);
    pen_buf_puts(out, "</svg>");
}

/* One series: its points, and the line that was fitted to them. */
static void write_series(const struct plot *plot, const json_t *series, size_t number,
                         struct pen_buf *out)
{
    const json_t *points = json_object_get(series, "points");
    struct range samples = {0};
    size_t i;
    json_t *point;
    pen_buf_printf(out, "<g class=\"c%zu\">", number % COLOURS);
    json_array_foreach(points, i, point)
    {
        const double n = pen_bench_report_number(point, "samples");
        widen(&samples, n);
        pen_buf_printf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\"/>", x_at(plot, n),
                       y_at(plot, pen_bench_report_number(point, "rmse")));
    }
    const double slope = pen_bench_report_number(series, "slope"),
                 at_1 = pen_bench_report_number(series, "rmse_at_1");
    pen_buf_printf(out,
                   "<path class=\"curve\" d=\"M%.1f %.1f L%.1f %.1f\"/>"
                   "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%.2f</text></g>",
                   x_at(plot, samples.low), y_at(plot, at_1 * pow(samples.low, slope)),
                   x_at(plot, samples.high), y_at(plot, at_1 * pow(samples.high, slope)),
                   x_at(plot, samples.high), y_at(plot, at_1 * pow(samples.high, slope)) - 8,
                   slope);
}

void pen_accuracy_plot_convergence(const json_t *report, struct pen_buf *out)
{
    struct plot plot = {.report = report, .metric = "rmse"};
    struct range samples = {0}, errors = {0};
    size_t i, k;
    json_t *series, *point;
    json_array_foreach(json_object_get(report, "convergence"), i, series)
    {
        json_array_foreach(json_object_get(series, "points"), k, point)
        {
            widen(&samples, pen_bench_report_number(point, "samples"));
            widen(&errors, pen_bench_report_number(point, "rmse"));
        }
    }
    if (!(samples.low > 0))
        return;
    plot.x = axis_over(samples, LEFT, RIGHT);
    plot.y = axis_over(errors, BOTTOM, TOP);
    begin(&plot, "convergence", "RMSE against the number of samples, both axes logarithmic",
          "samples N", write_count, false, out);
    json_array_foreach(json_object_get(report, "convergence"), i, series)
    {
        write_series(&plot, series, i, out);
    }
    pen_buf_puts(out, "</svg>");
}
