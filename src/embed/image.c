/* SPDX-License-Identifier: MIT */
/* Images: rendering one view, and reading the result. */
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "embed/internal/embed.h"
#include "film/encode.h"
#include "io/stats_json.h"
#include "render/render.h"
#include "render/transfer.h"

enum { THREADS_MAX = 1024 };
static const int64_t poll_interval_ns = 10000000;

struct penumbra_image {
    struct pen_film *film;
    enum pen_transfer transfer;
    struct pen_buf statistics; /* JSON text */
};

/* One call of penumbra_render. */
struct run {
    struct penumbra_render_options options;
    pthread_mutex_t calling;   /* held while a callback of the caller runs */
    atomic_bool cancelled;     /* relaxed: only its value matters */
    atomic_llong next_poll_ns; /* relaxed: one poll more or less does no harm */
    int tiles, tiles_done;     /* guarded by pen_render_run, which calls tile_done one at a time */
};

/* Calls `cancel` and stores its result. The lock is held. */
static void poll_locked(struct run *run)
{
    if (!run->options.cancel)
        return;
    if (run->options.cancel(run->options.user))
        atomic_store_explicit(&run->cancelled, true, memory_order_relaxed);
    atomic_store_explicit(&run->next_poll_ns, pen_clock_ns() + poll_interval_ns,
                          memory_order_relaxed);
}

static void tile_done(void *user, struct pen_rect rect)
{
    struct run *run = user;
    (void)rect;
    run->tiles_done++;
    pthread_mutex_lock(&run->calling);
    if (run->options.progress)
        run->options.progress(run->options.user, (double)run->tiles_done / run->tiles);
    poll_locked(run);
    pthread_mutex_unlock(&run->calling);
}

static void pixel_begins(void *user, int thread, int x, int y)
{
    struct run *run = user;
    (void)thread, (void)x, (void)y;
    if (pen_clock_ns() < atomic_load_explicit(&run->next_poll_ns, memory_order_relaxed) ||
        pthread_mutex_trylock(&run->calling) != 0)
        return;
    poll_locked(run);
    pthread_mutex_unlock(&run->calling);
}

static bool take_options(const struct penumbra_render_options *given, struct run *run,
                         struct pen_status *st)
{
    if (given && !pen_embed_take(given, &run->options, sizeof run->options))
        return pen_fail(st, PEN_USAGE,
                        "struct penumbra_render_options: size is too small, or a member that "
                        "version %s does not know is not zero",
                        PEN_VERSION);
    if (run->options.threads < 0 || run->options.threads > THREADS_MAX)
        return pen_fail(st, PEN_USAGE, "threads: found %d, allowed is 0 to %d",
                        run->options.threads, THREADS_MAX);
    return true;
}

static bool find_view(const struct penumbra_scene *scene, const char *name, int *view,
                      struct pen_status *st)
{
    const struct pen_scene_desc *desc = &scene->desc;
    *view = 0;
    if (!name)
        return true;
    for (uint32_t i = 0; i < desc->view_count; i++) {
        *view = (int)i;
        if (strcmp(desc->views[i].name, name) == 0)
            return true;
    }
    return pen_fail(st, PEN_NOT_FOUND, "no view \"%s\", the first is \"%s\"", name,
                    desc->views[0].name);
}

/* Freezes the scene, unless it is frozen with the accelerator that the settings ask for. */
static bool freeze(struct penumbra_scene *scene, int threads, struct pen_status *st)
{
    enum pen_accelerator kind = (enum pen_accelerator)scene->desc.settings.accelerator;
    if (scene->frozen && scene->built == kind)
        return true;
    int64_t begun = pen_clock_ns();
    scene->desc.build_threads = threads > 0 ? threads : pen_cpu_count();
    struct pen_scene *frozen = pen_scene_freeze(&scene->desc, kind, 0, st);
    if (!frozen) {
        struct pen_limits limits = pen_limits_default();
        pen_text_locate((const char *)scene->xml.data, scene->xml.bytes, &limits, st);
        return false;
    }
    pen_scene_free(scene->frozen);
    scene->frozen = frozen;
    scene->built = kind;
    scene->build_ms = (double)(pen_clock_ns() - begun) * 1e-6;
    return true;
}

static bool write_statistics(struct penumbra_scene *scene, int view,
                             const struct pen_render_stats *stats, struct pen_buf *out,
                             struct pen_status *st)
{
    const struct pen_settings *s = &scene->desc.settings;
    struct pen_scene_precision precision;
    bool measured = pen_scene_precision(scene->frozen, view, s->width, s->height, &precision);
    struct pen_stats_input in = {.parse_ms = scene->parse_ms,
                                 .build_ms = scene->build_ms,
                                 .total_ms = scene->parse_ms + scene->build_ms + stats->render_ms,
                                 .render = stats,
                                 .accel = pen_accel_get_stats(scene->frozen->accel),
                                 .precision = measured ? &precision : NULL,
                                 .scene = scene->frozen,
                                 .scene_bytes =
                                     pen_scene_bytes(scene->frozen) + pen_arena_used(scene->arena)};
    json_t *json = pen_stats_json(&in);
    bool ok = json && pen_json_write(json, out);
    json_decref(json);
    return ok || pen_fail(st, PEN_NO_MEMORY, "out of memory for the statistics");
}

/* Renders the frozen scene into the image's film. */
static bool render_film(struct penumbra_scene *scene, int view, struct run *run,
                        struct penumbra_image *image, struct pen_status *st)
{
    const struct pen_settings *settings = &scene->desc.settings;
    struct pen_thread_pool *pool = pen_thread_pool_new(run->options.threads, st);
    if (!pool)
        return false;
    struct pen_render_task task = {.scene = scene->frozen,
                                   .view = view,
                                   .settings = settings,
                                   .tile_count = -1,
                                   .rgb = image->film->rgb,
                                   .cancel = &run->cancelled,
                                   .tile_done = tile_done,
                                   .user = run,
                                   .pixel_begins = run->options.cancel ? pixel_begins : NULL,
                                   .pixel_user = run,
                                   .keep_tile_ms = true};
    struct pen_render_stats stats;
    run->tiles = pen_tile_count(settings->width, settings->height, settings->tile);
    bool ok = pen_render_run(pool, &task, &stats, st);
    pen_thread_pool_free(pool);
    if (ok) {
        ok = write_statistics(scene, view, &stats, &image->statistics, st);
        free(stats.tile_ms);
    }
    return ok;
}

static bool render(struct penumbra_scene *scene, const char *view_name, struct run *run,
                   struct penumbra_image *image, struct pen_status *st)
{
    const struct pen_settings *settings = &scene->desc.settings;
    struct pen_limits limits = pen_limits_default();
    int view;
    if (!find_view(scene, view_name, &view, st) ||
        !pen_limits_check(&limits, &scene->desc, settings, 1, "", st) ||
        !freeze(scene, run->options.threads, st) ||
        !(image->film = pen_film_new(settings->width, settings->height, st)) ||
        !render_film(scene, view, run, image, st))
        return false;
    image->transfer = pen_settings_transfer(settings);
    scene->parse_ms = scene->build_ms = 0;
    return true;
}

struct penumbra_image *penumbra_render(struct penumbra_scene *scene, const char *view,
                                       const struct penumbra_render_options *options,
                                       struct penumbra_errors **errors)
{
    struct run run = {.calling = PTHREAD_MUTEX_INITIALIZER};
    struct pen_status st;
    struct penumbra_image *image = calloc(1, sizeof *image);
    struct pen_embed_caller caller;
    pen_embed_enter(&caller);
    bool ok = image ? take_options(options, &run, &st) && render(scene, view, &run, image, &st)
                    : pen_fail(&st, PEN_NO_MEMORY, "out of memory for an image");
    pen_embed_leave(&caller);
    pthread_mutex_destroy(&run.calling);
    if (ok)
        return image;
    penumbra_image_free(image);
    pen_embed_fail(errors, &st);
    return NULL;
}

const float *penumbra_image_pixels(const struct penumbra_image *image, int *width, int *height)
{
    if (width)
        *width = image->film->width;
    if (height)
        *height = image->film->height;
    return image->film->rgb;
}

static bool encode(const struct penumbra_image *image, const char *format, struct pen_buf *out,
                   struct pen_status *st)
{
    struct pen_png_options options = {.bits = 8, .transfer = image->transfer};
    if (strcmp(format, "pfm") == 0)
        return pen_pfm_write(image->film, out, st);
    if (strcmp(format, "png16") == 0)
        options.bits = 16;
    else if (strcmp(format, "png") != 0)
        return pen_fail(st, PEN_USAGE, "format: found \"%s\", allowed is png, png16 or pfm",
                        format);
    return pen_png_write(image->film, &options, out, st);
}

void *penumbra_image_encode(const struct penumbra_image *image, const char *format, size_t *bytes,
                            struct penumbra_errors **errors)
{
    struct pen_buf out = {0};
    struct pen_status st;
    struct pen_embed_caller caller;
    pen_embed_enter(&caller);
    bool ok = encode(image, format, &out, &st);
    pen_embed_leave(&caller);
    if (ok) {
        *bytes = out.bytes;
        return pen_embed_detach(&out);
    }
    pen_buf_release(&out);
    pen_embed_fail(errors, &st);
    return NULL;
}

const char *penumbra_image_statistics(const struct penumbra_image *image)
{
    return (const char *)image->statistics.data;
}

void penumbra_image_free(struct penumbra_image *image)
{
    if (!image)
        return;
    pen_film_free(image->film);
    pen_buf_release(&image->statistics);
    free(image);
}
