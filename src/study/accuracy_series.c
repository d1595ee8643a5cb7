/* SPDX-License-Identifier: MIT */
/* How errors fall with numbers of samples, what causes the error that remains, and which setting
 * meets a target. */
#include <math.h>
#include <string.h>

#include "io/settings_json.h"
#include "study/accuracy_summary.h"

/* The share from which a floor is reported. It halves a slope of -0.75 between the last two rows if
 * N grows fourfold. The errors of independent samples fall with N^-0.5, and stay above that. */
static const double most_floor = 0.75;
/* A setting is a cause of a floor if it makes up at least this share of it. */
static const double least_share = 0.25;
/* The assumed slope if there is only one row: that of independent samples. */
static const double slope_of_one = -0.5, least_slope = -0.1;
static const double samples_max = 1e8;

const char *const pen_sample_keys[PEN_SAMPLE_KINDS] = {"samples_per_pixel", "lens_samples",
                                                       "light_samples", "blur_samples"};

static bool is_camera(enum pen_sample_kind kind)
{
    return kind == PEN_SAMPLE_PIXEL || kind == PEN_SAMPLE_LENS;
}

static unsigned effects_of(const struct pen_accuracy *accuracy, int row)
{
    return pen_desc_effects(accuracy->task->frame.desc, &accuracy->task->rows[row].settings);
}

double pen_sample_count(const struct pen_accuracy *accuracy, int row, enum pen_sample_kind kind)
{
    const struct pen_settings *s = &accuracy->task->rows[row].settings;
    if (!is_camera(kind))
        return kind == PEN_SAMPLE_LIGHT ? s->light_samples : s->blur_samples;
    const bool lens = effects_of(accuracy, row) & PEN_FX_DEPTH_OF_FIELD;
    return lens && s->lens_samples > s->samples_per_pixel ? s->lens_samples : s->samples_per_pixel;
}

static bool is_varied(const struct pen_accuracy_task *task, enum pen_sample_kind kind)
{
    return json_object_get(task->rows[0].varied, pen_sample_keys[kind]) != NULL;
}

/* Whether two rows are equal in all settings but one. */
static bool same_others(const struct pen_accuracy_task *task, int a, int b, const char *except)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)task->rows[a].varied, key, value)
    {
        if (strcmp(key, except) != 0 &&
            !json_equal(value, json_object_get(task->rows[b].varied, key)))
            return false;
    }
    return true;
}

bool pen_accuracy_begins_series(const struct pen_accuracy *accuracy, int row,
                                enum pen_sample_kind kind)
{
    for (int i = 0; i < row; i++)
        if (same_others(accuracy->task, i, row, pen_sample_keys[kind]))
            return false;
    return is_varied(accuracy->task, kind);
}

/* The expected slope of log error over log samples. It is -0.5 for random points. It is -0.75 for a
 * stratified set of points across the edge of a shadow.
 * Source: Mitchell, "Consequences of stratified sampling in graphics", SIGGRAPH 1996. */
static double expected_slope(const struct pen_accuracy_row *row, enum pen_sample_kind kind)
{
    return kind == PEN_SAMPLE_LIGHT && row->settings.light_pattern == PEN_PATTERN_RANDOM ? -0.5
                                                                                         : -0.75;
}

static void add_point(struct pen_accuracy_series *series, int row, double samples, double rmse)
{
    int at = series->count++;
    for (; at > 0 && series->point[at - 1].samples > samples; at--)
        series->point[at] = series->point[at - 1];
    series->point[at].row = row;
    series->point[at].samples = samples;
    series->point[at].rmse = rmse;
}

/* The last point that has at most half of the samples of the last one; -1: none. */
static int before_last(const struct pen_accuracy_series *series)
{
    int at = series->count - 1;
    while (at >= 0 && series->point[at].samples > series->point[series->count - 1].samples / 2)
        at--;
    return at;
}

/* The square of a point's error, minus the square of the reference's error. */
static double squared(const struct pen_accuracy *accuracy, const struct pen_accuracy_series *series,
                      int point)
{
    const double error = series->point[point].rmse, reference = accuracy->reference.error;
    return fmax(error * error - reference * reference, 0);
}

/* The part of a point's squared error that more samples of this kind remove. It follows from the
 * last point of the series. Below 0: unknown. */
static double removable(const struct pen_accuracy *accuracy,
                        const struct pen_accuracy_series *series, int point)
{
    const int last = series->count - 1;
    if (point < 0 || series->point[point].samples > series->point[last].samples / 2)
        return -1;
    const double kept =
        pow(series->point[last].samples / series->point[point].samples, 2 * series->expected);
    return fmax(squared(accuracy, series, point) - squared(accuracy, series, last), 0) / (1 - kept);
}

static void fit(struct pen_accuracy_series *series)
{
    double x[PEN_ACCURACY_ROWS_MAX], y[PEN_ACCURACY_ROWS_MAX];
    for (int i = 0; i < series->count; i++) {
        x[i] = series->point[i].samples;
        y[i] = series->point[i].rmse;
    }
    series->line = pen_accuracy_fit(x, y, series->count);
}

static void find_floor(const struct pen_accuracy *accuracy, struct pen_accuracy_series *series)
{
    const int last = series->count - 1, before = before_last(series);
    const double part = removable(accuracy, series, before);
    series->floor = -1;
    if (part < 0 || !(squared(accuracy, series, last) > 0))
        return;
    const double left = squared(accuracy, series, before) - part;
    series->floor = fmin(fmax(left / squared(accuracy, series, last), 0), 1);
    series->floored = series->floor >= most_floor;
}

/* The squared error that more samples of another kind remove from a row of the series. Below 0:
 * unknown. */
static double removed_by(const struct pen_accuracy *accuracy,
                         const struct pen_accuracy_series *series, enum pen_sample_kind kind)
{
    double part = -1;
    for (int i = 0; i < series->count && part < 0 && is_varied(accuracy->task, kind); i++) {
        const int row = series->point[i].row;
        const struct pen_accuracy_series other = pen_accuracy_series_of(accuracy, row, kind, false);
        for (int k = 0; k < other.count; k++)
            if (other.point[k].row == row)
                part = fmax(part, removable(accuracy, &other, k));
    }
    return part;
}

/* Whether samples of another kind may cause a floor of the series. More camera rays also mean more
 * samples of all other kinds. Points on a light in a grid are an exception, since all camera rays
 * have the same points. */
static bool may_cause(const struct pen_accuracy *accuracy, const struct pen_accuracy_series *series,
                      enum pen_sample_kind kind)
{
    const unsigned effects = effects_of(accuracy, series->first);
    const struct pen_settings *s = &accuracy->task->rows[series->first].settings;
    if (kind == PEN_SAMPLE_LIGHT)
        return series->kind != kind && effects & PEN_FX_SOFT_SHADOWS &&
               (!is_camera(series->kind) || s->light_pattern == PEN_PATTERN_GRID);
    if (kind == PEN_SAMPLE_BLUR)
        return series->kind == PEN_SAMPLE_LIGHT && pen_effects_blur(effects);
    const bool lens = effects & PEN_FX_DEPTH_OF_FIELD;
    return !is_camera(series->kind) && lens == (kind == PEN_SAMPLE_LENS) &&
           accuracy->reference.settings.samples_per_pixel > 1;
}

/* Finds the causes of a floor. Samples of camera rays cause what is left of the floor after the
 * parts that other kinds of samples are known to remove. */
static void find_causes(const struct pen_accuracy *accuracy, struct pen_accuracy_series *series)
{
    const double floor = series->floor * squared(accuracy, series, series->count - 1);
    double left = floor;
    for (int kind = PEN_SAMPLE_KINDS - 1; kind >= 0; kind--) {
        if (!may_cause(accuracy, series, (enum pen_sample_kind)kind))
            continue;
        const bool camera = is_camera((enum pen_sample_kind)kind);
        const double part =
            camera ? left : removed_by(accuracy, series, (enum pen_sample_kind)kind);
        if (part < 0 || part >= least_share * floor)
            series->causes |= 1u << kind;
        if (part > 0)
            left -= part;
    }
}

struct pen_accuracy_series pen_accuracy_series_of(const struct pen_accuracy *accuracy, int row,
                                                  enum pen_sample_kind kind, bool all)
{
    const struct pen_accuracy_task *task = accuracy->task;
    struct pen_accuracy_series series = {
        .kind = kind, .first = row, .expected = expected_slope(&task->rows[row], kind)};
    for (int i = 0; i < task->row_count; i++) {
        const struct pen_accuracy_row_result *result = &accuracy->row[i];
        if (result->runs == 0 || pen_settings_adaptive(&task->rows[i].settings) ||
            !same_others(task, row, i, pen_sample_keys[kind]) ||
            (!all && !pen_accuracy_resolved(accuracy, result)))
            continue;
        const double rmse = pen_accuracy_error_of(result, PEN_METRIC_RMSE).median;
        if (rmse > 0)
            add_point(&series, i, pen_sample_count(accuracy, i, kind), rmse);
    }
    fit(&series);
    if (series.count > 0)
        find_floor(accuracy, &series);
    if (series.floored)
        find_causes(accuracy, &series);
    return series;
}

/* Converts a metric to an error that falls to 0 as the samples grow. */
static double as_error(enum pen_metric metric, double value)
{
    return metric == PEN_METRIC_PSNR   ? pow(10, -value / 20)
           : metric == PEN_METRIC_SSIM ? 1 - value
                                       : value;
}

static double worst_error(const struct pen_accuracy *accuracy, int row)
{
    const enum pen_metric metric = accuracy->task->metric;
    return as_error(metric, pen_accuracy_worst(&accuracy->row[row], metric));
}

/* Computes the number of samples of a kind with which a row would meet the target, if its error
 * falls with this slope. Keeps it in *need if it takes less time than the present *need. */
static void consider(const struct pen_accuracy *accuracy, int row, enum pen_sample_kind kind,
                     double slope, struct pen_accuracy_need *need)
{
    const struct pen_accuracy_task *task = accuracy->task;
    const struct pen_settings *s = &task->rows[row].settings;
    const double times = pow(as_error(task->metric, task->target) / worst_error(accuracy, row),
                             1 / slope),
                 samples = ceil(pen_sample_count(accuracy, row, kind) * times);
    if (!(slope < least_slope && times > 1 && samples <= samples_max))
        return;
    struct pen_settings with = *s;
    struct pen_errors ignored = {0};
    json_t *more = json_pack("{s:I}", pen_sample_keys[kind], (json_int_t)samples);
    const bool ok = more && pen_settings_read(more, "", &with, &ignored);
    json_decref(more);
    const double ms = pen_accuracy_time_of(&accuracy->row[row]).median *
                      pen_work_per_pixel(task->frame.desc, &with) /
                      pen_work_per_pixel(task->frame.desc, s);
    if (ok && (!need->setting || ms < need->ms))
        *need = (struct pen_accuracy_need){pen_sample_keys[kind], samples, ms};
}

/* Considers a series. Without a floor, its error is assumed to fall as it did before its last row.
 * At a floor, more samples are needed of the kinds that cause the floor. */
static void consider_series(const struct pen_accuracy *accuracy,
                            const struct pen_accuracy_series *series,
                            struct pen_accuracy_need *need)
{
    const int last = series->count - 1, before = before_last(series), row = series->point[last].row;
    for (int kind = 0; kind < PEN_SAMPLE_KINDS && series->floored; kind++)
        if (series->causes >> kind & 1 && !is_varied(accuracy->task, (enum pen_sample_kind)kind))
            consider(accuracy, row, (enum pen_sample_kind)kind, slope_of_one, need);
    if (series->floored)
        return;
    const double slope =
        before < 0
            ? slope_of_one
            : log(worst_error(accuracy, row) / worst_error(accuracy, series->point[before].row)) /
                  log(series->point[last].samples / series->point[before].samples);
    consider(accuracy, row, series->kind, slope, need);
}

struct pen_accuracy_need pen_accuracy_needed(const struct pen_accuracy *accuracy)
{
    struct pen_accuracy_need need = {0};
    for (int k = 0; k < PEN_SAMPLE_KINDS; k++) {
        const enum pen_sample_kind kind = (enum pen_sample_kind)k;
        for (int row = 0; row < accuracy->task->row_count; row++) {
            if (!pen_accuracy_begins_series(accuracy, row, kind))
                continue;
            struct pen_accuracy_series series = pen_accuracy_series_of(accuracy, row, kind, false);
            if (series.count < 2)
                series = pen_accuracy_series_of(accuracy, row, kind, true);
            if (series.count > 0)
                consider_series(accuracy, &series, &need);
        }
    }
    return need;
}
