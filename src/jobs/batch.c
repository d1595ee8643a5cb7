/* SPDX-License-Identifier: MIT */
/* Rendering a batch and assembling a view. Rule R3 of the farm notes: a view of several batches
 * gets its picture from committed pixels alone, one of a single batch from the pixels that are
 * committed with it. */
#include "jobs/internal/batch.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "io/figures.h"
#include "jobs/internal/stats.h"

static double ms_since(int64_t begin_ns)
{
    return (double)(pen_clock_ns() - begin_ns) * 1e-6;
}

void pen_batch_work_release(struct pen_batch_work *work)
{
    pen_buf_release(&work->artefact);
    free(work->stats);
    *work = (struct pen_batch_work){0};
}

void pen_batch_room_empty(struct pen_batch_room *room)
{
    pen_scene_cache_empty(room->scenes);
    free(room->image);
    room->image = NULL;
    room->image_pixels = 0;
}

void pen_batch_room_release(struct pen_batch_room *room)
{
    json_decref(room->plan.request);
    free(room->image);
}

/* The job's settings and views; batches of one job come one after the other. */
static bool load_plan(struct pen_batch_room *room, const struct pen_claim *claim,
                      struct pen_status *st)
{
    struct pen_job_record job;
    if (strcmp(room->plan_id, claim->job_id) == 0)
        return true;
    room->plan_id[0] = '\0';
    room->store_ms = 0;
    json_decref(room->plan.request);
    room->plan.request = NULL;
    if (!pen_store_job(room->store, claim->job_id, &job, st))
        return false;
    bool ok = pen_job_plan_read(job.request, &room->plan, st);
    pen_job_record_release(&job);
    if (ok)
        memcpy(room->plan_id, claim->job_id, sizeof room->plan_id);
    return ok;
}

/* Room for the whole image that the plan asks for. */
static bool make_room(struct pen_batch_room *room, struct pen_status *st)
{
    size_t wanted = (size_t)room->plan.settings.width * (size_t)room->plan.settings.height;
    if (wanted <= room->image_pixels)
        return true;
    free(room->image);
    room->image_pixels = 0;
    room->image = wanted < SIZE_MAX / 3 / sizeof *room->image
                      ? malloc(wanted * 3 * sizeof *room->image)
                      : NULL;
    if (!room->image)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for %zu pixels", wanted);
    room->image_pixels = wanted;
    return true;
}

static bool encode(struct pen_batch_room *room, struct pen_film film, struct pen_batch_work *work,
                   double *encode_ms, struct pen_status *st)
{
    int64_t begin_ns = pen_clock_ns();
    if (!pen_canvas_encode(&film, &room->plan.settings, "png", &work->artefact, st))
        return false;
    work->result.layer = "beauty";
    work->result.format = "png";
    work->result.artefact = work->artefact.data;
    work->result.artefact_bytes = work->artefact.bytes;
    *encode_ms = ms_since(begin_ns);
    return true;
}

bool pen_batch_write_stats(struct pen_batch_room *room, json_t *stats, struct pen_batch_work *work,
                           struct pen_status *st)
{
    stats = pen_json_with(stats, "store_before_ms", pen_figure(room->store_ms));
    room->store_ms = 0;
    stats = pen_json_with(stats, "commit_ms", json_integer(pen_clock_wall_ms()));
    work->stats = stats ? json_dumps(stats, PEN_JSON_STORED) : NULL;
    json_decref(stats);
    work->result.stats = work->stats;
    return work->stats || pen_fail(st, PEN_NO_MEMORY, "no memory for statistics");
}

static void trace_pixel(void *user, int thread, int x, int y)
{
    struct pen_batch_room *room = user;
    pen_trace_pixel(room->trace, thread, x, y);
}

/* The same with a fault to be tested. */
static void try_pixel(void *user, int thread, int x, int y)
{
    struct pen_batch_room *room = user;
    if (room->trace)
        pen_trace_pixel(room->trace, thread, x, y);
    if (!room->fault->pixel(room->fault->user, x, y)) {
        atomic_store_explicit(&room->exhausted, true, memory_order_relaxed);
        pen_heartbeat_stop(room->heart);
    }
}

pen_batch_pixel_fn *pen_batch_look_on(struct pen_batch_room *room)
{
    const char *name = json_string_value(json_object_get(room->plan.request, "name"));
    atomic_store_explicit(&room->exhausted, false, memory_order_relaxed);
    if (room->fault && room->fault->wanted(room->fault->user, name))
        return try_pixel;
    return room->trace ? trace_pixel : NULL;
}

bool pen_batch_looked(struct pen_batch_room *room, bool ok, struct pen_status *st)
{
    if (room->trace)
        pen_trace_idle(room->trace);
    if (!ok && atomic_load_explicit(&room->exhausted, memory_order_relaxed))
        return pen_fail(st, PEN_NO_MEMORY, "out of memory while rendering");
    return ok;
}

/* Renders; the pixels are packed on the way. */
static bool run_task(struct pen_batch_room *room, const struct pen_render_task *task,
                     struct pen_render_stats *stats, struct pen_status *st)
{
    struct pen_tile_run run = {task->settings, task->first_tile, task->tile_count, task->rgb};
    if (!pen_packing_begin(room->packing, &run, st))
        return false;
    bool ok = pen_render_run(room->pool, task, stats, st);
    if (!ok)
        pen_packing_drop(room->packing);
    return pen_batch_looked(room, ok, st);
}

/* The claim's view in the scene, or -1. */
static int view_of(const struct pen_batch_room *room, const struct pen_claim *claim,
                   const struct pen_scene *scene)
{
    const char *view = pen_job_plan_view(&room->plan, claim->view);
    return view ? pen_scene_find_view(scene, view) : -1;
}

static bool run_tiles(struct pen_batch_room *room, const struct pen_claim *claim,
                      const struct pen_scene *scene, struct pen_render_stats *stats,
                      struct pen_status *st)
{
    const struct pen_settings *s = &room->plan.settings;
    struct pen_render_task task = {.scene = scene,
                                   .view = view_of(room, claim, scene),
                                   .settings = s,
                                   .first_tile = claim->first_tile,
                                   .tile_count = claim->tile_count,
                                   .rgb = room->image,
                                   .cancel = pen_heartbeat_flag(room->heart),
                                   .tile_done = pen_packing_tile_done,
                                   .user = room->packing,
                                   .pixel_begins = pen_batch_look_on(room),
                                   .pixel_user = room,
                                   .keep_tile_ms = true};
    if (task.view < 0)
        return pen_fail(st, PEN_INTERNAL, "the scene has no view %d", claim->view);
    return run_task(room, &task, stats, st);
}

static bool take_packed(struct pen_batch_room *room, struct pen_batch_work *work,
                        struct pen_status *st)
{
    int64_t begin_ns = pen_clock_ns();
    bool ok = pen_packing_end(room->packing, &work->result.encoded, st);
    room->store_ms += ms_since(begin_ns);
    return ok;
}

static bool measure(const struct pen_batch_room *room, const struct pen_claim *claim,
                    const struct pen_scene *scene, struct pen_scene_precision *precision)
{
    const struct pen_settings *s = &room->plan.settings;
    return pen_scene_precision(scene, view_of(room, claim, scene), s->width, s->height, precision);
}

static bool render(struct pen_batch_room *room, const struct pen_claim *claim,
                   struct pen_batch_work *work, struct pen_status *st)
{
    const struct pen_settings *s = &room->plan.settings;
    struct pen_scene_times times;
    struct pen_render_stats stats;
    struct pen_scene_precision precision;
    const struct pen_scene *scene = pen_scene_cache_get(
        room->scenes, room->store, claim, (enum pen_accelerator)s->accelerator, &times, st);
    if (!scene || !make_room(room, st) || !run_tiles(room, claim, scene, &stats, st))
        return false;
    work->result.pixels = claim->pixels;
    struct pen_stats_input in = {.parse_ms = times.parse_ms,
                                 .build_ms = times.build_ms,
                                 .render = &stats,
                                 .accel = pen_accel_get_stats(scene->accel)};
    if (measure(room, claim, scene, &precision))
        in.precision = &precision;
    bool ok =
        claim->view_batches > 1 ||
        encode(room, (struct pen_film){s->width, s->height, room->image}, work, &in.encode_ms, st);
    if (ok)
        ok = take_packed(room, work, st);
    else
        pen_packing_drop(room->packing);
    json_t *json = ok ? pen_stats_json(&in) : NULL;
    if (ok)
        json = pen_json_with(json, "tile_ms", pen_tile_times(stats.tile_ms, stats.tile_count));
    free(stats.tile_ms);
    return ok && pen_batch_write_stats(room, json, work, st);
}

static bool assemble(struct pen_batch_room *room, const struct pen_claim *claim,
                     struct pen_batch_work *work, struct pen_status *st)
{
    const struct pen_settings *s = &room->plan.settings;
    double encode_ms = 0;
    int64_t filled = 0;
    if (!make_room(room, st))
        return false;
    struct pen_film film = {s->width, s->height, room->image};
    int64_t begin_ns = pen_clock_ns();
    bool ok = pen_canvas_load(room->store, claim->job_id, claim->view, s, &film, NULL, &filled, st);
    room->store_ms += ms_since(begin_ns);
    if (ok && filled != (int64_t)s->width * s->height)
        ok =
            pen_fail(st, PEN_STORAGE, "job %s lacks pixels of view %d", claim->job_id, claim->view);
    ok = ok && encode(room, film, work, &encode_ms, st);
    return ok && pen_batch_write_stats(
                     room, json_pack("{s:{s:o}}", "timing", "encode_ms", pen_figure(encode_ms)),
                     work, st);
}

bool pen_batch_do(struct pen_batch_room *room, const struct pen_claim *claim,
                  struct pen_batch_work *work, struct pen_status *st)
{
    *work = (struct pen_batch_work){0};
    pen_memory_peak_reset();
    bool ok = load_plan(room, claim, st);
    if (ok && claim->kind == PEN_BATCH_STUDY)
        ok = pen_batch_study(room, claim, work, st);
    else if (ok)
        ok = claim->kind == PEN_BATCH_RENDER ? render(room, claim, work, st)
                                             : assemble(room, claim, work, st);
    if (!ok)
        pen_batch_work_release(work);
    return ok;
}
