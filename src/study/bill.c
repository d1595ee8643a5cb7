/* SPDX-License-Identifier: MIT */
#include "study/bill.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "film/flip.h"
#include "film/metrics.h"
#include "render/transfer.h"
#include "study/host.h"
#include "study/internal/bill_state.h"
#include "study/leave_out.h"

static int runs_of(const struct pen_bill *bill)
{
    return bill->rows * (bill->task->repeats + 1);
}

/* The bytes of a film. */
static size_t film_bytes(const struct pen_settings *s)
{
    return 3 * (size_t)s->width * (size_t)s->height * sizeof(float);
}

/* Keeps what a render with all effects has told, in place of what an earlier one did. */
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
                                           .cancel = task->cancel,
                                           .pixel_begins = task->pixel_begins,
                                           .pixel_user = task->pixel_user,
                                           .keep_tile_ms = whole};
    const struct pen_run_watch watch = pen_run_begin();
    if (!pen_render_run(task->pool, &render, &stats, st))
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

/* Renders a row once, again if the run is spoiled; pass -1 is to warm up. */
static bool run_row(struct pen_bill *bill, struct pen_bill_row *row, int pass,
                    struct pen_status *st)
{
    const struct pen_bill_task *task = bill->task;
    struct pen_settings settings = *task->settings;
    struct pen_scene_desc desc;
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene *scene = NULL;
    bool ok = arena && pen_scene_leave_out(task->desc, row->effect, arena, &desc, &settings);
    if (!ok)
        pen_fail(st, PEN_NO_MEMORY, "out of memory for a scene without an effect");
    const int64_t begun_ns = pen_clock_ns();
    if (ok)
        scene = pen_scene_freeze(&desc, (enum pen_accelerator)settings.accelerator,
                                 task->scene_cap_bytes, st);
    const double build_ms = (double)(pen_clock_ns() - begun_ns) * 1e-6;
    int repeats = 0;
    do {
        ok = scene && render_row(bill, scene, &settings, row, pass, build_ms, st);
    } while (ok && pass >= 0 && row->runs[pass].spoiled && repeats++ < PEN_SPOILED_REPEATS);
    pen_scene_free(scene);
    pen_arena_free(arena);
    return ok;
}

/* How far the row's picture is from the whole one. */
static bool compare_row(const struct pen_bill *bill, struct pen_bill_row *row,
                        struct pen_status *st)
{
    const struct pen_settings *s = bill->task->settings;
    const struct pen_film whole = {s->width, s->height, bill->row[0].rgb},
                          without = {s->width, s->height, row->rgb};
    struct pen_picture *a = pen_picture_of_film(&whole, pen_settings_transfer(s), st);
    struct pen_picture *b = a ? pen_picture_of_film(&without, pen_settings_transfer(s), st) : NULL;
    struct pen_difference d;
    struct pen_flip flip;
    const bool ok =
        b && pen_picture_compare(a, b, 0, &d, st) && pen_picture_flip(a, b, NULL, &flip, st);
    if (ok) {
        row->rmse = d.rmse;
        row->max_error = d.max_error;
        row->flip = flip.mean;
    }
    pen_picture_free(a);
    pen_picture_free(b);
    return ok;
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
    /* Through a lens there may be several samples whatever samples_per_pixel is. */
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

/* Adds a row for the whole scene, and one for each of its effects. */
static bool add_rows(struct pen_bill *bill, struct pen_status *st)
{
    const struct pen_bill_task *task = bill->task;
    const unsigned effects = pen_bill_effects(task->desc, task->view, task->settings);
    bool ok = add_row(bill, 0);
    for (int i = 0; ok && i < PEN_FX_COUNT; i++)
        if (effects >> i & 1)
            ok = add_row(bill, 1u << i);
    return ok || pen_fail(st, PEN_NO_MEMORY, "out of memory for %d pictures", bill->rows);
}

/* Times of all rows, and differences of all but the first, which has none. */
static bool finish_rows(struct pen_bill *bill, struct pen_status *st)
{
    const atomic_bool *cancel = bill->task->cancel;
    for (int i = 0; i < bill->rows; i++) {
        bill->row[i].time = pen_row_time_of(bill->row[i].runs, bill->task->repeats);
        pen_runs_use_add(&bill->use, bill->row[i].runs, bill->task->repeats);
        if (cancel && atomic_load(cancel))
            return pen_fail(st, PEN_CANCELLED, "cancelled after %d of %d comparisons", i,
                            bill->rows);
        if (i > 0 && !compare_row(bill, &bill->row[i], st))
            return false;
    }
    return true;
}

/* Makes the next run, counts it, and asks whether to go on. A row's picture is the same in every
 * pass, so it has its hash from the first. */
static bool next_run(struct pen_bill *bill, struct pen_status *st)
{
    const struct pen_bill_task *task = bill->task;
    const int pass = bill->done / bill->rows - 1;
    struct pen_bill_row *row = &bill->row[bill->done % bill->rows];
    if (!run_row(bill, row, pass, st))
        return false;
    if (pass < 0 && task->between) {
        const struct pen_film film = {task->settings->width, task->settings->height, row->rgb};
        row->hash = pen_film_hash(&film);
    }
    bill->done++;
    if (task->progress)
        task->progress(task->user, bill->done, runs_of(bill));
    return pen_bill_between(bill, st);
}

/* Goes on with what an earlier process has kept, if it is of use. Then the first run, of the whole
 * scene, is thrown away. */
static bool begin(struct pen_bill *bill, struct pen_status *st)
{
    const struct pen_bill_task *task = bill->task;
    bill->host = task->between || task->kept ? pen_host_json() : json_null();
    if (!bill->host)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory for a bill");
    const bool goes_on = task->kept && pen_bill_state_read(bill, task->kept);
    if (task->progress)
        task->progress(task->user, bill->done, runs_of(bill));
    return !goes_on || run_row(bill, &bill->row[0], -1, st);
}

bool pen_bill_make(const struct pen_bill_task *task, struct pen_bill *bill, struct pen_status *st)
{
    *bill = (struct pen_bill){.task = task};
    bool ok = add_rows(bill, st) && begin(bill, st);
    while (ok && bill->done < runs_of(bill))
        ok = next_run(bill, st);
    return ok && finish_rows(bill, st);
}

void pen_bill_release(struct pen_bill *bill)
{
    for (int i = 0; i < bill->rows; i++) {
        free(bill->row[i].runs);
        free(bill->row[i].rgb);
    }
    free(bill->whole.tile_ms);
    bill->whole.tile_ms = NULL;
    json_decref(bill->host);
    bill->host = NULL;
    bill->rows = 0;
}
