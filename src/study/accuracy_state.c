/* SPDX-License-Identifier: MIT */
/* An accuracy study's state as JSON, and its pictures, so that another process goes on where this
 * one ended. The pictures are those of the rows' first runs, which the report shows and which a
 * better reference is compared with, and the reference or what there is of it: without it the
 * further runs have no errors. All other pictures are measured at once and gone. */
#include <stdlib.h>

#include "base/clock.h"
#include "io/json_build.h"
#include "study/internal/accuracy_run.h"
#include "study/internal/kept_state.h"

enum { VERSION = 2, TIMES = 3, RUN_VALUES = TIMES + PEN_METRIC_COUNT, DONE_MAX = 1 << 30 };

_Static_assert((int)PEN_ACCURACY_ROWS_MAX + 2 <= (int)PEN_STUDY_PICTURES_MAX,
               "a place for each row and both renders of the reference");

/* The time of each run, its share of the processors, 1 if it is spoiled, and its errors. */
static json_t *runs_json(const struct pen_accuracy_row_result *row)
{
    json_t *list = json_array();
    for (int i = 0; i < row->runs; i++) {
        const struct pen_run_time *time = &row->run[i].time;
        double values[RUN_VALUES] = {time->ms, time->used, time->spoiled};
        for (int m = 0; m < PEN_METRIC_COUNT; m++)
            values[TIMES + m] = row->run[i].error[m];
        json_array_append_new(list, pen_kept_numbers(values, RUN_VALUES));
    }
    return pen_json_all(list, (size_t)row->runs);
}

static json_t *rows_json(const struct pen_accuracy_state *state)
{
    json_t *list = json_array();
    for (int i = 0; i < state->task->row_count; i++) {
        const struct pen_accuracy_row_result *row = &state->out->row[i];
        json_array_append_new(list, json_pack("{s:b, s:f, s:i, s:o, s:o, s:o}", "wanted",
                                              state->wanted[i], "expected_ms", row->expected_ms,
                                              "threads", row->threads, "hash",
                                              pen_kept_hash(row->picture_hash), "rays",
                                              pen_kept_rays(&row->rays), "runs", runs_json(row)));
    }
    return pen_json_all(list, (size_t)state->task->row_count);
}

static json_t *order_json(const struct pen_accuracy_state *state)
{
    json_t *list = json_array();
    for (int i = 0; i < state->task->row_count; i++)
        json_array_append_new(list, json_integer(state->order[i]));
    return pen_json_all(list, (size_t)state->task->row_count);
}

static json_t *reference_json(const struct pen_accuracy_state *state)
{
    const struct pen_accuracy_reference *r = &state->out->reference;
    return json_pack("{s:i, s:i, s:i, s:f, s:f, s:[o, o]}", "factor", r->factor, "halves",
                     state->halves, "tiles", state->tiles, "error", r->error, "render_ms",
                     r->render_ms, "hashes", pen_kept_hash(state->half_hash[0]),
                     pen_kept_hash(state->half_hash[1]));
}

static json_t *state_json(const void *study)
{
    const struct pen_accuracy_state *state = study;
    const struct pen_accuracy *out = state->out;
    const struct pen_accuracy_forecast *f = &out->forecast;
    return json_pack("{s:i, s:O, s:i, s:i, s:f, s:I, s:f, s:[f, f, f], s:[f, f], s:O, s:i, s:i, "
                     "s:i, s:o, s:o, s:o}",
                     "version", VERSION, "host", state->host, "pool_threads",
                     pen_thread_pool_size(state->task->pool), "seeds", state->task->seeds,
                     "elapsed_ms", (double)(pen_clock_ns() - state->begun_ns) * 1e-6, "began_ms",
                     (json_int_t)out->began_ms, "calibration_ms", out->calibration_ms, "forecast",
                     f->expected_ms, f->low_ms, f->high_ms, "threads_ms", out->thread_ms,
                     out->had_ms, "left_out", out->left_out, "done", state->done, "pass",
                     state->pass, "place", state->place, "order", order_json(state), "reference",
                     reference_json(state), "rows", rows_json(state));
}

/* The picture of each place: those of rows, and the two of the reference. */
static struct pen_study_picture picture_of(const struct pen_accuracy_state *state, int place)
{
    const struct pen_accuracy *out = state->out;
    const int rows = state->task->row_count;
    if (place < rows && out->row[place].runs > 0)
        return (struct pen_study_picture){out->row[place].rgb, out->row[place].picture_hash};
    if (place == rows && (state->halves > 0 || state->tiles > 0))
        return (struct pen_study_picture){out->reference.rgb, state->half_hash[0]};
    if (place == rows + 1 && state->halves == 1 && state->tiles > 0)
        return (struct pen_study_picture){state->target, state->half_hash[1]};
    return (struct pen_study_picture){0};
}

bool pen_accuracy_between(struct pen_accuracy_state *state, struct pen_status *st)
{
    const struct pen_accuracy_task *task = state->task;
    struct pen_unfinished unfinished = {.done = state->done,
                                        .study = state,
                                        .state = state_json,
                                        .width = task->settings->width,
                                        .height = task->settings->height,
                                        .picture_count = task->row_count + 2};
    for (int i = 0; i < unfinished.picture_count; i++)
        unfinished.picture[i] = picture_of(state, i);
    return !task->between || task->between(task->user, &unfinished) ||
           pen_fail(st, PEN_UNAVAILABLE, "interrupted after %d of %d runs", state->done,
                    state->total);
}

/* Whether the list has each row once. */
static bool is_order(const json_t *list, int rows)
{
    bool seen[PEN_ACCURACY_ROWS_MAX] = {false};
    if (json_array_size(list) != (size_t)rows)
        return false;
    for (int i = 0; i < rows; i++) {
        const json_t *value = json_array_get(list, (size_t)i);
        const json_int_t row = json_integer_value(value);
        if (!json_is_integer(value) || row < 0 || row >= rows || seen[row])
            return false;
        seen[row] = true;
    }
    return true;
}

/* Reads a row. `ran`: every row that is wanted must have run. */
static bool read_row(struct pen_accuracy_state *state, int number, const json_t *kept, int most,
                     bool ran)
{
    struct pen_accuracy_row_result *row = &state->out->row[number];
    const json_t *runs = json_object_get(kept, "runs");
    const json_t *expected = json_object_get(kept, "expected_ms");
    const int count = (int)json_array_size(runs);
    state->wanted[number] = json_is_true(json_object_get(kept, "wanted"));
    row->threads = pen_kept_whole(kept, "threads", pen_thread_pool_size(state->task->pool));
    row->expected_ms = json_number_value(expected);
    if (!json_is_array(runs) || count > most || !json_is_number(expected) || row->threads < 0 ||
        (!state->wanted[number] && count > 0) || (ran && state->wanted[number] && count == 0) ||
        !pen_kept_read_hash(json_object_get(kept, "hash"), &row->picture_hash) ||
        !pen_kept_read_rays(json_object_get(kept, "rays"), &row->rays))
        return false;
    for (int i = 0; i < count; i++) {
        const json_t *values = json_array_get(runs, (size_t)i);
        if (!pen_kept_is_numbers(values, RUN_VALUES, true))
            return false;
        row->run[i].time = (struct pen_run_time){.ms = pen_kept_number(values, 0),
                                                 .used = pen_kept_number(values, 1),
                                                 .spoiled = pen_kept_number(values, 2) != 0};
        for (int m = 0; m < PEN_METRIC_COUNT; m++)
            row->run[i].error[m] = pen_kept_number(values, TIMES + m);
    }
    row->runs = count;
    return true;
}

static bool read_rows(struct pen_accuracy_state *state, const json_t *list)
{
    const int rows = state->task->row_count, most = state->pass == 0 ? 1
                                                    : state->pass < state->task->seeds
                                                        ? state->pass + 1
                                                        : state->task->seeds;
    const bool ran = state->halves > 0 || state->tiles > 0;
    bool any = false;
    if (json_array_size(list) != (size_t)rows)
        return false;
    for (int i = 0; i < rows; i++) {
        if (!read_row(state, i, json_array_get(list, (size_t)i), most, ran))
            return false;
        any |= state->wanted[i];
    }
    return any;
}

static bool read_reference(struct pen_accuracy_state *state, const json_t *kept)
{
    struct pen_accuracy_reference *r = &state->out->reference;
    const struct pen_settings *s = state->task->settings;
    const json_t *hashes = json_object_get(kept, "hashes");
    state->halves = pen_kept_whole(kept, "halves", 2);
    state->tiles = pen_kept_whole(kept, "tiles", pen_tile_count(s->width, s->height, s->tile) - 1);
    r->factor = pen_kept_whole(kept, "factor", PEN_ACCURACY_FACTOR_MAX);
    r->error = json_number_value(json_object_get(kept, "error"));
    r->render_ms = json_number_value(json_object_get(kept, "render_ms"));
    return state->halves >= 0 && state->tiles >= 0 && r->factor >= 0 &&
           (state->halves < 2 || state->tiles == 0) &&
           (r->factor > 0 || (state->halves == 0 && state->tiles == 0)) &&
           pen_kept_read_hash(json_array_get(hashes, 0), &state->half_hash[0]) &&
           pen_kept_read_hash(json_array_get(hashes, 1), &state->half_hash[1]);
}

/* How far the study is. */
static bool read_place(struct pen_accuracy_state *state, const json_t *kept)
{
    const int rows = state->task->row_count;
    const json_t *order = json_object_get(kept, "order");
    state->done = pen_kept_whole(kept, "done", DONE_MAX);
    state->pass = pen_kept_whole(kept, "pass", state->task->seeds);
    state->place = pen_kept_whole(kept, "place", rows);
    if (state->done < 0 || state->pass < 0 || state->place < 0 ||
        (state->pass > 0 && state->halves != 2) || (state->pass == 0 && state->place > 0) ||
        (state->place > 0 && !is_order(order, rows)))
        return false;
    for (int i = 0; state->place > 0 && i < rows; i++)
        state->order[i] = (int)json_integer_value(json_array_get(order, (size_t)i));
    return true;
}

static bool read_pictures(struct pen_accuracy_state *state, const struct pen_kept_study *kept)
{
    const struct pen_settings *s = state->task->settings;
    for (int i = 0; i < state->task->row_count + 2; i++) {
        const struct pen_study_picture picture = picture_of(state, i);
        float *rgb = (float *)(uintptr_t)picture.rgb; /* this state's own */
        if (rgb && !kept->picture(kept->user, i, picture.hash, s->width, s->height, rgb))
            return false;
    }
    return true;
}

/* Reads all but the head. */
static bool read_study(struct pen_accuracy_state *state, const struct pen_kept_study *kept)
{
    struct pen_accuracy *out = state->out;
    const json_t *json = kept->state, *forecast = json_object_get(json, "forecast"),
                 *threads_ms = json_object_get(json, "threads_ms");
    json_t *left_out = json_object_get(json, "left_out");
    const double elapsed_ms = json_number_value(json_object_get(json, "elapsed_ms"));
    if (!pen_kept_is_numbers(forecast, 3, false) || !pen_kept_is_numbers(threads_ms, 2, false) ||
        !json_is_array(left_out) || !(elapsed_ms >= 0 && elapsed_ms < 1e12) ||
        !read_reference(state, json_object_get(json, "reference")) || !read_place(state, json) ||
        !read_rows(state, json_object_get(json, "rows")) || !read_pictures(state, kept) ||
        json_array_extend(out->left_out, left_out) != 0)
        return false;
    state->begun_ns -= (int64_t)(elapsed_ms * 1e6);
    out->began_ms = json_integer_value(json_object_get(json, "began_ms"));
    out->calibration_ms = json_number_value(json_object_get(json, "calibration_ms"));
    out->thread_ms = pen_kept_number(threads_ms, 0);
    out->had_ms = pen_kept_number(threads_ms, 1);
    out->forecast = (struct pen_accuracy_forecast){
        pen_kept_number(forecast, 0), pen_kept_number(forecast, 1), pen_kept_number(forecast, 2)};
    return true;
}

/* Makes the state new again. */
static void forget(struct pen_accuracy_state *state)
{
    for (int i = 0; i < state->task->row_count; i++)
        state->out->row[i].runs = 0;
    state->done = state->halves = state->tiles = state->pass = state->place = 0;
}

bool pen_accuracy_state_read(struct pen_accuracy_state *state, const struct pen_kept_study *kept)
{
    const json_t *json = kept->state;
    if (pen_kept_whole(json, "version", VERSION) == VERSION &&
        pen_kept_whole(json, "seeds", state->task->seeds) == state->task->seeds &&
        pen_kept_is_of_host(json, state->host, state->task->pool) && read_study(state, kept))
        return true;
    forget(state);
    return false;
}
