/* SPDX-License-Identifier: MIT */
/* The report of an accuracy study as JSON; all other formats are made from it. */
#include <math.h>
#include <string.h>

#include "io/figures.h"
#include "io/json_build.h"
#include "io/settings_json.h"
#include "study/accuracy_summary.h"
#include "study/host.h"
#include "study/internal/accuracy_run.h"
#include "study/internal/report_json.h"

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
        const struct pen_accuracy_spread e = pen_accuracy_error_of(row, (enum pen_metric)m);
        json = pen_json_with(json, pen_metrics[m],
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
        const double median = pen_accuracy_error_of(row, (enum pen_metric)m).median;
        json = pen_json_with(json, pen_metrics[m], resolved ? rounded(median) : json_null());
    }
    json = pen_json_with(json, "resolved", json_boolean(resolved));
    if (!resolved)
        return pen_json_with(json, "rmse_below", rounded(pen_accuracy_limit(accuracy)));
    const double rmse = pen_accuracy_error_of(row, PEN_METRIC_RMSE).median,
                 seconds = pen_accuracy_time_of(row).median / 1000;
    json = pen_json_with(json, "spread", spread_json(row));
    return pen_json_with(json, "efficiency", rounded(1 / (rmse * rmse * seconds)));
}

/* The runs of a row, in the order of their seeds. */
static json_t *runs_json(const struct pen_accuracy_row_result *row)
{
    json_t *list = json_array();
    for (int i = 0; i < row->runs; i++)
        json_array_append_new(list, pen_figure(row->run[i].time.ms));
    return pen_json_all(list, (size_t)row->runs);
}

/* The numbers of the spoiled runs. */
static json_t *spoiled_json(const struct pen_accuracy_row_result *row)
{
    json_t *list = json_array();
    for (int i = 0; i < row->runs; i++)
        if (row->run[i].time.spoiled)
            json_array_append_new(list, json_integer(i));
    return list;
}

static json_t *row_json(const struct pen_accuracy *accuracy, int number, bool front)
{
    const struct pen_accuracy_row_result *row = &accuracy->row[number];
    json_t *json = json_pack("{s:i, s:O, s:i, s:o}", "row", number, "settings",
                             accuracy->task->rows[number].varied, "runs", row->runs, "expected_ms",
                             pen_figure(row->expected_ms));
    if (row->runs == 0)
        return json;
    const struct pen_row_time time = pen_accuracy_time_of(row);
    json = pen_json_with(json, "threads", json_integer(row->threads));
    json = pen_json_with(json, "runs_ms", runs_json(row));
    json = pen_json_with(json, "spoiled_runs", spoiled_json(row));
    json = pen_json_with(json, "picture_hash", pen_report_hash_json(row->picture_hash));
    json = pen_json_with(json, "median_ms", pen_figure(time.median));
    json = pen_json_with(json, "min_ms", pen_figure(time.min));
    json = pen_json_with(json, "max_ms", pen_figure(time.max));
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

/* The settings of a row except one. */
static json_t *others_of(const struct pen_accuracy_row *row, const char *key)
{
    json_t *others = json_copy((json_t *)(uintptr_t)row->varied);
    json_object_del(others, key);
    return others;
}

/* The floor of a series: {share, rmse, settings}; null if it has none. */
static json_t *floor_json(const struct pen_accuracy *accuracy,
                          const struct pen_accuracy_series *series)
{
    const int last = series->count - 1;
    json_t *settings = json_object();
    if (!series->floored) {
        json_decref(settings);
        return json_null();
    }
    for (int kind = 0; kind < PEN_SAMPLE_KINDS; kind++)
        if (series->causes >> kind & 1)
            settings =
                pen_json_with(settings, pen_sample_keys[kind],
                              json_integer((json_int_t)pen_sample_count(
                                  accuracy, series->point[last].row, (enum pen_sample_kind)kind)));
    return json_pack("{s:o, s:o, s:o}", "share", rounded(series->floor), "rmse",
                     rounded(series->point[last].rmse * sqrt(series->floor)), "settings", settings);
}

static json_t *series_json(const struct pen_accuracy *accuracy,
                           const struct pen_accuracy_series *series)
{
    const char *key = pen_sample_keys[series->kind];
    json_t *points = json_array();
    for (int i = 0; i < series->count; i++)
        json_array_append_new(points, json_pack("{s:i, s:f, s:o}", "row", series->point[i].row,
                                                "samples", series->point[i].samples, "rmse",
                                                rounded(series->point[i].rmse)));
    return json_pack("{s:s, s:o, s:f, s:o, s:[o, o], s:o, s:o, s:o}", "setting", key, "with",
                     others_of(&accuracy->task->rows[series->first], key), "expected",
                     series->expected, "slope", rounded(series->line.slope), "interval",
                     rounded(series->line.low), rounded(series->line.high), "rmse_at_1",
                     rounded(series->line.at_1), "floor", floor_json(accuracy, series), "points",
                     pen_json_all(points, (size_t)series->count));
}

/* The series that have at least three resolved rows. */
static json_t *convergence_json(const struct pen_accuracy *accuracy)
{
    json_t *list = json_array();
    for (int k = 0; k < PEN_SAMPLE_KINDS; k++) {
        for (int i = 0; i < accuracy->task->row_count; i++) {
            if (!pen_accuracy_begins_series(accuracy, i, (enum pen_sample_kind)k))
                continue;
            const struct pen_accuracy_series series =
                pen_accuracy_series_of(accuracy, i, (enum pen_sample_kind)k, false);
            if (series.line.known)
                json_array_append_new(list, series_json(accuracy, &series));
        }
    }
    return list;
}

/* The setting that would meet a target that no row meets. null if a row meets it, or if no row may
 * be recommended. */
static json_t *needed_json(const struct pen_accuracy *accuracy)
{
    const struct pen_runs_use use = pen_accuracy_use(accuracy);
    const bool asked = pen_accuracy_recommended(accuracy) < 0 && !pen_runs_spoiled(&use);
    const struct pen_accuracy_need need =
        asked ? pen_accuracy_needed(accuracy) : (struct pen_accuracy_need){0};
    return need.setting ? json_pack("{s:{s:I}, s:o}", "settings", need.setting,
                                    (json_int_t)need.samples, "expected_ms", pen_figure(need.ms))
                        : json_null();
}

/* How much of the processors all runs got. */
static json_t *timing_json(const struct pen_accuracy *accuracy)
{
    const struct pen_runs_use use = pen_accuracy_use(accuracy);
    return json_pack("{s:i, s:i, s:o}", "runs", use.runs, "spoiled", use.spoiled, "cpu_share",
                     pen_figure(use.used));
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
        "{s:s, s:s, s:I, s:o, s:s, s:i, s:f, s:{s:s, s:f}, s:o, s:o, s:o, s:o, s:o, s:o, s:{s:o, "
        "s:o, "
        "s:o, s:o}, s:O, s:o, s:i, s:f, s:{s:o}, s:o}",
        "kind", "accuracy", "scene", scene, "primitives",
        (json_int_t)task->frame.desc->primitive_count, "began_at",
        pen_report_time_json(accuracy->began_ms), "view", task->frame.desc->views[task->view].name,
        "seeds", task->seeds, "budget_seconds", task->budget_ms / 1000, "target", "metric",
        pen_metrics[task->metric], "value", task->target, "recommended", recommended_json(accuracy),
        "needed", needed_json(accuracy), "timing", timing_json(accuracy), "rows",
        rows_json(accuracy), "reference", reference_json(&accuracy->reference), "convergence",
        convergence_json(accuracy), "forecast", "expected_seconds", seconds(f->expected_ms), "low",
        seconds(f->low_ms), "high", seconds(f->high_ms), "actual", seconds(accuracy->spent_ms),
        "left_out", accuracy->left_out, "render", pen_settings_json(task->settings), "pool_threads",
        pen_thread_pool_size(task->frame.pool), "least_effect", PEN_LEAST_EFFECT, "calibration",
        "median_ms", pen_figure(accuracy->calibration_ms), "host", pen_host_json());
}
