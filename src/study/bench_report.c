/* SPDX-License-Identifier: MIT */
/* The report of a benchmark as JSON; all other formats are made from it. */
#include "base/clock.h"
#include "base/cpu.h"
#include "io/figures.h"
#include "study/bench.h"

/* Takes the reference to `text`. Returns false when out of memory. */
static bool add_note(json_t *notes, json_t *text)
{
    return json_array_append_new(notes, text) == 0;
}

/* Notes if fewer threads worked on a row than it requests. */
static bool note_threads(const struct pen_bench *bench, const struct pen_bench_result *result,
                         int row, json_t *notes)
{
    int requested = bench->rows[row].settings.threads, pool = pen_thread_pool_size(bench->pool);
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
                                        "%.2f on %d cores; ratios say more than times",
                                        result->load_before, pen_cpu_count()));
}

static json_t *notes_json(const struct pen_bench *bench, const struct pen_bench_result *result)
{
    json_t *notes = json_array();
    bool ok = notes && note_load(result, notes);
    for (int row = 0; ok && row < bench->row_count; row++)
        ok = note_threads(bench, result, row, notes);
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
        if (json_array_append_new(list, pen_figure(run->build_ms + run->render_ms)) != 0) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

static json_t *row_json(const struct pen_bench *bench, int row,
                        const struct pen_bench_row_result *out)
{
    const struct pen_render_stats *s = &out->stats;
    json_t *times =
        json_pack("{s:i, s:O, s:i, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "row", row, "settings",
                  bench->rows[row].varied, "threads", s->threads, "median_ms",
                  pen_figure(out->median_ms), "min_ms", pen_figure(out->min_ms), "max_ms",
                  pen_figure(out->max_ms), "speedup", pen_figure(out->speedup), "runs_ms",
                  runs_json(out, bench->repeats), "build_ms", pen_figure(out->build_ms),
                  "render_ms", pen_figure(out->render_ms), "cpu_ms", pen_figure(out->cpu_ms));
    json_t *rest = json_pack(
        "{s:o, s:o, s:o, s:s, s:o, s:I, s:I, s:I, s:i, s:i, s:b, s:f, s:f}", "rays",
        pen_figure_rays(&s->rays), "mrays_per_second", pen_figure_rate(&s->rays, out->render_ms),
        "accelerator", pen_figure_accelerator(&out->accel, s), "kernel", s->kernel, "effects",
        pen_figure_effects(s->effects), "dropped_samples", (json_int_t)s->rays.dropped_samples,
        "truncated_paths", (json_int_t)s->rays.truncated_paths, "unmatched_exits",
        (json_int_t)s->rays.unmatched_exits, "same_as", out->same_as, "compared_with",
        out->compared_with, "identical", out->identical, "max_difference", out->max_difference,
        "rmse", out->rmse);
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
        if (json_array_append_new(list, row_json(bench, row, &result->rows[row])) != 0) {
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

json_t *pen_bench_report_new(const struct pen_bench *bench, const struct pen_bench_result *result,
                             json_t *head)
{
    json_t *rest = json_pack(
        "{s:i, s:i, s:i, s:o, s:o, s:o, s:i, s:{s:o, s:o}, s:o, s:o}", "repeats", bench->repeats,
        "warmup", bench->warmup, "baseline", bench->baseline, "rows", rows_json(bench, result),
        "notes", notes_json(bench, result), "host", pen_figure_host(), "pool_threads",
        pen_thread_pool_size(bench->pool), "load_average", "before", load_json(result->load_before),
        "after", load_json(result->load_after), "began_at", time_json(result->began_ms), "ended_at",
        time_json(result->ended_ms));
    if (head && rest && json_object_update(head, rest) == 0) {
        json_decref(rest);
        return head;
    }
    json_decref(head);
    json_decref(rest);
    return NULL;
}
