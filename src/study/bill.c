/* SPDX-License-Identifier: MIT */
#include "study/bill.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "film/film.h"
#include "study/internal/bill_state.h"
#include "study/leave_out.h"

/* The bytes of a film. */
static size_t film_bytes(const struct pen_settings *s)
{
    return 3 * (size_t)s->width * (size_t)s->height * sizeof(float);
}

/* Keeps the statistics of the last render with all effects. */
static void keep_whole(struct pen_bill *bill, const struct pen_scene *scene,
                       const struct pen_render_stats *stats, double build_ms)
{
    free(bill->whole.tile_ms);
    bill->whole = *stats;
    bill->accel = *pen_accel_get_stats(scene->accel);
    bill->build_ms = build_ms;
}

static bool render_row(struct pen_bill *bill, const struct pen_scene *scene,
                       const struct pen_settings *settings, struct pen_bill_row *row, int pass,
                       double build_ms, struct pen_status *st)
{
    struct pen_render_stats stats;
    const struct pen_bill_task *task = bill->task;
    const bool whole = row == &bill->row[0];
    const struct pen_render_task render = {.scene = scene,
                                           .view = task->view,
                                           .settings = settings,
                                           .tile_count = -1,
                                           .rgb = row->rgb,
                                           .cancel = task->frame.cancel,
                                           .pixel_begins = task->frame.pixel_begins,
                                           .pixel_user = task->frame.pixel_user,
                                           .keep_tile_ms = whole};
    const struct pen_run_watch watch = pen_run_begin();
    if (!pen_render_run(task->frame.pool, &render, &stats, st))
        return false;
    const struct pen_run_use use = pen_run_end(&watch, &stats, 0, 0);
    if (whole)
        keep_whole(bill, scene, &stats, build_ms);
    if (pass >= 0)
        row->runs[pass] = (struct pen_run_time){stats.render_ms, use.used, use.spoiled};
    row->rays = stats.rays;
    row->kernel = stats.kernel;
    return true;
}

/* Renders a row once, and again if the run is spoiled. pass -1: warm-up. */
static bool run_row(struct pen_bill *bill, struct pen_bill_row *row, int pass,
                    struct pen_status *st)
{
    const struct pen_bill_task *task = bill->task;
    struct pen_settings settings = *task->settings;
    struct pen_scene_desc desc;
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene *scene = NULL;
    bool ok = arena && pen_scene_leave_out(task->frame.desc, row->effect, arena, &desc, &settings);
    if (!ok)
        pen_fail(st, PEN_NO_MEMORY, "out of memory for a scene without an effect");
    const int64_t begun_ns = pen_clock_ns();
    if (ok)
        scene = pen_scene_freeze(&desc, (enum pen_accelerator)settings.accelerator,
                                 task->frame.scene_cap_bytes, st);
    const double build_ms = (double)(pen_clock_ns() - begun_ns) * 1e-6;
    int repeats = 0;
    do {
        ok = scene && render_row(bill, scene, &settings, row, pass, build_ms, st);
    } while (ok && pass >= 0 && row->runs[pass].spoiled && repeats++ < PEN_SPOILED_REPEATS);
    pen_scene_free(scene);
    pen_arena_free(arena);
    return ok;
}

/* Measures the difference between the row's picture and that of row 0. */
static bool compare_row(const struct pen_bill *bill, struct pen_bill_row *row,
                        struct pen_status *st)
{
    const struct pen_study_pair pair = {bill->task->settings, row->rgb, bill->row[0].rgb};
    double error[PEN_METRIC_COUNT];
    if (!pen_study_measure(&pair, error, NULL, st))
        return false;
    row->rmse = error[PEN_METRIC_RMSE];
    row->max_error = error[PEN_METRIC_MAX_ERROR];
    row->flip = error[PEN_METRIC_FLIP];
    return true;
}

unsigned pen_bill_effects(const struct pen_scene_desc *desc, int view,
                          const struct pen_settings *settings)
{
    struct pen_scene_desc one = *desc;
    one.views += view;
    one.view_count = 1;
    const unsigned effects = pen_desc_effects(&one, settings);
    if (pen_settings_adaptive(settings))
        return effects;
    /* With a lens there may be several samples even if samples_per_pixel is 1. */
    const bool lens = effects & PEN_FX_DEPTH_OF_FIELD,
               single = settings->samples_per_pixel <= 1 ||
                        (lens && settings->lens_samples >= settings->samples_per_pixel);
    return single ? effects & ~(unsigned)PEN_FX_ANTI_ALIASING : effects;
}

bool pen_bill_check(const struct pen_limits *limits, const struct pen_scene_desc *desc, int view,
                    const struct pen_settings *settings, int repeats, const char *at,
                    struct pen_status *st)
{
    if (!pen_limits_check(limits, desc, settings, 1, at, st))
        return false;
    const unsigned effects = pen_bill_effects(desc, view, settings);
    const double pixels = (double)settings->width * settings->height,
                 kept = pixels * pen_bill_pictures(effects),
                 work =
                     pixels * pen_work_per_pixel(desc, settings) * pen_bill_runs(effects, repeats);
    if (work > limits->work)
        return pen_fail_at(st, PEN_TOO_LARGE, at,
                           "all %d renders together take up to %.3g primary and shadow rays, at "
                           "most %.3g are allowed",
                           pen_bill_runs(effects, repeats), work, limits->work);
    if (!pen_limits_check_time(limits, work, at, st))
        return false;
    if (kept > (double)limits->pixels_per_view)
        return pen_fail_at(st, PEN_TOO_LARGE, at,
                           "the %d pictures to be compared have %.0f pixels together, at most "
                           "%llu are allowed",
                           pen_bill_pictures(effects), kept,
                           (unsigned long long)limits->pixels_per_view);
    return true;
}

static bool add_row(struct pen_bill *bill, unsigned effect)
{
    struct pen_bill_row *row = &bill->row[bill->rows++];
    row->effect = effect;
    row->runs = calloc((size_t)bill->task->repeats, sizeof *row->runs);
    row->rgb = malloc(film_bytes(bill->task->settings));
    return row->runs && row->rgb;
}

/* Adds a row with all effects, and a row without each effect. */
static bool add_rows(struct pen_bill *bill, struct pen_status *st)
{
    const struct pen_bill_task *task = bill->task;
    const unsigned effects = pen_bill_effects(task->frame.desc, task->view, task->settings);
    bool ok = add_row(bill, 0);
    for (int i = 0; ok && i < PEN_FX_COUNT; i++)
        if (effects >> i & 1)
            ok = add_row(bill, 1u << i);
    return ok || pen_fail(st, PEN_NO_MEMORY, "out of memory for %d pictures", bill->rows);
}

/* Sets the times of all rows, and the differences of all rows but the first. */
static bool finish_rows(struct pen_bill *bill, const struct pen_making *making,
                        struct pen_status *st)
{
    for (int i = 0; i < bill->rows; i++) {
        bill->row[i].time = pen_row_time_of(bill->row[i].runs, bill->task->repeats);
        pen_runs_use_add(&bill->use, bill->row[i].runs, bill->task->repeats);
        if (!pen_making_check(making, st) || (i > 0 && !compare_row(bill, &bill->row[i], st)))
            return false;
    }
    return true;
}

/* Makes the next run and counts it. A row's picture is the same in every pass, so its hash is
 * computed in the first. */
static bool next_run(struct pen_bill *bill, struct pen_making *making, struct pen_status *st)
{
    const struct pen_settings *s = bill->task->settings;
    const int pass = making->done / bill->rows - 1;
    struct pen_bill_row *row = &bill->row[making->done % bill->rows];
    if (!run_row(bill, row, pass, st))
        return false;
    if (pass < 0 && making->frame->between) {
        const struct pen_film film = {s->width, s->height, row->rgb};
        row->hash = pen_film_hash(&film);
    }
    return pen_making_end_run(making, st);
}

bool pen_bill_make(const struct pen_bill_task *task, struct pen_bill *bill, struct pen_status *st)
{
    struct pen_bill_state state = {.bill = bill};
    struct pen_making *making = &state.making;
    *bill = (struct pen_bill){.task = task};
    bool ok = add_rows(bill, st);
    *making = (struct pen_making){.frame = &task->frame,
                                  .shape = &pen_bill_shape,
                                  .study = &state,
                                  .rows = bill->rows,
                                  .pictures = bill->rows,
                                  .width = task->settings->width,
                                  .height = task->settings->height,
                                  .total = bill->rows * (task->repeats + 1)};
    ok = ok && pen_making_begin(making, st);
    if (ok && pen_making_resume(making))
        ok = run_row(bill, &bill->row[0], -1,
                     st); /* a run with all effects, whose time is discarded */
    while (ok && making->done < making->total)
        ok = next_run(bill, making, st);
    ok = ok && finish_rows(bill, making, st);
    pen_making_end(making);
    return ok;
}

void pen_bill_release(struct pen_bill *bill)
{
    for (int i = 0; i < bill->rows; i++) {
        free(bill->row[i].runs);
        free(bill->row[i].rgb);
    }
    free(bill->whole.tile_ms);
    bill->whole.tile_ms = NULL;
    bill->rows = 0;
}
