/* SPDX-License-Identifier: MIT */
/* The report of a benchmark as JSON; all other formats are made from it. */
#include <math.h>

#include "base/cpu.h"
#include "io/figures.h"
#include "io/json_build.h"
#include "study/bench.h"
#include "study/host.h"
#include "study/internal/report_json.h"

/* Adds a note if fewer threads worked on a row than it requests. */
static void note_threads(const struct pen_bench *bench, const struct pen_bench_result *result,
                         int row, struct pen_buf *notes)
{
    const int requested = bench->rows[row].settings.threads,
              pool = pen_thread_pool_size(bench->frame.pool),
              used = result->rows[row].stats.threads,
              granted = requested > 0 && requested < pool ? requested : pool;
    if (requested > pool)
        pen_buf_printf(notes, "row %d asks for %d threads; the pool has %d\n", row, requested,
                       pool);
    if (used != granted)
        pen_buf_printf(notes, "of row %d no more than %d thread%s had tiles to work on\n", row,
                       used, used == 1 ? "" : "s");
}

/* Adds a note if other processes used the machine. That makes times longer, and changes ratios
 * less. */
static void note_load(const struct pen_bench_result *result, struct pen_buf *notes)
{
    const int cores = pen_cpu_count();
    if (result->load_before > 0.25 * cores)
        pen_buf_printf(notes,
                       "the machine was not idle at the beginning: load average %.2f on %d core%s; "
                       "ratios say more than times\n",
                       result->load_before, cores, cores == 1 ? "" : "s");
}

static void note_breaks(const struct pen_bench_result *result, struct pen_buf *notes)
{
    if (result->breaks > 0)
        pen_buf_printf(notes,
                       "the benchmark was interrupted %d time%s, and went on on the same host; "
                       "after each, one run was thrown away\n",
                       result->breaks, result->breaks == 1 ? "" : "s");
}

/* Adds a note if runs of a row are spoiled. number -1: the twin. */
static void note_spoiled(const struct pen_bench_row_result *row, int number, int repeats,
                         struct pen_buf *notes)
{
    if (row->spoiled == 0)
        return;
    pen_buf_printf(notes, "%d of %d runs of ", row->spoiled, repeats);
    if (number < 0)
        pen_buf_puts(notes, "the baseline's twin");
    else
        pen_buf_printf(notes, "row %d", number);
    pen_buf_printf(notes,
                   " are spoiled: its threads waited for processors; they had %.0f %% of the time "
                   "that they could use (median)\n",
                   row->used * 100);
}

/* Adds notes about what prevents verdicts. */
static void note_verdicts(const struct pen_bench *bench, const struct pen_bench_result *result,
                          struct pen_buf *notes)
{
    const enum pen_verdict twin = result->twin.verdict;
    if (bench->row_count > 1 && !result->twin.runs)
        pen_buf_printf(notes,
                       "verdicts need %d pairs of runs: ask for an interval, or for %d repeats\n",
                       PEN_PAIRS_MIN, PEN_PAIRS_MIN);
    if (result->twin.runs && twin != PEN_VERDICT_SAME && twin != PEN_VERDICT_UNDECIDED)
        pen_buf_printf(notes,
                       "the baseline's twin is %s than the baseline: on this host these times show "
                       "no smaller difference\n",
                       pen_verdict_name(twin));
    for (int row = 0; row < bench->row_count; row++)
        if (*result->rows[row].reason && result->repeats >= PEN_PAIRS_MIN)
            pen_buf_printf(notes, "row %d is undecided: %s\n", row, result->rows[row].reason);
}

/* Adds a note if the runs of a row are so short that each was repeated. */
static void note_short(const struct pen_bench_row_result *row, int number, int repeats,
                       struct pen_buf *notes)
{
    int least = repeats > 0 ? row->runs[0].in_a_row : 1;
    for (int i = 1; i < repeats; i++)
        least = row->runs[i].in_a_row < least ? row->runs[i].in_a_row : least;
    if (least > 1)
        pen_buf_printf(notes,
                       "a run of row %d takes less than 1 ms, so each of its times is the mean of "
                       "at least %d in a row\n",
                       number, least);
}

static json_t *notes_json(const struct pen_bench *bench, const struct pen_bench_result *result)
{
    struct pen_buf notes = {0};
    note_load(result, &notes);
    note_breaks(result, &notes);
    for (int row = 0; row < bench->row_count; row++)
        note_spoiled(&result->rows[row], row, result->repeats, &notes);
    note_spoiled(&result->twin, -1, result->repeats, &notes);
    note_verdicts(bench, result, &notes);
    for (int row = 0; row < bench->row_count; row++) {
        note_short(&result->rows[row], row, result->repeats, &notes);
        note_threads(bench, result, row, &notes);
    }
    return pen_lines_json(&notes);
}

static json_t *runs_json(const struct pen_bench_row_result *row, int count)
{
    json_t *list = json_array();
    for (int i = 0; i < count; i++) {
        const struct pen_bench_times *run = &row->runs[i];
        json_array_append_new(list, pen_figure(run->build_ms + run->render_ms));
    }
    return pen_json_all(list, (size_t)count);
}

/* The numbers of the spoiled runs. */
static json_t *spoiled_json(const struct pen_bench_row_result *row, int count)
{
    json_t *list = json_array();
    for (int i = 0; i < count; i++) {
        if (row->runs[i].spoiled)
            json_array_append_new(list, json_integer(i));
    }
    return pen_json_all(list, (size_t)row->spoiled);
}

/* The steal time of all runs; null if it is unknown. */
static json_t *steal_json(const struct pen_bench_row_result *row, int count)
{
    double sum = 0;
    for (int i = 0; i < count; i++) {
        if (row->runs[i].steal_ms < 0)
            return json_null();
        sum += row->runs[i].steal_ms;
    }
    return pen_figure(sum);
}

/* A ratio of times, rounded to five decimals; null if it is unknown. */
static json_t *ratio_figure(double value, bool known)
{
    return known ? json_real(round(value * 1e5) / 1e5) : json_null();
}

static json_t *ratio_json(const struct pen_confidence *ratio)
{
    return json_pack("{s:o, s:o, s:o, s:i, s:i}", "median", ratio_figure(ratio->median, true),
                     "low", ratio_figure(ratio->low, ratio->bounded), "high",
                     ratio_figure(ratio->high, ratio->bounded), "pairs", ratio->count, "spoiled",
                     ratio->spoiled);
}

/* The ratio and verdict of the baseline's twin; null if there is none. */
static json_t *noise_json(const struct pen_bench_result *result)
{
    const struct pen_confidence *ratio = &result->twin.ratio;
    if (!result->twin.runs)
        return json_null();
    json_t *noise = ratio_json(ratio);
    noise = pen_json_with(noise, "half_width",
                          ratio_figure((ratio->high - ratio->low) / 2, ratio->bounded));
    noise = pen_json_with(noise, "verdict", json_string(pen_verdict_name(result->twin.verdict)));
    return pen_json_with(noise, "runs_ms", runs_json(&result->twin, result->repeats));
}

/* The times of a row. */
static json_t *times_json(const struct pen_bench *bench, int row,
                          const struct pen_bench_row_result *out, int repeats)
{
    return json_pack("{s:i, s:O, s:i, s:o, s:o, s:o, s:o, s:o, s:s, s:s, s:o, s:o, s:o, s:o, s:o, "
                     "s:o, s:o}",
                     "row", row, "settings", bench->rows[row].varied, "threads", out->stats.threads,
                     "median_ms", pen_figure(out->median_ms), "min_ms", pen_figure(out->min_ms),
                     "max_ms", pen_figure(out->max_ms), "speedup", pen_figure(out->speedup),
                     "ratio", row == bench->baseline ? json_null() : ratio_json(&out->ratio),
                     "verdict", pen_verdict_name(out->verdict), "reason", out->reason, "runs_ms",
                     runs_json(out, repeats), "spoiled_runs", spoiled_json(out, repeats),
                     "cpu_share", pen_figure(out->used), "steal_ms", steal_json(out, repeats),
                     "build_ms", pen_figure(out->build_ms), "render_ms", pen_figure(out->render_ms),
                     "cpu_ms", pen_figure(out->cpu_ms));
}

/* The work of a row, and its picture. */
static json_t *work_json(const struct pen_bench_row_result *out)
{
    const struct pen_render_stats *s = &out->stats;
    return json_pack(
        "{s:o, s:{s:I, s:I}, s:o, s:o, s:s, s:o, s:I, s:I, s:I, s:o, s:i, s:i, s:b, s:f, s:f}",
        "rays", pen_figure_rays(&s->rays), "tests", "boxes", (json_int_t)s->tests.boxes,
        "primitives", (json_int_t)s->tests.primitives, "mrays_per_second",
        pen_figure_rate(&s->rays, out->render_ms), "accelerator",
        pen_figure_accelerator(&out->accel, s), "kernel", s->kernel, "effects",
        pen_figure_effects(s->effects), "dropped_samples", (json_int_t)s->rays.dropped_samples,
        "truncated_paths", (json_int_t)s->rays.truncated_paths, "unmatched_exits",
        (json_int_t)s->rays.unmatched_exits, "picture_hash",
        pen_report_hash_json(out->picture_hash), "same_as", out->same_as, "compared_with",
        out->compared_with, "identical", out->identical, "max_difference", out->max_difference,
        "rmse", out->rmse);
}

static json_t *rows_json(const struct pen_bench *bench, const struct pen_bench_result *result)
{
    json_t *list = json_array();
    for (int row = 0; row < bench->row_count; row++) {
        const struct pen_bench_row_result *out = &result->rows[row];
        json_array_append_new(
            list, pen_joined_json(times_json(bench, row, out, result->repeats), work_json(out)));
    }
    return pen_json_all(list, (size_t)bench->row_count);
}

static json_t *load_json(double load)
{
    return load < 0 ? json_null() : pen_figure(load);
}

/* The method: what was requested, and what happened. */
static json_t *method_json(const struct pen_bench *bench, const struct pen_bench_result *result)
{
    static const char *const ends[] = {"repeats", "interval", "budget"};
    const bool asked = bench->interval > 0;
    const struct pen_confidence *c = &result->calibration;
    return json_pack("{s:i, s:i, s:i, s:o, s:o, s:f, s:I, s:s, s:o, s:{s:o, s:o, s:o}}", "repeats",
                     result->repeats, "warmup", bench->warmup, "baseline", bench->baseline,
                     "interval", asked ? json_real(bench->interval) : json_null(), "budget_seconds",
                     asked ? json_real(bench->budget_ms / 1000) : json_null(), "least_effect",
                     bench->least_effect, "order_seed", (json_int_t)bench->order_seed, "ended_by",
                     ends[result->end], "noise", noise_json(result), "calibration", "median_ms",
                     pen_figure(c->median), "low_ms", c->bounded ? pen_figure(c->low) : json_null(),
                     "high_ms", c->bounded ? pen_figure(c->high) : json_null());
}

json_t *pen_bench_report_new(const struct pen_bench *bench, const struct pen_bench_result *result,
                             json_t *head)
{
    json_t *rest = json_pack(
        "{s:o, s:o, s:o, s:i, s:{s:o, s:o}, s:o, s:o}", "rows", rows_json(bench, result), "notes",
        notes_json(bench, result), "host", pen_host_json(), "pool_threads",
        pen_thread_pool_size(bench->frame.pool), "load_average", "before",
        load_json(result->load_before), "after", load_json(result->load_after), "began_at",
        pen_report_time_json(result->began_ms), "ended_at", pen_report_time_json(result->ended_ms));
    return pen_joined_json(pen_joined_json(head, method_json(bench, result)), rest);
}
