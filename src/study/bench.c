/* SPDX-License-Identifier: MIT */
/* Makes the runs in their order, and decides when to stop. Pictures are compared, calibrations are
 * made and progress is reported between runs, never while a run is timed. */
#include "study/bench.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "study/internal/bench_run.h"
#include "study/internal/bench_state.h"
#include "study/internal/bench_summary.h"
#include "study/internal/calibration.h"
#include "study/internal/pictures.h"
#include "study/internal/random_order.h"

/* Keeps the hash of a row's kind of pictures. It must equal the hash that an earlier process saved.
 */
static bool check_hash(struct pen_bench_state *state, int row, struct pen_status *st)
{
    const int first = pen_bench_pictures_first(state->bench, row);
    uint64_t *kept = &state->result->rows[first].picture_hash;
    if (state->hashed[first])
        return true;
    const uint64_t hash = pen_bench_pictures_hash(state->pictures, first);
    if (*kept != 0 && *kept != hash)
        return pen_fail(st, PEN_DIFFERENT,
                        "the pictures of row %d must be the same in all runs, but differ from "
                        "those before the benchmark was interrupted",
                        row);
    *kept = hash;
    state->hashed[first] = true;
    return true;
}

/* Makes a run of a row and checks its pictures. run->settings may differ from the row's settings if
 * the picture stays the same. */
static bool run_row(struct pen_bench_state *state, int row, struct pen_bench_run *run,
                    struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    if (!pen_making_check(&state->making, st))
        return false;
    run->bench = bench;
    run->pictures = state->pictures;
    run->row = row;
    if (!run->settings)
        run->settings = &bench->rows[row].settings;
    bool ok = pen_bench_run_once(run, st);
    const bool timed = !run->stats.tests_counted;
    for (int i = 0; ok && timed && bench->tamper && i < bench->view_count; i++)
        bench->tamper(bench->frame.user, row, i, pen_bench_pictures_target(state->pictures, i));
    return ok && pen_bench_pictures_check(state->pictures, row, st) && check_hash(state, row, st);
}

bool pen_bench_has_twin(const struct pen_bench *bench)
{
    return bench->interval > 0 || bench->repeats >= PEN_PAIRS_MIN;
}

/* The number of runs of a pass. */
static int slots_of(const struct pen_bench *bench)
{
    return bench->row_count + pen_bench_has_twin(bench);
}

/* The greatest possible number of repeats. */
static int repeats_max(const struct pen_bench *bench)
{
    return bench->interval > 0 ? PEN_PAIRS_MAX : bench->repeats;
}

/* Draws the order of the next pass from order_seed and the number of the pass. So every process
 * draws the same order for it. */
static void draw_order(struct pen_bench_state *state)
{
    uint64_t random = state->bench->order_seed + (uint64_t)state->passes * 0x632be59bd9b4e019u;
    pen_random_order(state->order, state->making.rows, &random);
}

static void record_run(struct pen_bench_state *state, int slot, int repeat,
                       const struct pen_bench_run *run)
{
    struct pen_bench_result *result = state->result;
    const bool twin = slot == state->bench->row_count;
    struct pen_bench_row_result *out = twin ? &result->twin : &result->rows[slot];
    const double calibration_ms = out->runs[repeat].calibration_ms;
    out->runs[repeat] = run->times;
    out->runs[repeat].calibration_ms = calibration_ms;
    out->stats = run->stats;
    out->accel = run->accel;
}

static bool out_of_budget(const struct pen_bench_state *state)
{
    const struct pen_bench *bench = state->bench;
    return bench->interval > 0 && state->result->repeats > 0 &&
           pen_making_spent_ms(&state->making) >= bench->budget_ms;
}

/* Makes the run of one slot. repeat -1: warm-up. */
static bool run_slot(struct pen_bench_state *state, int slot, int repeat, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    const bool keep = repeat >= 0 && slot == bench->baseline;
    struct pen_bench_run run = {.tile_ms = keep ? state->tile_ms : NULL};
    if (!run_row(state, slot < bench->row_count ? slot : bench->baseline, &run, st))
        return false;
    if (repeat >= 0)
        record_run(state, slot, repeat, &run);
    return true;
}

/* Visits every slot once, except those that an earlier process visited. If `repeat` is 0 or more,
 * records the times as those of that repeat. When the budget ends within a repeat, the repeat stops
 * and does not count. */
static bool make_pass(struct pen_bench_state *state, int repeat, struct pen_status *st)
{
    draw_order(state);
    if (repeat >= 0 && state->place == 0)
        state->result->rows[0].runs[repeat].calibration_ms = pen_calibration_run();
    while (state->place < state->making.rows) {
        if (repeat >= 0 && out_of_budget(state))
            return true;
        if (!run_slot(state, state->order[state->place], repeat, st))
            return false;
        if (++state->place == state->making.rows) {
            state->place = 0;
            state->passes++;
            state->result->repeats = repeat + 1;
            return pen_making_end_run(&state->making, st);
        }
        if (!pen_making_end_run(&state->making, st))
            return false;
    }
    return true;
}

static bool warm_up(struct pen_bench_state *state, struct pen_status *st)
{
    bool ok = true;
    while (ok && state->passes < state->bench->warmup)
        ok = make_pass(state, -1, st);
    return ok;
}

/* Sets the total of runs: for warm-up, this number of repeats, and counting tests. */
static void set_total(struct pen_bench_state *state, int repeats)
{
    const struct pen_bench *bench = state->bench;
    state->making.total = state->making.rows * (bench->warmup + repeats) + state->counting;
}

/* Makes passes until there are this many repeats, or the budget ends. */
static bool repeat_to(struct pen_bench_state *state, int repeats, struct pen_status *st)
{
    bool ok = true;
    set_total(state, repeats);
    while (ok && state->result->repeats < repeats && !out_of_budget(state))
        ok = make_pass(state, state->result->repeats, st);
    return ok;
}

static bool repeat_runs(struct pen_bench_state *state, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    struct pen_bench_result *result = state->result;
    if (!(bench->interval > 0))
        return repeat_to(state, bench->repeats, st);
    int pairs = PEN_PAIRS_MIN;
    while (pairs < result->repeats) /* an earlier process has looked at these */
        pairs *= 2;
    for (; pairs <= PEN_PAIRS_MAX; pairs *= 2) {
        if (!repeat_to(state, pairs, st))
            return false;
        pen_bench_find_ratios(bench, result, state->values);
        if (pen_bench_narrow(bench, result)) {
            result->end = PEN_BENCH_END_INTERVAL;
            break;
        }
        if (result->repeats < pairs) {
            result->end = PEN_BENCH_END_BUDGET;
            break;
        }
    }
    return true;
}

/* The first row that has the same test counts as `row`. */
static int first_with_same_work(const struct pen_bench *bench, int row)
{
    int first = 0;
    while (!pen_bench_rows_same_work(&bench->rows[first], &bench->rows[row]))
        first++;
    return first;
}

static int counting_runs(const struct pen_bench *bench)
{
    int runs = 0;
    for (int row = 0; row < bench->row_count; row++)
        runs += first_with_same_work(bench, row) == row;
    return runs;
}

int pen_bench_runs(const struct pen_bench *bench)
{
    return slots_of(bench) * (bench->warmup + repeats_max(bench)) + counting_runs(bench);
}

/* Takes the statistics of a run for a row, if this process made no other run of the row but an
 * earlier process did. */
static void take_stats(struct pen_bench_row_result *row, const struct pen_render_stats *stats,
                       const struct pen_accel_stats *accel)
{
    const int threads = row->stats.threads;
    if (row->stats.kernel)
        return;
    row->stats = *stats;
    row->stats.tile_ms = NULL;
    row->stats.threads = threads;
    row->accel = *accel;
}

/* Makes a run that counts the tests of a row. It uses all threads, since the counts do not depend
 * on their number. */
static bool count_row(struct pen_bench_state *state, int row, struct pen_status *st)
{
    struct pen_bench_row_result *out = &state->result->rows[row];
    struct pen_settings settings = state->bench->rows[row].settings;
    struct pen_bench_run run = {.settings = &settings, .stats.tests_counted = true};
    settings.threads = 0;
    if (!run_row(state, row, &run, st) || !pen_making_end_run(&state->making, st))
        return false;
    take_stats(out, &run.stats, &run.accel);
    out->stats.tests = run.stats.tests;
    return true;
}

/* Counts tests once for all rows that do the same work. */
static bool count_tests(struct pen_bench_state *state, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    struct pen_bench_row_result *rows = state->result->rows;
    state->making.total = state->making.done + state->counting;
    for (int row = 0; row < bench->row_count; row++) {
        const int first = first_with_same_work(bench, row);
        if (first == row && !count_row(state, row, st))
            return false;
        take_stats(&rows[row], &rows[first].stats, &rows[first].accel);
        rows[row].stats.tests = rows[first].stats.tests;
        rows[row].stats.tests_counted = true;
    }
    return true;
}

/* Makes the first run of a process that resumed the benchmark. Its time is discarded. It is a run
 * of the baseline, because the times of the baseline's tiles are not saved. */
static bool go_on(struct pen_bench_state *state, struct pen_status *st)
{
    const int baseline = state->bench->baseline;
    struct pen_bench_run run = {.tile_ms = state->tile_ms};
    if (!run_row(state, baseline, &run, st))
        return false;
    take_stats(&state->result->rows[baseline], &run.stats, &run.accel);
    return true;
}

static bool summarize(struct pen_bench_state *state, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    struct pen_bench_row_result *rows = state->result->rows;
    pen_bench_summarize(bench, state->result, state->values);
    rows[bench->baseline].stats.tile_ms = state->tile_ms;
    state->tile_ms = NULL;
    for (int row = 0; row < bench->row_count; row++) {
        if (!pen_bench_pictures_measure(state->pictures, row, &rows[row], st))
            return false;
    }
    pen_bench_judge(bench, state->result);
    return true;
}

/* The number of tiles of all views of a row. */
static size_t row_tile_count(const struct pen_bench *bench, int row)
{
    const struct pen_settings *s = &bench->rows[row].settings;
    return (size_t)pen_tile_count(s->width, s->height, s->tile) * (size_t)bench->view_count;
}

static bool allocate_runs(struct pen_bench_row_result *row, int repeats)
{
    row->runs = calloc((size_t)repeats, sizeof *row->runs);
    return row->runs != NULL;
}

static bool allocate(struct pen_bench_state *state, struct pen_status *st)
{
    const struct pen_bench *bench = state->bench;
    struct pen_bench_result *result = state->result;
    const size_t rows = (size_t)bench->row_count;
    const int repeats = state->repeats_max;
    result->rows = calloc(rows, sizeof *result->rows);
    bool ok = result->rows != NULL;
    for (size_t i = 0; ok && i < rows; i++)
        ok = allocate_runs(&result->rows[i], repeats);
    if (ok && pen_bench_has_twin(bench))
        ok = allocate_runs(&result->twin, repeats);
    state->pictures = ok ? pen_bench_pictures_new(bench) : NULL;
    state->tile_ms = calloc(row_tile_count(bench, bench->baseline), sizeof *state->tile_ms);
    state->values = calloc((size_t)repeats, sizeof *state->values);
    state->order = calloc((size_t)state->making.rows, sizeof *state->order);
    state->hashed = calloc(rows, sizeof *state->hashed);
    return (state->pictures && state->tile_ms && state->values && state->order && state->hashed) ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for a benchmark of %zu rows", rows);
}

static double load_average(void)
{
    double load;
    return getloadavg(&load, 1) == 1 ? load : -1;
}

static void release(struct pen_bench_state *state)
{
    pen_bench_pictures_free(state->pictures);
    pen_making_end(&state->making);
    free(state->tile_ms);
    free(state->values);
    free(state->order);
    free(state->hashed);
}

/* Resumes a benchmark that an earlier process saved, if its state is valid. */
static bool begin(struct pen_bench_state *state, struct pen_status *st)
{
    if (!pen_making_resume(&state->making))
        return true;
    state->result->repeats = pen_bench_repeats(state);
    state->making.done = state->passes * state->making.rows + state->place;
    return go_on(state, st);
}

bool pen_bench_run(const struct pen_bench *bench, struct pen_bench_result *result,
                   struct pen_status *st)
{
    struct pen_bench_state state = {.making = {.frame = &bench->frame,
                                               .shape = &pen_bench_shape,
                                               .study = &state,
                                               .rows = slots_of(bench)},
                                    .bench = bench,
                                    .result = result,
                                    .repeats_max = repeats_max(bench),
                                    .counting = counting_runs(bench),
                                    .order_seed = bench->order_seed,
                                    .warmup = (uint64_t)bench->warmup,
                                    .load_before = load_average()};
    *result = (struct pen_bench_result){0};
    set_total(&state, bench->interval > 0 ? PEN_PAIRS_MIN : bench->repeats);
    const bool ok = pen_making_begin(&state.making, st) && allocate(&state, st) &&
                    begin(&state, st) && warm_up(&state, st) && repeat_runs(&state, st) &&
                    count_tests(&state, st) && summarize(&state, st);
    result->breaks = state.making.breaks;
    result->load_before = state.load_before;
    result->load_after = load_average();
    result->began_ms = state.making.began_ms;
    result->ended_ms = pen_clock_wall_ms();
    release(&state);
    return ok;
}

void pen_bench_result_release(const struct pen_bench *bench, struct pen_bench_result *result)
{
    for (int row = 0; result->rows && row < bench->row_count; row++) {
        free(result->rows[row].runs);
        free(result->rows[row].stats.tile_ms);
    }
    free(result->rows);
    free(result->twin.runs);
    *result = (struct pen_bench_result){0};
}
