/* SPDX-License-Identifier: MIT */
#include "study/accuracy_summary.h"

#include <math.h>

#include "study/verdict.h"

static const double unresolved_below = 2; /* in units of the reference's error */

/* A quantile of sorted values, interpolated between neighbours. Equal neighbours may be infinite.
 */
static double quantile(const double *sorted, int count, double share)
{
    const double place = share * (count - 1);
    const int below = (int)place, above = below + 1 < count ? below + 1 : below;
    if (sorted[below] == sorted[above])
        return sorted[below];
    return sorted[below] + (place - below) * (sorted[above] - sorted[below]);
}

struct pen_accuracy_spread pen_accuracy_error_of(const struct pen_accuracy_row_result *row,
                                                 enum pen_metric metric)
{
    double values[PEN_ACCURACY_SEEDS_MAX];
    for (int i = 0; i < row->runs; i++)
        values[i] = row->run[i].error[metric];
    const double median = pen_median(values, row->runs);
    return (struct pen_accuracy_spread){.median = median,
                                        .low = quantile(values, row->runs, 0.05),
                                        .high = quantile(values, row->runs, 0.95)};
}

double pen_accuracy_worst(const struct pen_accuracy_row_result *row, enum pen_metric metric)
{
    const struct pen_accuracy_spread error = pen_accuracy_error_of(row, metric);
    return pen_metric_rises(metric) ? error.low : error.high;
}

struct pen_row_time pen_accuracy_time_of(const struct pen_accuracy_row_result *row)
{
    struct pen_run_time runs[PEN_ACCURACY_SEEDS_MAX];
    for (int i = 0; i < row->runs; i++)
        runs[i] = row->run[i].time;
    return pen_row_time_of(runs, row->runs);
}

struct pen_runs_use pen_accuracy_use(const struct pen_accuracy *accuracy)
{
    struct pen_runs_use use = {0};
    for (int i = 0; i < accuracy->task->row_count; i++)
        for (int k = 0; k < accuracy->row[i].runs; k++)
            pen_runs_use_add(&use, &accuracy->row[i].run[k].time, 1);
    if (accuracy->thread_ms > 0) /* includes the renders of the reference */
        use.used = accuracy->had_ms / accuracy->thread_ms;
    return use;
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

/* The error by which rows are ranked: all unresolved rows have the same. */
static double ranked_error(const struct pen_accuracy *accuracy,
                           const struct pen_accuracy_row_result *row)
{
    return fmax(pen_accuracy_error_of(row, PEN_METRIC_RMSE).median, pen_accuracy_limit(accuracy));
}

static int compare_cost(const struct pen_accuracy_row_result *a,
                        const struct pen_accuracy_row_result *b)
{
    const struct pen_row_time of_a = pen_accuracy_time_of(a), of_b = pen_accuracy_time_of(b);
    return pen_row_cost_compare(&of_a, &a->rays, &of_b, &b->rays);
}

/* Whether row a dominates row b: it is not more expensive and not less accurate, and is better in
 * one of them or comes first. */
static bool beats(const struct pen_accuracy *accuracy, int a, int b)
{
    const struct pen_accuracy_row_result *of_a = &accuracy->row[a], *of_b = &accuracy->row[b];
    const int cost = compare_cost(of_a, of_b);
    const double error_a = ranked_error(accuracy, of_a), error_b = ranked_error(accuracy, of_b);
    return cost <= 0 && error_a <= error_b && (cost < 0 || error_a < error_b || a < b);
}

void pen_accuracy_front(const struct pen_accuracy *accuracy, bool *front)
{
    const int count = accuracy->task->row_count;
    for (int i = 0; i < count; i++) {
        front[i] = accuracy->row[i].runs > 0;
        for (int k = 0; front[i] && k < count; k++)
            front[i] = k == i || accuracy->row[k].runs == 0 || !beats(accuracy, k, i);
    }
}

/* Whether a row meets the target in 95 % of its runs. */
static bool meets_target(const struct pen_accuracy_task *task,
                         const struct pen_accuracy_row_result *row)
{
    const double error = pen_accuracy_worst(row, task->metric);
    return pen_metric_rises(task->metric) ? error >= task->target : error <= task->target;
}

/* Whether another row that meets the target is clearly faster. */
static bool is_slower(const struct pen_accuracy *accuracy, const bool *meets, int row)
{
    const struct pen_row_time own = pen_accuracy_time_of(&accuracy->row[row]);
    for (int i = 0; i < accuracy->task->row_count; i++) {
        const struct pen_row_time other = pen_accuracy_time_of(&accuracy->row[i]);
        if (meets[i] && pen_row_time_compare(&other, &own) < 0)
            return true;
    }
    return false;
}

int pen_accuracy_recommended(const struct pen_accuracy *accuracy)
{
    const struct pen_runs_use use = pen_accuracy_use(accuracy);
    bool meets[PEN_ACCURACY_ROWS_MAX];
    int best = -1;
    for (int i = 0; i < accuracy->task->row_count; i++)
        meets[i] = accuracy->row[i].runs > 0 && meets_target(accuracy->task, &accuracy->row[i]);
    for (int i = 0; i < accuracy->task->row_count && !pen_runs_spoiled(&use); i++)
        if (meets[i] && !is_slower(accuracy, meets, i) &&
            (best < 0 ||
             pen_rays_total(&accuracy->row[i].rays) < pen_rays_total(&accuracy->row[best].rays)))
            best = i;
    return best;
}

/* The 97.5 % quantile of Student's t distribution. */
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
