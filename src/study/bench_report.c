/* SPDX-License-Identifier: MIT */
/* The report of a benchmark as JSON; all other formats are made from it. */
#include <inttypes.h>
#include <math.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "io/figures.h"
#include "io/json_build.h"
#include "study/bench.h"
#include "study/host.h"

/* Takes the reference to `text`. Returns false when out of memory. */
static bool add_note(json_t *notes, json_t *text)
{
    return json_array_append_new(notes, text) == 0;
}

/* Notes if fewer threads worked on a row than it requests. */
static bool note_threads(const struct pen_bench *bench, const struct pen_bench_result *result,
                         int row, json_t *notes)
{
    int requested = bench->rows[row].settings.threads,
        pool = pen_thread_pool_size(bench->frame.pool);
    int used = result->rows[row].stats.threads;
    int granted = requested > 0 && requested < pool ? requested : pool;
    if (requested > pool &&
        !add_note(notes, json_sprintf("row %d asks for %d threads; the pool has %d", row, requested,
                                      pool)))
        return false;
    return used == granted ||
           add_note(notes, json_sprintf("of row %d no more than %d thread%s had tiles to work on",
                                        row, used, used == 1 ? "" : "s"));
}

/* Notes if other processes kept the machine busy: that makes times longer, and ratios less so. */
static bool note_load(const struct pen_bench_result *result, json_t *notes)
{
    if (result->load_before <= 0.25 * pen_cpu_count())
        return true;
    return add_note(notes, json_sprintf("the machine was not idle at the beginning: load average "
                                        "%.2f on %d core%s; ratios say more than times",
                                        result->load_before, pen_cpu_count(),
                                        pen_cpu_count() == 1 ? "" : "s"));
}

/* Notes if runs of a row, which `name` names, are spoiled. */
static bool note_spoiled(const struct pen_bench_row_result *row, const char *name, int repeats,
                         json_t *notes)
{
    return row->spoiled == 0 ||
           add_note(notes, json_sprintf("%d of %d runs of %s are spoiled: its threads waited for "
                                        "processors; they had %.0f %% of the time that they could "
                                        "use (median)",
                                        row->spoiled, repeats, name, row->used * 100));
}

/* Notes if the runs of a row are so short that each was made several times in a row. */
static bool note_short(const struct pen_bench_row_result *row, int number, int repeats,
                       json_t *notes)
{
    int least = repeats > 0 ? row->runs[0].in_a_row : 1;
    for (int i = 1; i < repeats; i++)
        least = row->runs[i].in_a_row < least ? row->runs[i].in_a_row : least;
    return least <= 1 ||
           add_note(notes,
                    json_sprintf("a run of row %d takes less than 1 ms, so each of its times "
                                 "is the mean of at least %d in a row",
                                 number, least));
}

static bool note_rows_spoiled(const struct pen_bench *bench, const struct pen_bench_result *result,
                              json_t *notes)
{
    char name[24];
    bool ok = true;
    for (int row = 0; ok && row < bench->row_count; row++) {
        snprintf(name, sizeof name, "row %d", row);
        ok = note_spoiled(&result->rows[row], name, result->repeats, notes);
    }
    return ok && note_spoiled(&result->twin, "the baseline's twin", result->repeats, notes);
}

/* Notes why rows are undecided that have enough pairs. */
static bool note_undecided(const struct pen_bench *bench, const struct pen_bench_result *result,
                           json_t *notes)
{
    bool ok = true;
    for (int row = 0; ok && row < bench->row_count; row++) {
        const struct pen_bench_row_result *out = &result->rows[row];
        if (*out->reason && result->repeats >= PEN_PAIRS_MIN)
            ok = add_note(notes, json_sprintf("row %d is undecided: %s", row, out->reason));
    }
    return ok;
}

/* Notes what keeps verdicts from being made. */
static bool note_verdicts(const struct pen_bench *bench, const struct pen_bench_result *result,
                          json_t *notes)
{
    const enum pen_verdict twin = result->twin.verdict;
    if (bench->row_count > 1 && !result->twin.runs)
        return add_note(notes, json_sprintf("verdicts need %d pairs of runs: ask for an interval, "
                                            "or for %d repeats",
                                            PEN_PAIRS_MIN, PEN_PAIRS_MIN));
    return !result->twin.runs || twin == PEN_VERDICT_SAME || twin == PEN_VERDICT_UNDECIDED ||
           add_note(notes, json_sprintf("the baseline's twin is %s than the baseline: on this host "
                                        "these times show no smaller difference",
                                        pen_verdict_name(twin)));
}

static bool note_breaks(const struct pen_bench_result *result, json_t *notes)
{
    return result->breaks == 0 ||
           add_note(notes, json_sprintf("the benchmark was interrupted %d time%s, and went on on "
                                        "the same host; after each, one run was thrown away",
                                        result->breaks, result->breaks == 1 ? "" : "s"));
}

static json_t *notes_json(const struct pen_bench *bench, const struct pen_bench_result *result)
{
    json_t *notes = json_array();
    bool ok = notes && note_load(result, notes) && note_breaks(result, notes) &&
              note_rows_spoiled(bench, result, notes) && note_verdicts(bench, result, notes) &&
              note_undecided(bench, result, notes);
    for (int row = 0; ok && row < bench->row_count; row++)
        ok = note_short(&result->rows[row], row, result->repeats, notes) &&
             note_threads(bench, result, row, notes);
    if (ok)
        return notes;
    json_decref(notes);
    return NULL;
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

/* The time that a hypervisor gave to others during all runs; null if it is not known. */
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

/* A ratio of times, to five digits after the point; null if it is not known. */
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

/* What the baseline's twin tells: null if there is none. */
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
        json_sprintf("%016" PRIx64, out->picture_hash), "same_as", out->same_as, "compared_with",
        out->compared_with, "identical", out->identical, "max_difference", out->max_difference,
        "rmse", out->rmse);
}

static json_t *row_json(const struct pen_bench *bench, const struct pen_bench_result *result,
                        int row)
{
    const struct pen_bench_row_result *out = &result->rows[row];
    json_t *times = times_json(bench, row, out, result->repeats);
    json_t *rest = work_json(out);
    if (times && rest && json_object_update(times, rest) == 0) {
        json_decref(rest);
        return times;
    }
    json_decref(times);
    json_decref(rest);
    return NULL;
}

static json_t *rows_json(const struct pen_bench *bench, const struct pen_bench_result *result)
{
    json_t *list = json_array();
    for (int row = 0; row < bench->row_count; row++) {
        if (json_array_append_new(list, row_json(bench, result, row)) != 0) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

static json_t *time_json(int64_t wall_ms)
{
    char text[25];
    pen_clock_format(wall_ms, text);
    return json_string(text);
}

static json_t *load_json(double load)
{
    return load < 0 ? json_null() : pen_figure(load);
}

/* How it was measured: what was asked, and what came of it. */
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
    json_t *method = method_json(bench, result);
    json_t *rest =
        json_pack("{s:o, s:o, s:o, s:i, s:{s:o, s:o}, s:o, s:o}", "rows", rows_json(bench, result),
                  "notes", notes_json(bench, result), "host", pen_host_json(), "pool_threads",
                  pen_thread_pool_size(bench->frame.pool), "load_average", "before",
                  load_json(result->load_before), "after", load_json(result->load_after),
                  "began_at", time_json(result->began_ms), "ended_at", time_json(result->ended_ms));
    const bool ok = head && method && rest && json_object_update(head, method) == 0 &&
                    json_object_update(head, rest) == 0;
    json_decref(method);
    json_decref(rest);
    if (ok)
        return head;
    json_decref(head);
    return NULL;
}
