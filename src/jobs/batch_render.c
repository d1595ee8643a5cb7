/* SPDX-License-Identifier: MIT */
/* Renders tiles, and assembles the picture of a view:
 *   - A view of one batch: the worker that renders it encodes the rows of the picture as they are
 *     finished. It commits pixels and picture in one transaction.
 *   - A view of several batches: after the last of them, an assemble batch reads the committed
 *     pixels and encodes the picture.
 *
 * The planned size of batches (batch_layout.c) is a guess; mirrors and glass may exceed it a
 * hundredfold. So after some time a batch begins no more tiles. The finished tiles are committed,
 * and the others become a batch of their own. So other jobs are served in time, and a job that
 * takes too long is noticed. */
#include "jobs/internal/batch.h"

#include <sodium.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "io/figures.h"
#include "io/stats_json.h"
#include "jobs/internal/jobs.h"
#include "jobs/internal/stats.h"
#include "jobs/internal/view_pixels.h"

/* Grows the image, if necessary, to hold a view of the job. */
static bool reserve_image(struct pen_batch_context *context, struct pen_status *st)
{
    size_t wanted =
        (size_t)context->request.settings.width * (size_t)context->request.settings.height;
    if (wanted <= context->image_pixels)
        return true;
    free(context->image);
    context->image_pixels = 0;
    context->image = wanted < SIZE_MAX / 3 / sizeof *context->image
                         ? pen_memory_large(wanted * 3 * sizeof *context->image)
                         : NULL;
    if (!context->image)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for %zu pixels", wanted);
    context->image_pixels = wanted;
    return true;
}

/* Returns the context's image as a film of the job's size. */
static struct pen_film film_of(const struct pen_batch_context *context)
{
    return (struct pen_film){.width = context->request.settings.width,
                             .height = context->request.settings.height,
                             .rgb = context->image};
}

/* Begins the picture of the batch's view, if the batch has all its tiles. */
static bool begin_picture(struct pen_batch_context *context, int tiles,
                          struct pen_batch_output *output, struct pen_status *st)
{
    struct pen_film film = film_of(context);
    if (context->claim->view_batches > 1 || tiles < context->claim->tile_count)
        return true;
    context->picture = pen_view_png_begin(&film, &context->request.settings, &output->artefact, st);
    return context->picture != NULL;
}

static void encode_rows(void *user, int rows)
{
    struct pen_batch_context *context = user;
    pen_png_rows(context->picture, rows);
}

/* Ends the picture, if the batch has one; the last tile was finished at done_ns. */
static bool end_picture(struct pen_batch_context *context, struct pen_batch_output *output,
                        int64_t done_ns, double *encode_ms, struct pen_status *st)
{
    if (!context->picture)
        return true;
    if (!pen_png_end(context->picture, st))
        return false;
    pen_batch_set_artefact(output, "beauty", "png");
    *encode_ms = pen_ms_since(done_ns);
    return true;
}

/* Renders the first `count` tiles of the claim. */
static bool run_tiles(struct pen_batch_context *context, const struct pen_scene *scene, int view,
                      int count, struct pen_render_stats *stats, struct pen_status *st)
{
    const struct pen_settings *s = &context->request.settings;
    struct pen_render_task task = {.scene = scene,
                                   .view = view,
                                   .settings = s,
                                   .first_tile = context->claim->first_tile,
                                   .tile_count = count,
                                   .rgb = context->image,
                                   .cancel = pen_heartbeat_cancel_flag(context->heart),
                                   .tile_done = pen_batch_tile_done,
                                   .user = context,
                                   .rows_done = context->picture ? encode_rows : NULL,
                                   .rows_user = context,
                                   .pixel_begins = pen_batch_pixel_hook(context),
                                   .pixel_user = context,
                                   /* After a crash, this finds the pixel if it crashes again. */
                                   .pixel_by_pixel = context->claim->attempt > 1,
                                   .keep_tile_ms = true};
    if (!pen_settings_adaptive(s)) {
        /* After a crash, the layers come last. */
        const bool last = context->claim->attempt <= 1;
        pen_batch_bound(context, last ? 1 : 1 / (1 + pen_batch_layer_work(context)));
        task.pause = pen_batch_is_long;
        task.pause_user = context;
        pen_batch_work_begin(context, count, last ? PEN_WORK_PIXELS_LAST : PEN_WORK_PIXELS_FIRST);
    }
    const bool ok = pen_settings_adaptive(s) ? pen_batch_rounds(context, &task, stats, st)
                                             : pen_render_run(context->pool, &task, stats, st);
    return pen_batch_hook_done(context, ok, st);
}

/* Reduces the result to the first tiles, if not all tiles were begun. Returns true if it did. */
static bool cut_result(struct pen_batch_context *context, const struct pen_render_stats *stats,
                       struct pen_batch_output *output)
{
    const int tiles = (int)stats->tile_count;
    output->result.pixels = context->claim->pixels;
    output->result.work = (int64_t)(PEN_WORK_ALL * pen_batch_work_of(context, tiles));
    if (tiles >= context->claim->tile_count)
        return false;
    pen_png_free(context->picture);
    context->picture = NULL;
    pen_buf_release(&output->artefact);
    output->result.part_tiles = tiles;
    output->result.pixels =
        pen_tiles_pixels(&context->request.settings, context->claim->first_tile, tiles);
    return true;
}

/* Copies the pixels of the claim's first tiles out of the image, in the order of the store. */
static bool take_pixels(const struct pen_batch_context *context, int tiles,
                        struct pen_batch_output *output, struct pen_status *st)
{
    const size_t values = 3 * (size_t)output->result.pixels;
    output->result.rgb = output->rgb = pen_memory_large(values * sizeof *output->rgb);
    if (!output->rgb)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the pixels of a batch");
    pen_tiles_gather(&context->request.settings, context->claim->first_tile, tiles, context->image,
                     output->rgb);
    return true;
}

/* Logs that samples are missing in the picture, or that objects may be missing. The job's
 * statistics have this too. */
static void warn_of_missing(const struct pen_claim *claim, const struct pen_render_stats *stats)
{
    struct pen_log_about about = pen_claim_about(claim);
    char text[PEN_MSG_BYTES];
    if (pen_dropped_warning(&stats->rays, text, sizeof text))
        pen_log_about(PEN_LOG_WARN, &about, "view %d: %s", claim->view, text);
    if (pen_unproven_warning(&stats->adaptive, text, sizeof text))
        pen_log_about(PEN_LOG_WARN, &about, "view %d: %s", claim->view, text);
}

/* Returns the time for the rounds of a job with a budget, so that its commit is in time.
 * Compressing, encoding and storing take about half a microsecond a pixel. Returns 0 without a
 * budget. */
static int64_t time_for_rounds(const struct pen_batch_context *context)
{
    const double seconds = context->request.budget_s;
    const struct pen_settings *s = &context->request.settings;
    const double left_ns = seconds * 1e9 - 500.0 * s->width * s->height;
    if (seconds <= 0)
        return 0;
    return left_ns > 1 ? (int64_t)left_ns : 1;
}

/* Stores the layers of the rendered tiles. If they are the whole view, also makes the audit that
 * the job may ask for. */
static bool make_extras(struct pen_batch_context *context, bool whole,
                        const struct pen_render_stats *stats, struct pen_audit *audit,
                        bool *audited, struct pen_status *st)
{
    const struct pen_film film = film_of(context);
    const bool rounds = context->adaptive != NULL;
    if (rounds ? !pen_batch_layers_after_rounds(context, stats, st)
               : !pen_batch_layers_store(context, (int)stats->tile_count, st))
        return false;
    return !whole || pen_batch_audit(context, &film, stats, audit, audited, st);
}

static bool render(struct pen_batch_context *context, struct pen_batch_output *output,
                   struct pen_status *st)
{
    const struct pen_settings *s = &context->request.settings;
    const struct pen_claim *claim = context->claim;
    char scene_sha256[2 * sizeof claim->scene_sha256 + 1];
    struct pen_scene_times times;
    struct pen_render_stats stats;
    struct pen_scene_precision precision;
    struct pen_audit audit;
    bool audited = false;
    double layers_ms = 0;
    int tiles = claim->tile_count;
    /* After a crash the pixels come first: if it crashes again, the trace has the pixel. */
    const bool layers_first = claim->attempt <= 1;
    int view;
    const struct pen_scene *scene = pen_batch_scene(context, &view, &times, st);
    if (!scene || !pen_batch_estimate(context, scene, view, st) || !reserve_image(context, st))
        return false;
    pen_batch_bound(context, 1);
    if (layers_first)
        pen_batch_work_begin(context, tiles, PEN_WORK_LAYERS);
    if ((layers_first && !pen_batch_layers_make(context, true, &tiles, &layers_ms, st)) ||
        !begin_picture(context, tiles, output, st) ||
        !run_tiles(context, scene, view, tiles, &stats, st))
        return false;
    double encode_ms = 0;
    const bool part = cut_result(context, &stats, output);
    bool ok = end_picture(context, output, stats.done_ns, &encode_ms, st);
    tiles = (int)stats.tile_count;
    if (ok && !layers_first)
        ok = pen_batch_layers_make(context, false, &tiles, &layers_ms, st);
    pen_batch_paced(context, (double)output->result.work / PEN_WORK_ALL,
                    layers_ms + stats.render_ms);
    warn_of_missing(claim, &stats);
    const uint64_t rays =
        stats.rays.primary + stats.rays.shadow + stats.rays.reflection + stats.rays.transmission;
    pen_store_count(PEN_COUNT_RAYS, rays);
    if (stats.render_ms > 0)
        context->rays_per_s = (double)rays / stats.render_ms * 1e3;
    struct pen_stats_input in = {.parse_ms = times.parse_ms,
                                 .build_ms = times.build_ms,
                                 .encode_ms = encode_ms,
                                 .render = &stats,
                                 .accel = pen_accel_get_stats(scene->accel),
                                 .scene = scene,
                                 .scene_bytes = pen_scene_bytes(scene),
                                 .settings = s,
                                 .scene_sha256 = scene_sha256};
    sodium_bin2hex(scene_sha256, sizeof scene_sha256, claim->scene_sha256,
                   sizeof claim->scene_sha256);
    if (pen_scene_precision(scene, view, s->width, s->height, &precision))
        in.precision = &precision;
    const bool whole = claim->view_batches <= 1 && !part;
    ok = ok && make_extras(context, whole, &stats, &audit, &audited, st) &&
         take_pixels(context, tiles, output, st);
    in.audit = audited ? &audit : NULL;
    ok = ok && pen_batch_write_render_stats(context, &in, output, st);
    free(stats.tile_ms);
    return ok;
}

bool pen_batch_render(struct pen_batch_context *context, struct pen_batch_output *output,
                      struct pen_status *st)
{
    context->budget_ns = time_for_rounds(context);
    bool ok = render(context, output, st);
    pen_batch_work_end(context);
    pen_png_free(context->picture);
    context->picture = NULL;
    pen_adaptive_free(context->adaptive);
    context->adaptive = NULL;
    pen_batch_layers_end(context);
    return ok;
}

static bool assemble(struct pen_batch_context *context, unsigned char *begins,
                     struct pen_batch_output *output, struct pen_status *st)
{
    const struct pen_settings *s = &context->request.settings;
    int64_t filled = 0;
    struct pen_film film = film_of(context);
    int64_t begin_ns = pen_clock_ns();
    bool ok = pen_view_pixels_load(context->store, context->claim->job_id, context->claim->view, s,
                                   &film, NULL, begins, &filled, st);
    context->store_ms += pen_ms_since(begin_ns);
    if (ok && filled != (int64_t)s->width * s->height)
        ok = pen_fail(st, PEN_STORAGE, "job %s lacks pixels of view %d", context->claim->job_id,
                      context->claim->view);
    begin_ns = pen_clock_ns();
    if (!ok || !pen_view_encode(&film, s, "png", &output->artefact, st))
        return false;
    pen_batch_set_artefact(output, "beauty", "png");
    const double encode_ms = pen_ms_since(begin_ns);
    struct pen_audit audit;
    bool audited;
    if (!pen_batch_layers_assemble(context, begins, st) ||
        !pen_batch_audit(context, &film, NULL, &audit, &audited, st))
        return false;
    json_t *stats = json_pack("{s:{s:o}}", "timing", "encode_ms", pen_figure(encode_ms));
    if (audited)
        stats = pen_json_with(stats, "audit", pen_stats_audit(&audit));
    return pen_batch_write_stats(context, stats, output, st);
}

bool pen_batch_assemble(struct pen_batch_context *context, struct pen_batch_output *output,
                        struct pen_status *st)
{
    const struct pen_settings *s = &context->request.settings;
    const size_t tiles = (size_t)pen_tile_count(s->width, s->height, s->tile);
    if (!reserve_image(context, st))
        return false;
    unsigned char *begins = calloc(tiles, 1);
    const bool ok = begins ? assemble(context, begins, output, st)
                           : pen_fail(st, PEN_NO_MEMORY, "no memory for %zu tiles", tiles);
    free(begins);
    return ok;
}
