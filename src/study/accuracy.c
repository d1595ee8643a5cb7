/* SPDX-License-Identifier: MIT */
/* The order of an accuracy study's runs, and which of them the budget allows. */
#include "study/accuracy.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "film/film.h"
#include "render/layers.h"
#include "report/values.h"
#include "study/accuracy_summary.h"
#include "study/internal/accuracy_run.h"
#include "study/internal/calibration.h"
#include "study/internal/random_order.h"
#include "study/verdict.h"

enum { CALIBRATIONS = 11 };

double pen_accuracy_left_ms(const struct pen_accuracy_state *state)
{
    return state->task->budget_ms - pen_making_spent_ms(&state->making);
}

bool pen_accuracy_left_out(struct pen_accuracy *accuracy, json_t *text, struct pen_status *st)
{
    return json_array_append_new(accuracy->left_out, text) == 0 ||
           pen_fail(st, PEN_NO_MEMORY, "out of memory for a report");
}

bool pen_accuracy_leave_out(struct pen_accuracy_state *state, int row, const char *why,
                            struct pen_status *st)
{
    struct pen_buf name = {0};
    pen_write_settings(state->task->rows[row].varied, &name);
    const bool ok = pen_accuracy_left_out(
        state->out, json_sprintf("%s: %s", name.data ? (const char *)name.data : "", why), st);
    pen_buf_release(&name);
    return ok;
}

bool pen_accuracy_render(struct pen_accuracy_state *state, struct pen_render_task *render,
                         struct pen_render_stats *stats, struct pen_status *st)
{
    const struct pen_accuracy_task *task = state->task;
    render->scene = state->scene;
    render->view = task->view;
    render->cancel = task->frame.cancel;
    render->pixel_begins = task->frame.pixel_begins;
    render->pixel_user = task->frame.pixel_user;
    if (!pen_making_check(&state->making, st))
        return false;
    const struct pen_run_watch watch = pen_run_begin();
    if (!pen_render_run(task->frame.pool, render, stats, st))
        return false;
    state->use = pen_run_end(&watch, stats, 0, 0);
    state->out->thread_ms += stats->thread_ms;
    state->out->had_ms += state->use.used * stats->thread_ms;
    return true;
}

uint64_t pen_accuracy_hash(const struct pen_accuracy_state *state, const float *rgb)
{
    const struct pen_film film = {state->task->settings->width, state->task->settings->height,
                                  (float *)(uintptr_t)rgb};
    return pen_film_hash(&film);
}

bool pen_accuracy_measure(const struct pen_accuracy_state *state, const float *rgb,
                          struct pen_accuracy_run *run, struct pen_status *st)
{
    const struct pen_study_pair pair = {state->task->settings, rgb, state->out->reference.rgb};
    return pen_study_measure(&pair, run->error, NULL, st);
}

/* Renders a row with its own seed plus `seed`. Keeps the picture of seed 0. */
static bool render_row(struct pen_accuracy_state *state, int number, int seed,
                       struct pen_render_stats *stats, struct pen_status *st)
{
    struct pen_settings settings = state->task->rows[number].settings;
    settings.seed += (uint64_t)seed;
    struct pen_render_task render = {.settings = &settings,
                                     .tile_count = -1,
                                     .rgb = seed == 0 ? state->out->row[number].rgb : state->target,
                                     .keep_tile_ms = number == state->out->stats_row};
    if (!pen_accuracy_render(state, &render, stats, st))
        return false;
    if (number == state->out->stats_row) {
        free(state->out->stats.tile_ms);
        state->out->stats = *stats;
    }
    return true;
}

/* Whether a run that took `ms` is repeated: it is spoiled, and the remaining time allows it. */
static bool is_repeated(const struct pen_accuracy_state *state, double ms)
{
    return state->use.spoiled && 4 * ms <= pen_accuracy_left_ms(state);
}

/* Makes the next run of a row, with the next seed. */
static bool run_row(struct pen_accuracy_state *state, int number, struct pen_status *st)
{
    struct pen_accuracy_row_result *row = &state->out->row[number];
    struct pen_accuracy_run *run = &row->run[row->runs];
    struct pen_render_stats stats;
    int repeats = 0;
    do {
        if (!render_row(state, number, row->runs, &stats, st))
            return false;
    } while (repeats++ < PEN_SPOILED_REPEATS && is_repeated(state, stats.render_ms));
    run->time = (struct pen_run_time){stats.render_ms, state->use.used, state->use.spoiled};
    row->runs++;
    if (row->runs > 1)
        return pen_accuracy_measure(state, state->target, run, st) &&
               pen_making_end_run(&state->making, st);
    row->rays = stats.rays;
    row->threads = stats.threads;
    row->picture_hash = pen_accuracy_hash(state, row->rgb);
    return pen_making_end_run(&state->making, st);
}

/* Makes the first run of a process that resumed the study. Its time is discarded. It repeats the
 * last run of the row whose statistics are those of the study. */
static bool go_on(struct pen_accuracy_state *state, struct pen_status *st)
{
    const int row = state->out->stats_row, runs = state->out->row[row].runs;
    struct pen_render_stats stats;
    return runs == 0 || render_row(state, row, runs - 1, &stats, st);
}

/* Makes the first pass, or the part of it that an earlier process did not make. Rows that are left
 * out do not run. The runs have no errors yet, because there is no reference. */
static bool first_pass(struct pen_accuracy_state *state, struct pen_status *st)
{
    int order[PEN_ACCURACY_ROWS_MAX];
    uint64_t random = state->task->settings->seed;
    pen_random_order(order, state->task->row_count, &random);
    for (int i = 0; i < state->task->row_count; i++) {
        if (state->out->row[order[i]].wanted && state->out->row[order[i]].runs == 0 &&
            !run_row(state, order[i], st))
            return false;
    }
    return true;
}

/* The mean time of a row's runs so far; before the first one, its forecast. */
static double run_ms(const struct pen_accuracy_row_result *row)
{
    double sum = 0;
    for (int i = 0; i < row->runs; i++)
        sum += row->run[i].time.ms;
    return row->runs > 0 ? sum / row->runs : row->expected_ms;
}

/* Moves the rows of the Pareto front before the others, and otherwise keeps the order. */
static void put_front_first(const struct pen_accuracy *accuracy, int *order, int count)
{
    bool front[PEN_ACCURACY_ROWS_MAX];
    int sorted[PEN_ACCURACY_ROWS_MAX], at = 0;
    pen_accuracy_front(accuracy, front);
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < count; i++)
            if (front[order[i]] == (pass == 0))
                sorted[at++] = order[i];
    }
    memcpy(order, sorted, (size_t)count * sizeof *order);
}

/* Draws the order of a further pass. If not all rows fit the remaining time, the rows of the front
 * come first. */
static void draw_order(struct pen_accuracy_state *state)
{
    const struct pen_accuracy_task *task = state->task;
    uint64_t random = task->settings->seed + (uint64_t)state->pass * 0x632be59bd9b4e019u;
    int order[PEN_ACCURACY_ROWS_MAX];
    double all_ms = 0;
    pen_random_order(order, task->row_count, &random);
    for (int i = 0; i < task->row_count; i++)
        all_ms += state->out->row[i].runs > 0 ? run_ms(&state->out->row[i]) : 0;
    if (all_ms > pen_accuracy_left_ms(state))
        put_front_first(state->out, order, task->row_count);
    for (int i = 0; i < task->row_count; i++)
        state->out->row[i].next = order[i];
}

/* Makes a further pass, or the part of it that an earlier process did not make. */
static bool make_pass(struct pen_accuracy_state *state, struct pen_status *st)
{
    if (state->place == 0)
        draw_order(state);
    while (state->place < state->task->row_count) {
        const int number = state->out->row[state->place++].next;
        const struct pen_accuracy_row_result *row = &state->out->row[number];
        if (row->runs > 0 && row->runs <= state->pass &&
            run_ms(row) <= pen_accuracy_left_ms(state) && !run_row(state, number, st))
            return false;
    }
    state->place = 0;
    state->pass++;
    return true;
}

static bool further_passes(struct pen_accuracy_state *state, struct pen_status *st)
{
    const struct pen_accuracy_task *task = state->task;
    while (state->pass < task->seeds)
        if (!make_pass(state, st))
            return false;
    for (int i = 0; i < task->row_count; i++) {
        char why[64];
        const int runs = state->out->row[i].runs;
        snprintf(why, sizeof why, "%d of %d runs", task->seeds - runs, task->seeds);
        if (runs > 0 && runs < task->seeds && !pen_accuracy_leave_out(state, i, why, st))
            return false;
    }
    return true;
}

/* The row whose time per pixel the report shows: the recommended row, or the first row that has
 * run. */
static int cost_row(const struct pen_accuracy *accuracy)
{
    int row = pen_accuracy_recommended(accuracy);
    for (int i = 0; row < 0; i++)
        row = accuracy->row[i].runs > 0 ? i : -1;
    return row;
}

/* Renders the layer `cost`, unless the remaining time is less than ten runs of its row. Counting
 * tests makes it slower than a run. */
static bool make_cost(struct pen_accuracy_state *state, struct pen_status *st)
{
    struct pen_accuracy *out = state->out;
    const int row = cost_row(out);
    const struct pen_layer_task task = {.scene = state->scene,
                                        .view = state->task->view,
                                        .settings = &state->task->rows[row].settings,
                                        .layer = PEN_LAYER_COST,
                                        .cost = PEN_COST_TIME,
                                        .rgb = state->target,
                                        .cancel = state->task->frame.cancel};
    if (10 * run_ms(&out->row[row]) > pen_accuracy_left_ms(state))
        return pen_accuracy_left_out(out, json_string("the map of the time of each pixel"), st);
    if (!pen_layer_render(state->task->frame.pool, &task, st))
        return false;
    out->cost_row = row;
    out->cost_most = pen_layer_show(PEN_LAYER_COST, state->target, state->values / 3);
    out->cost = state->target;
    state->target = NULL;
    pen_making_count(&state->making);
    return true;
}

int pen_accuracy_runs(const struct pen_accuracy_task *task)
{
    return task->row_count * task->seeds + 3;
}

static bool allocate(struct pen_accuracy_state *state, struct pen_status *st)
{
    const struct pen_accuracy_task *task = state->task;
    struct pen_accuracy *out = state->out;
    const size_t bytes = state->values * sizeof(float);
    out->row = calloc((size_t)task->row_count, sizeof *out->row);
    out->left_out = json_array();
    out->reference.rgb = malloc(bytes);
    state->target = malloc(bytes);
    bool ok = out->row && out->left_out && out->reference.rgb && state->target;
    for (int i = 0; ok && i < task->row_count; i++) {
        out->row[i].run = calloc((size_t)task->seeds, sizeof *out->row[i].run);
        out->row[i].rgb = malloc(bytes);
        ok = out->row[i].run && out->row[i].rgb;
    }
    return ok ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for the pictures of %d rows", task->row_count);
}

static bool freeze(struct pen_accuracy_state *state, struct pen_status *st)
{
    const struct pen_accuracy_task *task = state->task;
    const int64_t begun_ns = pen_clock_ns();
    state->scene =
        pen_scene_freeze(task->frame.desc, (enum pen_accelerator)task->settings->accelerator,
                         task->frame.scene_cap_bytes, st);
    if (!state->scene)
        return false;
    state->out->build_ms = (double)(pen_clock_ns() - begun_ns) * 1e-6;
    state->out->accel = *pen_accel_get_stats(state->scene->accel);
    return true;
}

bool pen_accuracy_check(const struct pen_accuracy_task *task, const char *at, struct pen_status *st)
{
    const double pixels = (double)task->settings->width * task->settings->height,
                 kept = pixels * (task->row_count + 2);
    for (int i = 0; i < task->row_count; i++)
        if (!pen_limits_check(&task->limits, task->frame.desc, &task->rows[i].settings, 1, at, st))
            return false;
    return kept <= (double)task->limits.pixels_per_view ||
           pen_fail_at(st, PEN_TOO_LARGE, at,
                       "the %d pictures to be compared have %.0f pixels together, at most %llu "
                       "are allowed",
                       task->row_count + 2, kept, (unsigned long long)task->limits.pixels_per_view);
}

static double calibrate(void)
{
    double ms[CALIBRATIONS];
    for (int i = 0; i < CALIBRATIONS; i++)
        ms[i] = pen_calibration_run();
    return pen_median(ms, CALIBRATIONS);
}

/* Plans the study, or resumes one that an earlier process saved. */
static bool begin(struct pen_accuracy_state *state, struct pen_status *st)
{
    const bool goes_on = pen_making_resume(&state->making);
    if (!goes_on) {
        state->out->calibration_ms = calibrate();
        if (!pen_accuracy_plan(state, st))
            return false;
    }
    while (!state->out->row[state->out->stats_row].wanted) /* at least one row is wanted */
        state->out->stats_row++;
    return !goes_on || go_on(state, st);
}

bool pen_accuracy_make(const struct pen_accuracy_task *task, struct pen_accuracy *out,
                       struct pen_status *st)
{
    const struct pen_settings *s = task->settings;
    struct pen_accuracy_state state = {.making = {.frame = &task->frame,
                                                  .shape = &pen_accuracy_shape,
                                                  .study = &state,
                                                  .results = out,
                                                  .rows = task->row_count,
                                                  .pictures = task->row_count + 2,
                                                  .width = s->width,
                                                  .height = s->height,
                                                  .total = pen_accuracy_runs(task)},
                                       .task = task,
                                       .out = out,
                                       .values = 3 * (size_t)s->width * (size_t)s->height};
    *out = (struct pen_accuracy){.task = task};
    const bool ok = pen_making_begin(&state.making, st) && allocate(&state, st) &&
                    freeze(&state, st) && begin(&state, st) && first_pass(&state, st) &&
                    pen_accuracy_make_reference(&state, st) && further_passes(&state, st) &&
                    make_cost(&state, st);
    if (ok && task->frame.progress)
        task->frame.progress(task->frame.user, state.making.total, state.making.total);
    out->began_ms = state.making.began_ms;
    out->spent_ms = pen_making_spent_ms(&state.making);
    pen_making_end(&state.making);
    pen_scene_free(state.scene);
    free(state.target);
    return ok;
}

void pen_accuracy_release(struct pen_accuracy *accuracy)
{
    for (int i = 0; accuracy->row && i < accuracy->task->row_count; i++) {
        free(accuracy->row[i].run);
        free(accuracy->row[i].rgb);
    }
    free(accuracy->row);
    free(accuracy->reference.rgb);
    free(accuracy->cost);
    free(accuracy->stats.tile_ms);
    json_decref(accuracy->left_out);
    *accuracy = (struct pen_accuracy){0};
}
