/* SPDX-License-Identifier: MIT */
/* Makes the runs in their order and times each. Nothing but freezing and rendering happens while a
 * run is timed: pictures are compared and progress is reported between runs. */
#include "study/bench.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "study/internal/pictures.h"

struct state {
    const struct pen_bench *bench;
    struct pen_bench_result *result;
    struct pen_bench_pictures *pictures;
    double *tile_ms; /* of the baseline's last repeat, one view behind the other */
    int done, total; /* runs */
};

/* A run. The caller sets stats.tests_counted to have tests counted, and tile_ms to an array to have
 * the times of tiles stored there, one view behind the other; make_run fills the rest. */
struct run {
    double build_ms;
    struct pen_render_stats stats; /* all views together */
    struct pen_accel_stats accel;
    double *tile_ms;
};

static bool cancelled(const struct pen_bench *bench)
{
    return bench->cancel && atomic_load_explicit(bench->cancel, memory_order_relaxed);
}

static void add_stats(struct pen_render_stats *sum, const struct pen_render_stats *view)
{
    sum->render_ms += view->render_ms;
    sum->cpu_ms += view->cpu_ms;
    sum->threads = view->threads > sum->threads ? view->threads : sum->threads;
    pen_ray_counts_add(&sum->rays, &view->rays);
    sum->tests_counted = view->tests_counted;
    sum->tests.boxes += view->tests.boxes;
    sum->tests.primitives += view->tests.primitives;
    sum->tile_count += view->tile_count;
    sum->kernel = view->kernel;
    sum->effects |= view->effects;
}

/* Renders all views of a frozen scene into the targets of state->pictures. */
static bool render_views(struct state *state, const struct pen_settings *settings,
                         const struct pen_scene *scene, struct run *run, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    for (int i = 0; i < bench->view_count; i++) {
        struct pen_render_stats stats;
        struct pen_render_task task = {.scene = scene,
                                       .view = bench->views[i],
                                       .settings = settings,
                                       .tile_count = -1,
                                       .rgb = pen_bench_pictures_target(state->pictures, i),
                                       .cancel = bench->cancel,
                                       .pixel_begins = bench->pixel_begins,
                                       .pixel_user = bench->pixel_user,
                                       .keep_tile_ms = run->tile_ms != NULL,
                                       .count_tests = run->stats.tests_counted};
        if (!pen_render_run(bench->pool, &task, &stats, st))
            return false;
        if (stats.tile_ms)
            memcpy(run->tile_ms + run->stats.tile_count, stats.tile_ms,
                   stats.tile_count * sizeof *stats.tile_ms);
        free(stats.tile_ms);
        add_stats(&run->stats, &stats);
    }
    return true;
}

/* Freezes the scene and renders its views under the given settings. */
static bool make_run(struct state *state, const struct pen_settings *settings, struct run *run,
                     struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    if (cancelled(bench))
        return pen_fail(st, PEN_CANCELLED, "cancelled after %d of %d runs", state->done,
                        state->total);
    int64_t begun_ns = pen_clock_ns();
    struct pen_scene *scene = pen_scene_freeze(
        bench->desc, (enum pen_accelerator)settings->accelerator, bench->scene_cap_bytes, st);
    run->build_ms = (double)(pen_clock_ns() - begun_ns) * 1e-6;
    if (!scene)
        return false;
    run->accel = *pen_accel_get_stats(scene->accel);
    bool ok = render_views(state, settings, scene, run, st);
    pen_scene_free(scene);
    return ok;
}

static void report_progress(struct state *state)
{
    if (state->bench->progress)
        state->bench->progress(state->bench->user, state->done, state->total);
}

/* Makes a run of a row and checks its pictures. */
static bool run_row(struct state *state, int row, struct run *run, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    bool ok = make_run(state, &bench->rows[row].settings, run, st);
    for (int i = 0; ok && bench->tamper && i < bench->view_count; i++)
        bench->tamper(bench->user, row, i, pen_bench_pictures_target(state->pictures, i));
    if (!ok || !pen_bench_pictures_check(state->pictures, row, st))
        return false;
    state->done++;
    report_progress(state);
    return true;
}

static bool warm_up(struct state *state, struct pen_status *st)
{
    for (int i = 0; i < state->bench->warmup; i++) {
        for (int row = 0; row < state->bench->row_count; row++) {
            struct run run = {0};
            if (!run_row(state, row, &run, st))
                return false;
        }
    }
    return true;
}

static void record_run(struct state *state, int row, int repeat, const struct run *run)
{
    struct pen_bench_row_result *out = &state->result->rows[row];
    out->runs[repeat] = (struct pen_bench_times){
        .build_ms = run->build_ms, .render_ms = run->stats.render_ms, .cpu_ms = run->stats.cpu_ms};
    out->stats = run->stats;
    out->accel = run->accel;
}

static bool repeat_runs(struct state *state, struct pen_status *st)
{
    for (int repeat = 0; repeat < state->bench->repeats; repeat++) {
        for (int row = 0; row < state->bench->row_count; row++) {
            struct run run = {.tile_ms = row == state->bench->baseline ? state->tile_ms : NULL};
            if (!run_row(state, row, &run, st))
                return false;
            record_run(state, row, repeat, &run);
        }
    }
    return true;
}

/* The first row whose test counts are those of `row` too. */
static int first_with_same_work(const struct pen_bench *bench, int row)
{
    int first = 0;
    while (!pen_bench_rows_same_work(&bench->rows[first], &bench->rows[row]))
        first++;
    return first;
}

int pen_bench_runs(const struct pen_bench *bench)
{
    int runs = bench->row_count * (bench->warmup + bench->repeats);
    for (int row = 0; row < bench->row_count; row++)
        runs += first_with_same_work(bench, row) == row;
    return runs;
}

/* Counts the tests of each row's work once. Uses all threads, which is quicker: the counts are the
 * same for any number of threads. */
static bool count_tests(struct state *state, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    for (int row = 0; row < bench->row_count; row++) {
        struct pen_render_stats *stats = &state->result->rows[row].stats;
        int first = first_with_same_work(bench, row);
        if (first < row) {
            stats->tests = state->result->rows[first].stats.tests;
        } else {
            struct pen_settings settings = bench->rows[row].settings;
            struct run run = {.stats.tests_counted = true};
            settings.threads = 0;
            if (!make_run(state, &settings, &run, st) ||
                !pen_bench_pictures_check(state->pictures, row, st))
                return false;
            stats->tests = run.stats.tests;
            state->done++;
            report_progress(state);
        }
        stats->tests_counted = true;
    }
    return true;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct spread {
    double median, min, max;
};

static double total_of(const struct pen_bench_times *run)
{
    return run->build_ms + run->render_ms;
}

static double build_of(const struct pen_bench_times *run)
{
    return run->build_ms;
}

static double render_of(const struct pen_bench_times *run)
{
    return run->render_ms;
}

static double cpu_of(const struct pen_bench_times *run)
{
    return run->cpu_ms;
}

/* The spread of one part of a row's times. `values` is scratch space for `count` numbers. */
static struct spread spread_of(const struct pen_bench_times *runs, int count,
                               double (*part)(const struct pen_bench_times *), double *values)
{
    for (int i = 0; i < count; i++)
        values[i] = part(&runs[i]);
    qsort(values, (size_t)count, sizeof *values, by_value);
    return (struct spread){.median = (values[(count - 1) / 2] + values[count / 2]) / 2,
                           .min = values[0],
                           .max = values[count - 1]};
}

static void summarize_row(struct pen_bench_row_result *row, int count, double *values)
{
    struct spread total = spread_of(row->runs, count, total_of, values);
    row->median_ms = total.median;
    row->min_ms = total.min;
    row->max_ms = total.max;
    row->build_ms = spread_of(row->runs, count, build_of, values).median;
    row->render_ms = spread_of(row->runs, count, render_of, values).median;
    row->cpu_ms = spread_of(row->runs, count, cpu_of, values).median;
}

static bool summarize(struct state *state, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    struct pen_bench_row_result *rows = state->result->rows;
    double *values = malloc((size_t)bench->repeats * sizeof *values);
    if (!values)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the medians");
    for (int row = 0; row < bench->row_count; row++)
        summarize_row(&rows[row], bench->repeats, values);
    free(values);
    rows[bench->baseline].stats.tile_ms = state->tile_ms;
    state->tile_ms = NULL;
    for (int row = 0; row < bench->row_count; row++) {
        rows[row].speedup = rows[bench->baseline].median_ms / rows[row].median_ms;
        if (!pen_bench_pictures_measure(state->pictures, row, &rows[row], st))
            return false;
    }
    return true;
}

/* The tiles of all views of a row. */
static size_t row_tile_count(const struct pen_bench *bench, int row)
{
    const struct pen_settings *s = &bench->rows[row].settings;
    return (size_t)pen_tile_count(s->width, s->height, s->tile) * (size_t)bench->view_count;
}

static bool allocate(struct state *state, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    size_t rows = (size_t)bench->row_count;
    struct pen_bench_row_result *results = calloc(rows, sizeof *results);
    state->result->rows = results;
    bool ok = results != NULL;
    for (size_t i = 0; ok && i < rows; i++) {
        results[i].runs = calloc((size_t)bench->repeats, sizeof *results[i].runs);
        ok = results[i].runs != NULL;
    }
    state->pictures = ok ? pen_bench_pictures_new(bench) : NULL;
    state->tile_ms = calloc(row_tile_count(bench, bench->baseline), sizeof *state->tile_ms);
    return (state->pictures && state->tile_ms) ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for a benchmark of %zu rows", rows);
}

static double load_average(void)
{
    double load;
    return getloadavg(&load, 1) == 1 ? load : -1;
}

bool pen_bench_run(const struct pen_bench *bench, struct pen_bench_result *result,
                   struct pen_status *st)
{
    struct state state = {.bench = bench, .result = result, .total = pen_bench_runs(bench)};
    *result =
        (struct pen_bench_result){.load_before = load_average(), .began_ms = pen_clock_wall_ms()};
    bool ok = allocate(&state, st);
    if (ok)
        report_progress(&state);
    ok = ok && warm_up(&state, st) && repeat_runs(&state, st) && count_tests(&state, st) &&
         summarize(&state, st);
    result->load_after = load_average();
    result->ended_ms = pen_clock_wall_ms();
    pen_bench_pictures_free(state.pictures);
    free(state.tile_ms);
    return ok;
}

void pen_bench_result_release(const struct pen_bench *bench, struct pen_bench_result *result)
{
    for (int row = 0; result->rows && row < bench->row_count; row++) {
        free(result->rows[row].runs);
        free(result->rows[row].stats.tile_ms);
    }
    free(result->rows);
    *result = (struct pen_bench_result){0};
}
