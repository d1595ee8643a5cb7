/* SPDX-License-Identifier: MIT */
#include "study/accuracy_summary.h"

#include <math.h>
#include <stdlib.h>

static const double unresolved_below = 2; /* times the reference's error */

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* A quantile of sorted values, between the neighbouring ones. Equal neighbours may be infinite. */
static double quantile(const double *sorted, int count, double share)
{
    const double place = share * (count - 1);
    const int below = (int)place, above = below + 1 < count ? below + 1 : below;
    if (sorted[below] == sorted[above])
        return sorted[below];
    return sorted[below] + (place - below) * (sorted[above] - sorted[below]);
}

struct pen_accuracy_spread pen_accuracy_error_of(const struct pen_accuracy_row_result *row,
                                                 enum pen_accuracy_metric metric)
{
    double values[PEN_ACCURACY_SEEDS_MAX];
    for (int i = 0; i < row->runs; i++)
        values[i] = row->run[i].error[metric];
    qsort(values, (size_t)row->runs, sizeof *values, by_value);
    return (struct pen_accuracy_spread){.median = quantile(values, row->runs, 0.5),
                                        .low = quantile(values, row->runs, 0.05),
                                        .high = quantile(values, row->runs, 0.95)};
}

struct pen_accuracy_spread pen_accuracy_time_of(const struct pen_accuracy_row_result *row)
{
    double values[PEN_ACCURACY_SEEDS_MAX];
    for (int i = 0; i < row->runs; i++)
        values[i] = row->run[i].render_ms;
    qsort(values, (size_t)row->runs, sizeof *values, by_value);
    return (struct pen_accuracy_spread){.median = quantile(values, row->runs, 0.5),
                                        .low = values[0],
                                        .high = values[row->runs - 1]};
}

double pen_accuracy_limit(const struct pen_accuracy *accuracy)
{
    return unresolved_below * accuracy->reference.error;
}

bool pen_accuracy_resolved(const struct pen_accuracy *accuracy,
                           const struct pen_accuracy_row_result *row)
{
    return pen_accuracy_error_of(row, PEN_METRIC_RMSE).median >= pen_accuracy_limit(accuracy);
}

/* The error by which rows are ranked. */
static double ranked_error(const struct pen_accuracy *accuracy,
                           const struct pen_accuracy_row_result *row)
{
    return fmax(pen_accuracy_error_of(row, PEN_METRIC_RMSE).median, pen_accuracy_limit(accuracy));
}

void pen_accuracy_front(const struct pen_accuracy *accuracy, bool *front)
{
    const int count = accuracy->task->row_count;
    for (int i = 0; i < count; i++) {
        const struct pen_accuracy_row_result *row = &accuracy->row[i];
        front[i] = row->runs > 0;
        if (!front[i])
            continue;
        const double time = pen_accuracy_time_of(row).median, error = ranked_error(accuracy, row);
        for (int k = 0; front[i] && k < count; k++) {
            const struct pen_accuracy_row_result *other = &accuracy->row[k];
            if (k == i || other->runs == 0)
                continue;
            const double other_time = pen_accuracy_time_of(other).median,
                         other_error = ranked_error(accuracy, other);
            const bool better = other_time < time || other_error < error || k < i;
            front[i] = !(other_time <= time && other_error <= error && better);
        }
    }
}

/* Whether a row's error meets the target in 95 % of its runs. */
static bool meets_target(const struct pen_accuracy_task *task,
                         const struct pen_accuracy_row_result *row)
{
    const struct pen_accuracy_spread error = pen_accuracy_error_of(row, task->metric);
    return pen_accuracy_metric_rises(task->metric) ? error.low >= task->target
                                                   : error.high <= task->target;
}

int pen_accuracy_recommended(const struct pen_accuracy *accuracy)
{
    int best = -1;
    double best_ms = HUGE_VAL;
    for (int i = 0; i < accuracy->task->row_count; i++) {
        const struct pen_accuracy_row_result *row = &accuracy->row[i];
        if (row->runs == 0 || !meets_target(accuracy->task, row))
            continue;
        const double ms = pen_accuracy_time_of(row).median;
        if (ms < best_ms) {
            best = i;
            best_ms = ms;
        }
    }
    return best;
}

/* The quantile of 97.5 % of Student's t distribution. */
static double student(int freedom)
{
    static const double t[] = {0,     12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365,
                               2.306, 2.262,  2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
                               2.120, 2.110,  2.101, 2.093, 2.086, 2.080, 2.074, 2.069,
                               2.064, 2.060,  2.056, 2.052, 2.048, 2.045, 2.042};
    const int last = (int)(sizeof t / sizeof t[0]) - 1;
    return t[freedom < last ? freedom : last];
}

struct pen_accuracy_line pen_accuracy_fit(const double *x, const double *y, int count)
{
    double mean_x = 0, mean_y = 0, xx = 0, xy = 0, rest = 0;
    for (int i = 0; i < count; i++) {
        mean_x += log(x[i]) / count;
        mean_y += log(y[i]) / count;
    }
    for (int i = 0; i < count; i++) {
        xx += (log(x[i]) - mean_x) * (log(x[i]) - mean_x);
        xy += (log(x[i]) - mean_x) * (log(y[i]) - mean_y);
    }
    if (count < 3 || !(xx > 0))
        return (struct pen_accuracy_line){0};
    const double slope = xy / xx;
    for (int i = 0; i < count; i++) {
        const double off = log(y[i]) - mean_y - slope * (log(x[i]) - mean_x);
        rest += off * off;
    }
    const double half = student(count - 2) * sqrt(rest / (count - 2) / xx);
    return (struct pen_accuracy_line){.slope = slope,
                                      .low = slope - half,
                                      .high = slope + half,
                                      .at_1 = exp(mean_y - slope * mean_x),
                                      .known = true};
}
