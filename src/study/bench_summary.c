/* SPDX-License-Identifier: MIT */
#include "study/internal/bench_summary.h"

#include <stddef.h>

#include "study/internal/pictures.h"

struct spread {
    double median, min, max;
};

static double total_of(const struct pen_bench_times *run)
{
    return run->build_ms + run->render_ms;
}

/* The median, minimum and maximum of the times of runs. `values` is scratch space for `count`
 * numbers. */
static struct spread spread_of(const struct pen_bench_times *runs, int count, double *values)
{
    for (int i = 0; i < count; i++)
        values[i] = total_of(&runs[i]);
    const double median = pen_median(values, count);
    return (struct spread){.median = median, .min = values[0], .max = values[count - 1]};
}

/* The median of a member of the runs, given by its offset. */
static double median_of(const struct pen_bench_times *runs, int count, size_t offset,
                        double *values)
{
    for (int i = 0; i < count; i++)
        values[i] = *(const double *)((const char *)&runs[i] + offset);
    return pen_median(values, count);
}

static void summarize_row(struct pen_bench_row_result *row, int count, double *values)
{
    const struct spread total = spread_of(row->runs, count, values);
    row->median_ms = total.median;
    row->min_ms = total.min;
    row->max_ms = total.max;
    row->build_ms = median_of(row->runs, count, offsetof(struct pen_bench_times, build_ms), values);
    row->render_ms =
        median_of(row->runs, count, offsetof(struct pen_bench_times, render_ms), values);
    row->cpu_ms = median_of(row->runs, count, offsetof(struct pen_bench_times, cpu_ms), values);
    row->used = median_of(row->runs, count, offsetof(struct pen_bench_times, used), values);
    row->spoiled = 0;
    for (int i = 0; i < count; i++)
        row->spoiled += row->runs[i].spoiled;
}

/* The probability with which the next interval may err: that of its look, or of the only look. */
static double alpha_of(const struct pen_bench *bench, const struct pen_bench_result *result)
{
    return bench->interval > 0 ? pen_look_alpha(pen_look_of(result->repeats)) : 0.05;
}

static void find_ratio(const struct pen_bench *bench, const struct pen_bench_result *result,
                       struct pen_bench_row_result *row, double *values)
{
    const struct pen_bench_times *base = result->rows[bench->baseline].runs;
    int spoiled = 0;
    for (int i = 0; i < result->repeats; i++) {
        values[i] = total_of(&row->runs[i]) / total_of(&base[i]);
        spoiled += row->runs[i].spoiled || base[i].spoiled;
    }
    row->ratio = pen_median_interval(values, result->repeats, spoiled, alpha_of(bench, result));
}

void pen_bench_find_ratios(const struct pen_bench *bench, struct pen_bench_result *result,
                           double *values)
{
    for (int row = 0; row < bench->row_count; row++)
        find_ratio(bench, result, &result->rows[row], values);
    if (result->twin.runs)
        find_ratio(bench, result, &result->twin, values);
}

static bool is_narrow(const struct pen_bench *bench, const struct pen_confidence *ratio)
{
    return ratio->bounded && ratio->high - ratio->low <= bench->interval;
}

bool pen_bench_narrow(const struct pen_bench *bench, const struct pen_bench_result *result)
{
    bool narrow = bench->row_count > 1 || is_narrow(bench, &result->twin.ratio);
    for (int row = 0; narrow && row < bench->row_count; row++)
        narrow = row == bench->baseline || is_narrow(bench, &result->rows[row].ratio);
    return narrow;
}

void pen_bench_summarize(const struct pen_bench *bench, struct pen_bench_result *result,
                         double *values)
{
    const int count = result->repeats;
    for (int row = 0; row < bench->row_count; row++)
        summarize_row(&result->rows[row], count, values);
    if (result->twin.runs)
        summarize_row(&result->twin, count, values);
    for (int row = 0; row < bench->row_count; row++)
        result->rows[row].speedup =
            result->rows[bench->baseline].median_ms / result->rows[row].median_ms;
    pen_bench_find_ratios(bench, result, values);
    for (int i = 0; i < count; i++)
        values[i] = result->rows[0].runs[i].calibration_ms;
    result->calibration = pen_median_interval(values, count, 0, 0.05);
}

/* The reason why an interval gives no verdict. */
static const char *reason_of(const struct pen_confidence *ratio)
{
    if (ratio->count < PEN_PAIRS_MIN)
        return "there are fewer than 10 pairs of runs";
    if (!ratio->bounded)
        return "too many runs are spoiled";
    return ratio->spoiled > 0 ? "the interval is too wide, also because of spoiled runs"
                              : "the interval is too wide";
}

static void judge_ratio(struct pen_bench_row_result *row, double least_effect)
{
    row->verdict = pen_verdict_of(&row->ratio, least_effect);
    row->reason = row->verdict == PEN_VERDICT_UNDECIDED ? reason_of(&row->ratio) : "";
}

static bool differs(enum pen_verdict verdict)
{
    return verdict == PEN_VERDICT_FASTER || verdict == PEN_VERDICT_SLOWER;
}

static void judge_row(const struct pen_bench *bench, struct pen_bench_result *result, int number)
{
    struct pen_bench_row_result *row = &result->rows[number],
                                *base = &result->rows[bench->baseline];
    judge_ratio(row, bench->least_effect);
    if (row == base) {
        row->verdict = PEN_VERDICT_BASELINE;
        row->reason = "";
    } else if (row->picture_hash != base->picture_hash &&
               pen_bench_rows_same_quality(&bench->rows[number], &bench->rows[bench->baseline])) {
        row->verdict = PEN_VERDICT_DIFFERENT_PICTURE;
    } else if (differs(row->verdict) && result->twin.runs && differs(result->twin.verdict)) {
        row->verdict = PEN_VERDICT_UNDECIDED;
        row->reason = "the baseline's twin differs from the baseline, too";
    }
}

void pen_bench_judge(const struct pen_bench *bench, struct pen_bench_result *result)
{
    result->twin.reason = "";
    if (result->twin.runs)
        judge_ratio(&result->twin, bench->least_effect);
    for (int row = 0; row < bench->row_count; row++)
        judge_row(bench, result, row);
}
