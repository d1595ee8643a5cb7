/* SPDX-License-Identifier: MIT */
/* The report of an accuracy study as JSON; all other formats are made from it. */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "io/figures.h"
#include "io/json_build.h"
#include "io/settings_json.h"
#include "study/accuracy_summary.h"
#include "study/host.h"
#include "study/internal/accuracy_run.h"

/* The settings that are numbers of samples, over which errors converge. */
static const char *const sample_keys[] = {"samples_per_pixel", "light_samples", "blur_samples",
                                          "lens_samples", NULL};

/* The smallest difference of times that counts when two reports are compared. */
static const double least_effect = 0.02;

/* Four significant digits; null if it is not finite. */
static json_t *rounded(double value)
{
    if (!isfinite(value))
        return json_null();
    if (value == 0)
        return json_real(0);
    const double unit = pow(10, floor(log10(fabs(value))) - 3);
    return json_real(unit < 1 ? round(value / unit) / round(1 / unit) : round(value / unit) * unit);
}

/* {rmse: [5 %, 95 %], …} */
static json_t *spread_json(const struct pen_accuracy_row_result *row)
{
    json_t *json = json_object();
    for (int m = 0; m < PEN_METRIC_COUNT; m++) {
        const struct pen_accuracy_spread e =
            pen_accuracy_error_of(row, (enum pen_accuracy_metric)m);
        json = pen_json_with(json, pen_accuracy_metrics[m],
                             json_pack("[o, o]", rounded(e.low), rounded(e.high)));
    }
    return json;
}

/* Adds the medians of all metrics. Those of an unresolved row are null, beside the bound. */
static json_t *with_errors(json_t *json, const struct pen_accuracy *accuracy,
                           const struct pen_accuracy_row_result *row)
{
    const bool resolved = pen_accuracy_resolved(accuracy, row);
    for (int m = 0; m < PEN_METRIC_COUNT; m++) {
        const double median = pen_accuracy_error_of(row, (enum pen_accuracy_metric)m).median;
        json =
            pen_json_with(json, pen_accuracy_metrics[m], resolved ? rounded(median) : json_null());
    }
    json = pen_json_with(json, "resolved", json_boolean(resolved));
    if (!resolved)
        return pen_json_with(json, "rmse_below", rounded(pen_accuracy_limit(accuracy)));
    const double rmse = pen_accuracy_error_of(row, PEN_METRIC_RMSE).median,
                 seconds = pen_accuracy_time_of(row).median / 1000;
    json = pen_json_with(json, "spread", spread_json(row));
    return pen_json_with(json, "efficiency", rounded(1 / (rmse * rmse * seconds)));
}

/* In the order of their seeds. */
static json_t *runs_json(const struct pen_accuracy_row_result *row)
{
    json_t *list = json_array();
    for (int i = 0; i < row->runs; i++)
        json_array_append_new(list, pen_figure(row->run[i].render_ms));
    return pen_json_all(list, (size_t)row->runs);
}

static json_t *row_json(const struct pen_accuracy *accuracy, int number, bool front)
{
    const struct pen_accuracy_row_result *row = &accuracy->row[number];
    json_t *json = json_pack("{s:i, s:O, s:i, s:o}", "row", number, "settings",
                             accuracy->task->rows[number].varied, "runs", row->runs, "expected_ms",
                             pen_figure(row->expected_ms));
    if (row->runs == 0)
        return json;
    const struct pen_accuracy_spread time = pen_accuracy_time_of(row);
    json = pen_json_with(json, "threads", json_integer(row->threads));
    json = pen_json_with(json, "runs_ms", runs_json(row));
    json = pen_json_with(json, "picture_hash", json_sprintf("%016" PRIx64, row->picture_hash));
    json = pen_json_with(json, "median_ms", pen_figure(time.median));
    json = pen_json_with(json, "min_ms", pen_figure(time.low));
    json = pen_json_with(json, "max_ms", pen_figure(time.high));
    json = pen_json_with(json, "rays", pen_figure_rays(&row->rays));
    json = pen_json_with(json, "pareto", json_boolean(front));
    return with_errors(json, accuracy, row);
}

static json_t *rows_json(const struct pen_accuracy *accuracy)
{
    bool front[PEN_ACCURACY_ROWS_MAX];
    json_t *rows = json_array();
    pen_accuracy_front(accuracy, front);
    for (int i = 0; i < accuracy->task->row_count; i++)
        json_array_append_new(rows, row_json(accuracy, i, front[i]));
    return pen_json_all(rows, (size_t)accuracy->task->row_count);
}

/* The settings of a row without one of them. */
static json_t *others_of(const struct pen_accuracy_row *row, const char *key)
{
    json_t *others = json_copy((json_t *)(uintptr_t)row->varied);
    json_object_del(others, key);
    return others;
}

static bool same_others(const struct pen_accuracy_row *a, const struct pen_accuracy_row *b,
                        const char *key)
{
    json_t *of_a = others_of(a, key), *of_b = others_of(b, key);
    const bool same = of_a && of_b && json_equal(of_a, of_b);
    json_decref(of_a);
    json_decref(of_b);
    return same;
}

/* With half of the error for each doubling of a sequence's length to the power of this: of points
 * without order, and of a stratified set across the edge of a shadow (Mitchell, "Consequences of
 * stratified sampling in graphics", SIGGRAPH 1996). */
static double expected_slope(const struct pen_accuracy_row *row, const char *key)
{
    return strcmp(key, "light_samples") == 0 && row->settings.light_pattern == PEN_PATTERN_RANDOM
               ? -0.5
               : -0.75;
}

/* The rows that differ from row `first` in one setting alone, as a series of points. NULL, with no
 * error, if they are fewer than three. */
static json_t *series_json(const struct pen_accuracy *accuracy, int first, const char *key)
{
    const struct pen_accuracy_row *rows = accuracy->task->rows;
    double x[PEN_ACCURACY_ROWS_MAX], y[PEN_ACCURACY_ROWS_MAX];
    int count = 0;
    json_t *points = json_array();
    for (int i = first; i < accuracy->task->row_count; i++) {
        const struct pen_accuracy_row_result *row = &accuracy->row[i];
        if (row->runs == 0 || pen_settings_adaptive(&rows[i].settings) ||
            !same_others(&rows[first], &rows[i], key) || !pen_accuracy_resolved(accuracy, row))
            continue;
        y[count] = pen_accuracy_error_of(row, PEN_METRIC_RMSE).median;
        if (!(y[count] > 0))
            continue;
        x[count] = json_number_value(json_object_get(rows[i].varied, key));
        json_array_append_new(points, json_pack("{s:i, s:f, s:o}", "row", i, "samples", x[count],
                                                "rmse", rounded(y[count])));
        count++;
    }
    const struct pen_accuracy_line line = pen_accuracy_fit(x, y, count);
    if (!line.known) {
        json_decref(points);
        return NULL;
    }
    return json_pack("{s:s, s:o, s:f, s:o, s:[o, o], s:o, s:o}", "setting", key, "with",
                     others_of(&rows[first], key), "expected", expected_slope(&rows[first], key),
                     "slope", rounded(line.slope), "interval", rounded(line.low),
                     rounded(line.high), "rmse_at_1", rounded(line.at_1), "points", points);
}

/* Whether an earlier row differs from this one in that setting alone. */
static bool is_in_earlier(const struct pen_accuracy_task *task, int row, const char *key)
{
    for (int i = 0; i < row; i++)
        if (same_others(&task->rows[i], &task->rows[row], key))
            return true;
    return false;
}

static json_t *convergence_json(const struct pen_accuracy *accuracy)
{
    const struct pen_accuracy_task *task = accuracy->task;
    json_t *list = json_array();
    for (int k = 0; sample_keys[k]; k++) {
        if (!json_object_get(task->rows[0].varied, sample_keys[k]))
            continue;
        for (int i = 0; i < task->row_count; i++) {
            json_t *series = is_in_earlier(task, i, sample_keys[k])
                                 ? NULL
                                 : series_json(accuracy, i, sample_keys[k]);
            if (series)
                json_array_append_new(list, series);
        }
    }
    return list;
}

static json_t *recommended_json(const struct pen_accuracy *accuracy)
{
    const int row = pen_accuracy_recommended(accuracy);
    return row < 0
               ? json_null()
               : json_pack("{s:i, s:O}", "row", row, "settings", accuracy->task->rows[row].varied);
}

static json_t *reference_json(const struct pen_accuracy_reference *r)
{
    return json_pack("{s:o, s:i, s:o, s:o}", "settings", pen_settings_json(&r->settings), "factor",
                     r->factor, "error", rounded(r->error), "render_ms", pen_figure(r->render_ms));
}

static json_t *began_json(const struct pen_accuracy *accuracy)
{
    char text[25];
    pen_clock_format(accuracy->began_ms, text);
    return json_string(text);
}

/* Units: seconds. */
static json_t *seconds(double ms)
{
    return pen_figure(ms / 1000);
}

json_t *pen_accuracy_json(const struct pen_accuracy *accuracy, const char *scene)
{
    const struct pen_accuracy_task *task = accuracy->task;
    const struct pen_accuracy_forecast *f = &accuracy->forecast;
    return json_pack(
        "{s:s, s:s, s:I, s:o, s:s, s:i, s:f, s:{s:s, s:f}, s:o, s:o, s:o, s:o, s:{s:o, s:o, s:o, "
        "s:o}, s:O, s:o, s:i, s:f, s:{s:o}, s:o}",
        "kind", "accuracy", "scene", scene, "primitives", (json_int_t)task->desc->primitive_count,
        "began_at", began_json(accuracy), "view", task->desc->views[task->view].name, "seeds",
        task->seeds, "budget_seconds", task->budget_ms / 1000, "target", "metric",
        pen_accuracy_metrics[task->metric], "value", task->target, "recommended",
        recommended_json(accuracy), "rows", rows_json(accuracy), "reference",
        reference_json(&accuracy->reference), "convergence", convergence_json(accuracy), "forecast",
        "expected_seconds", seconds(f->expected_ms), "low", seconds(f->low_ms), "high",
        seconds(f->high_ms), "actual", seconds(accuracy->spent_ms), "left_out", accuracy->left_out,
        "render", pen_settings_json(task->settings), "pool_threads",
        pen_thread_pool_size(task->pool), "least_effect", least_effect, "calibration", "median_ms",
        pen_figure(accuracy->calibration_ms), "host", pen_host_json());
}
