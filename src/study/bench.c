/* SPDX-License-Identifier: MIT */
/* The order of runs, and the clock around each. Nothing but freezing and rendering happens while a
 * run is timed: pictures are compared, and progress is told, between runs. */
#include "study/bench.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "study/internal/compare.h"

struct state {
    const struct pen_bench *bench;
    struct pen_bench_result *result;
    struct pen_gallery *gallery;
    double *tile_ms; /* of the baseline's last counted run */
    int done, total;
};

/* A run as it came out. */
struct run {
    double build_ms;
    struct pen_render_stats stats; /* in: tests_counted, whether to count */
    struct pen_accel_stats accel;
    double *tile_ms; /* in: where the times of tiles go, one view behind the other; NULL: nowhere */
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
    sum->rays.primary += view->rays.primary;
    sum->rays.shadow += view->rays.shadow;
    sum->rays.reflection += view->rays.reflection;
    sum->rays.transmission += view->rays.transmission;
    sum->rays.dropped_samples += view->rays.dropped_samples;
    sum->tests_counted = view->tests_counted;
    sum->tests.boxes += view->tests.boxes;
    sum->tests.primitives += view->tests.primitives;
    sum->tile_count += view->tile_count;
    sum->kernel = view->kernel;
    sum->effects |= view->effects;
}

/* Renders all views of a frozen scene; the pictures are left in the gallery's hands. */
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
                                       .rgb = pen_gallery_canvas(state->gallery, i),
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

/* One run: what it took, and its pictures. */
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

static void tell(struct state *state)
{
    if (state->bench->progress)
        state->bench->progress(state->bench->user, state->done, state->total);
}

/* Makes a run of a row and looks at its pictures. */
static bool run_row(struct state *state, int row, struct run *run, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    bool ok = make_run(state, &bench->rows[row].settings, run, st);
    for (int i = 0; ok && bench->tamper && i < bench->view_count; i++)
        bench->tamper(bench->user, row, i, pen_gallery_canvas(state->gallery, i));
    if (!ok || !pen_gallery_hang(state->gallery, row, st))
        return false;
    state->done++;
    tell(state);
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

static void note_run(struct state *state, int row, int turn, const struct run *run)
{
    struct pen_bench_outcome *out = &state->result->rows[row];
    out->laps[turn] =
        (struct pen_bench_lap){run->build_ms, run->stats.render_ms, run->stats.cpu_ms};
    out->stats = run->stats;
    out->accel = run->accel;
}

static bool run_all(struct state *state, struct pen_status *st)
{
    for (int turn = 0; turn < state->bench->repeats; turn++) {
        for (int row = 0; row < state->bench->row_count; row++) {
            struct run run = {.tile_ms = row == state->bench->baseline ? state->tile_ms : NULL};
            if (!run_row(state, row, &run, st))
                return false;
            note_run(state, row, turn, &run);
        }
    }
    return true;
}

/* The row whose tests stand for those of `row`: threads and tiles do not change them. */
static int counted_with(const struct pen_bench *bench, int row)
{
    int first = 0;
    while (!pen_rows_same_work(&bench->rows[first], &bench->rows[row]))
        first++;
    return first;
}

int pen_bench_runs(const struct pen_bench *bench)
{
    int runs = bench->row_count * (bench->warmup + bench->repeats);
    for (int row = 0; row < bench->row_count; row++)
        runs += counted_with(bench, row) == row;
    return runs;
}

/* Counts with all threads: the counts are the same for any number, and it is sooner done. */
static bool count_tests(struct state *state, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    for (int row = 0; row < bench->row_count; row++) {
        struct pen_render_stats *stats = &state->result->rows[row].stats;
        int first = counted_with(bench, row);
        if (first < row) {
            stats->tests = state->result->rows[first].stats.tests;
        } else {
            struct pen_settings settings = bench->rows[row].settings;
            struct run run = {.stats.tests_counted = true};
            settings.threads = 0;
            if (!make_run(state, &settings, &run, st) || !pen_gallery_hang(state->gallery, row, st))
                return false;
            stats->tests = run.stats.tests;
            state->done++;
            tell(state);
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

/* Of one part of a row's laps: their median, least and largest. */
struct spread {
    double median, min, max;
};

static double total_of(const struct pen_bench_lap *lap)
{
    return lap->build_ms + lap->render_ms;
}

static double build_of(const struct pen_bench_lap *lap)
{
    return lap->build_ms;
}

static double render_of(const struct pen_bench_lap *lap)
{
    return lap->render_ms;
}

static double cpu_of(const struct pen_bench_lap *lap)
{
    return lap->cpu_ms;
}

/* `values` has room for `count` of them. */
static struct spread spread_of(const struct pen_bench_lap *laps, int count,
                               double (*part)(const struct pen_bench_lap *), double *values)
{
    for (int i = 0; i < count; i++)
        values[i] = part(&laps[i]);
    qsort(values, (size_t)count, sizeof *values, by_value);
    return (struct spread){(values[(count - 1) / 2] + values[count / 2]) / 2, values[0],
                           values[count - 1]};
}

static void sum_up_row(struct pen_bench_outcome *row, int count, double *values)
{
    struct spread total = spread_of(row->laps, count, total_of, values);
    row->median_ms = total.median;
    row->min_ms = total.min;
    row->max_ms = total.max;
    row->build_ms = spread_of(row->laps, count, build_of, values).median;
    row->render_ms = spread_of(row->laps, count, render_of, values).median;
    row->cpu_ms = spread_of(row->laps, count, cpu_of, values).median;
}

static bool sum_up(struct state *state, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    struct pen_bench_outcome *rows = state->result->rows;
    double *values = malloc((size_t)bench->repeats * sizeof *values);
    if (!values)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the medians");
    for (int row = 0; row < bench->row_count; row++)
        sum_up_row(&rows[row], bench->repeats, values);
    free(values);
    rows[bench->baseline].stats.tile_ms = state->tile_ms;
    state->tile_ms = NULL;
    for (int row = 0; row < bench->row_count; row++) {
        rows[row].speedup = rows[bench->baseline].median_ms / rows[row].median_ms;
        if (!pen_gallery_compare(state->gallery, row, &rows[row], st))
            return false;
    }
    return true;
}

/* Of all views of a row. */
static size_t tiles_of(const struct pen_bench *bench, int row)
{
    const struct pen_settings *s = &bench->rows[row].settings;
    return (size_t)pen_tile_count(s->width, s->height, s->tile) * (size_t)bench->view_count;
}

static bool make_room(struct state *state, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    size_t rows = (size_t)bench->row_count;
    struct pen_bench_outcome *outcomes = calloc(rows, sizeof *outcomes);
    state->result->rows = outcomes;
    bool ok = outcomes != NULL;
    for (size_t i = 0; ok && i < rows; i++) {
        outcomes[i].laps = calloc((size_t)bench->repeats, sizeof *outcomes[i].laps);
        ok = outcomes[i].laps != NULL;
    }
    state->gallery = ok ? pen_gallery_new(bench) : NULL;
    state->tile_ms = calloc(tiles_of(bench, bench->baseline), sizeof *state->tile_ms);
    return (state->gallery && state->tile_ms) ||
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
    bool ok = make_room(&state, st);
    if (ok)
        tell(&state);
    ok = ok && warm_up(&state, st) && run_all(&state, st) && count_tests(&state, st) &&
         sum_up(&state, st);
    result->load_after = load_average();
    result->ended_ms = pen_clock_wall_ms();
    pen_gallery_free(state.gallery);
    free(state.tile_ms);
    return ok;
}

void pen_bench_result_release(const struct pen_bench *bench, struct pen_bench_result *result)
{
    for (int row = 0; result->rows && row < bench->row_count; row++) {
        free(result->rows[row].laps);
        free(result->rows[row].stats.tile_ms);
    }
    free(result->rows);
    *result = (struct pen_bench_result){0};
}
