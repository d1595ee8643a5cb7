/* SPDX-License-Identifier: MIT */
/* The layers of a view beside its picture. The store has them as PFM files in the end.
 *
 * `cost` takes several times as long as the pixels. So a batch makes the layers of its own tiles
 * before their pixels. If there is no time for all tiles, the first layer decides how many tiles
 * the batch has. If a view has several batches, each batch stores its tiles of each layer as a
 * part, whose name has the first tile. The batch that assembles the picture makes the files from
 * the parts. If the store has no space for a part, the part is made again. What a batch stored
 * before its commit failed is replaced by the worker that repeats the batch.
 *
 * With a target error, `cost` depends on the final number of samples of each pixel. So it is made
 * after the rounds, in their batch. Its tiles are kept with the state of the last round, as the
 * rounds are, and yield to a batch that comes first. */
#include "jobs/internal/batch.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "jobs/internal/view_pixels.h"
#include "render/layers.h"

static bool is_wanted(const struct pen_batch_context *context, enum pen_layer layer)
{
    return layer != PEN_LAYER_BEAUTY && (context->request.layers >> layer & 1);
}

double pen_batch_layer_work(const struct pen_batch_context *context)
{
    double work = 0;
    for (int layer = 0; layer < PEN_LAYER_COUNT; layer++)
        if (is_wanted(context, (enum pen_layer)layer))
            work += pen_layer_work((enum pen_layer)layer, context->request.cost);
    return work;
}

/* The rows of tiles that contain a run of tiles, as a separate image: its settings, its first row
 * in the view, and the number that the run's first tile has in it. */
struct strip {
    struct pen_settings settings;
    int first_row, first;
};

static struct strip strip_of(const struct pen_settings *s, int first, int count)
{
    const int across = pen_tile_count(s->width, 1, s->tile);
    const struct pen_rect top = pen_tile_rect(s->width, s->height, s->tile, first),
                          last = pen_tile_rect(s->width, s->height, s->tile, first + count - 1);
    struct strip strip = {.settings = *s, .first_row = top.y, .first = first % across};
    strip.settings.height = last.y + last.height - top.y;
    return strip;
}

/* Makes tiles of a layer in a film that begins with this row of the view. */
static bool render_tiles(struct pen_batch_context *context, enum pen_layer layer,
                         struct pen_film *film, int first_row, struct pen_layer_tiles *tiles,
                         struct pen_status *st)
{
    struct pen_scene_times times;
    struct pen_layer_task task = {.settings = &context->request.settings,
                                  .layer = layer,
                                  .cost = context->request.cost,
                                  .rgb = film->rgb,
                                  .first_row = first_row,
                                  .cancel = pen_heartbeat_cancel_flag(context->heart),
                                  .adaptive = context->adaptive};
    task.scene = pen_batch_scene(context, &task.view, &times, st);
    return task.scene && pen_layer_render_tiles(context->pool, &task, tiles, st);
}

bool pen_batch_layers_make(struct pen_batch_context *context, bool bounded, int *tiles, double *ms,
                           struct pen_status *st)
{
    const struct pen_settings *s = &context->request.settings;
    const int64_t begun_ns = pen_clock_ns();
    bool pauses = bounded;
    for (int i = 0; i < PEN_LAYER_COUNT && !pen_settings_adaptive(s); i++) {
        const enum pen_layer layer = (enum pen_layer)i;
        if (!is_wanted(context, layer))
            continue;
        const struct strip strip =
            strip_of(s, context->claim->first_tile, context->claim->tile_count);
        struct pen_layer_tiles run = {.first = context->claim->first_tile,
                                      .count = *tiles,
                                      .pause = pauses ? pen_batch_is_long : NULL,
                                      .pause_user = context};
        context->layer[i] = pen_film_new(s->width, strip.settings.height, st);
        if (!context->layer[i] ||
            !render_tiles(context, layer, context->layer[i], strip.first_row, &run, st))
            return false;
        *tiles = run.count;
        pauses = false;
    }
    *ms = pen_ms_since(begun_ns);
    return true;
}

void pen_batch_layers_end(struct pen_batch_context *context)
{
    for (int layer = 0; layer < PEN_LAYER_COUNT; layer++) {
        pen_film_free(context->layer[layer]);
        context->layer[layer] = NULL;
    }
}

static bool store_file(struct pen_batch_context *context, enum pen_layer layer,
                       const struct pen_film *film, struct pen_status *st)
{
    struct pen_buf file = {0};
    const bool ok = pen_pfm_write(film, &file, st) &&
                    pen_batch_store(context, pen_layer_name(layer), "pfm", &file, st);
    pen_buf_release(&file);
    return ok;
}

/* The head of a part; the values of its tiles follow. Layers of one number for each pixel have that
 * number once. */
struct part_head {
    uint32_t tiles;
    uint32_t picture; /* after rounds, a hash of the picture, which identifies the rounds; else 0 */
};

struct part_name {
    char text[24];
};

static struct part_name name_of(enum pen_layer layer, int first)
{
    struct part_name name;
    snprintf(name.text, sizeof name.text, "%s-%d", pen_layer_name(layer), first);
    return name;
}

static size_t values_of_pixel(enum pen_layer layer)
{
    return layer == PEN_LAYER_NORMAL || layer == PEN_LAYER_ALBEDO ? 3 : 1;
}

/* Appends the part of these tiles, which are in the rows of the film. */
static bool write_part(const struct strip *strip, enum pen_layer layer, const struct pen_film *film,
                       const struct part_head *head, struct pen_buf *part, struct pen_status *st)
{
    const struct pen_settings *s = &strip->settings;
    const int count = (int)head->tiles;
    const size_t pixels = (size_t)pen_tiles_pixels(s, strip->first, count),
                 each = values_of_pixel(layer);
    float *values = malloc(pixels * 3 * sizeof *values);
    if (values) {
        pen_tiles_gather(s, strip->first, count, film->rgb, values);
        for (size_t i = 0; each == 1 && i < pixels; i++)
            values[i] = values[3 * i];
        pen_buf_reserve(part, sizeof *head + pixels * each * sizeof *values);
        pen_buf_add(part, head, sizeof *head);
        pen_buf_add(part, values, pixels * each * sizeof *values);
    }
    free(values);
    return (values && !part->failed) || pen_fail(st, PEN_NO_MEMORY, "no memory for a layer");
}

/* Puts a part into a film of the whole view. The part must be of this picture. It must have
 * head->tiles tiles; if that is 0, any number, which head->tiles becomes. Fails: PEN_NOT_FOUND
 * (another part), PEN_NO_MEMORY. */
static bool place_part(const struct pen_settings *s, enum pen_layer layer,
                       const struct pen_buf *part, int first, struct part_head *head,
                       struct pen_film *film, struct pen_status *st)
{
    const int left = pen_tile_count(s->width, s->height, s->tile) - first;
    const size_t each = values_of_pixel(layer);
    struct part_head has = {.tiles = 0};
    if (part->bytes >= sizeof has)
        memcpy(&has, part->data, sizeof has);
    const bool fits = has.tiles > 0 && left > 0 && has.tiles <= (uint32_t)left &&
                      (head->tiles == 0 || has.tiles == head->tiles) &&
                      has.picture == head->picture;
    const size_t pixels = fits ? (size_t)pen_tiles_pixels(s, first, (int)has.tiles) : 0;
    if (!fits || part->bytes - sizeof has != pixels * each * sizeof(float))
        return pen_fail(st, PEN_NOT_FOUND, "a part that is not of its tiles");
    float *values = malloc(pixels * 3 * sizeof *values);
    if (!values)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a layer");
    memcpy(values, part->data + sizeof has, part->bytes - sizeof has);
    for (size_t i = pixels; each == 1 && i-- > 0;)
        values[3 * i] = values[3 * i + 1] = values[3 * i + 2] = values[i];
    pen_tiles_scatter(s, first, (int)has.tiles, values, film->rgb);
    free(values);
    head->tiles = has.tiles;
    return true;
}

/* Reads a part as place_part does. *found is false if there is no usable part. */
static bool read_part(struct pen_batch_context *context, enum pen_layer layer, int first,
                      struct part_head *head, struct pen_film *film, bool *found,
                      struct pen_status *st)
{
    struct pen_buf part = {0};
    *found =
        pen_store_kept(context->store, context->claim, name_of(layer, first).text, &part, st) &&
        place_part(&context->request.settings, layer, &part, first, head, film, st);
    pen_buf_release(&part);
    return *found || st->code == PEN_NOT_FOUND;
}

/* Keeps a part, unless the store has no space for it. */
static bool keep_part(struct pen_batch_context *context, enum pen_layer layer, int tiles,
                      struct pen_status *st)
{
    struct pen_buf bytes = {0};
    const struct strip strip = strip_of(&context->request.settings, context->claim->first_tile,
                                        context->claim->tile_count);
    const struct part_name name = name_of(layer, context->claim->first_tile);
    const struct part_head head = {.tiles = (uint32_t)tiles};
    bool ok = write_part(&strip, layer, context->layer[layer], &head, &bytes, st);
    if (ok) {
        const struct pen_kept_part part = {
            .name = name.text, .data = bytes.data, .bytes = bytes.bytes};
        const struct pen_kept kept = {.done = -1, .parts = &part, .part_count = 1};
        pen_heartbeat_pause(context->heart);
        ok = pen_store_keep(context->store, context->claim, &kept, NULL, st);
        pen_heartbeat_resume(context->heart);
    }
    pen_buf_release(&bytes);
    return ok || st->code == PEN_STORAGE_FULL;
}

bool pen_batch_layers_store(struct pen_batch_context *context, int tiles, struct pen_status *st)
{
    const bool whole = context->claim->view_batches <= 1 && tiles == context->claim->tile_count;
    bool ok = true;
    for (int i = 0; ok && i < PEN_LAYER_COUNT; i++) {
        const enum pen_layer layer = (enum pen_layer)i;
        if (context->layer[i])
            ok = whole ? store_file(context, layer, context->layer[i], st)
                       : keep_part(context, layer, tiles, st);
    }
    return ok;
}

/* Puts the parts of a layer together. `begins` marks the tiles that begin a batch. Tiles of batches
 * without a part are rendered. */
static bool assemble(struct pen_batch_context *context, enum pen_layer layer,
                     const unsigned char *begins, struct pen_film *film, struct pen_status *st)
{
    const struct pen_settings *s = &context->request.settings;
    const int tiles = pen_tile_count(s->width, s->height, s->tile);
    for (int first = 0, end = 0; first < tiles; first = end) {
        bool found;
        do
            end++;
        while (end < tiles && !begins[end]);
        struct part_head head = {.tiles = (uint32_t)(end - first)};
        if (!read_part(context, layer, first, &head, film, &found, st))
            return false;
        struct pen_layer_tiles missing = {.first = first, .count = end - first};
        if (!found && !render_tiles(context, layer, film, 0, &missing, st))
            return false;
    }
    return true;
}

bool pen_batch_layers_assemble(struct pen_batch_context *context, const unsigned char *begins,
                               struct pen_status *st)
{
    const struct pen_settings *s = &context->request.settings;
    bool ok = true;
    for (int i = 0; ok && i < PEN_LAYER_COUNT; i++) {
        const enum pen_layer layer = (enum pen_layer)i;
        if (!is_wanted(context, layer))
            continue;
        struct pen_film *film = pen_film_new(s->width, s->height, st);
        ok = film && assemble(context, layer, begins, film, st) &&
             store_file(context, layer, film, st);
        pen_film_free(film);
    }
    return ok;
}

/* A layer of a view with a target error, which is made after the rounds. */
struct after_rounds {
    struct pen_keeper keeper;
    enum pen_layer layer;
    uint32_t picture; /* as in a part's head */
    struct pen_film *film;
    const struct pen_render_stats *stats; /* of the rounds */
    int done, tiles;                      /* of the layer */
};

/* Keeps the finished tiles. Returns true if the work may go on. */
static bool keep(struct after_rounds *a)
{
    struct pen_batch_context *context = a->keeper.context;
    struct pen_buf bytes = {0};
    struct pen_status ignored;
    const struct part_name name = name_of(a->layer, 0);
    const struct strip whole = strip_of(&context->request.settings, 0, a->tiles);
    const int64_t begun_ns = pen_clock_ns();
    const double work = pen_batch_layer_work(context), share = (double)a->done / a->tiles;
    const struct part_head head = {.tiles = (uint32_t)a->done, .picture = a->picture};
    const bool ok = write_part(&whole, a->layer, a->film, &head, &bytes, &ignored);
    const struct pen_kept_part part = {
        .name = name.text, .data = bytes.data, .bytes = ok ? bytes.bytes : 0};
    const double done = (1 + work * share) / (1 + work) * (double)a->keeper.context->claim->pixels;
    const bool goes_on =
        pen_batch_keep_after_rounds(&a->keeper, a->stats, (int64_t)done, &part, begun_ns);
    pen_buf_release(&bytes);
    return goes_on;
}

/* Makes the tiles that are left. A cheap layer is not interrupted. */
static bool render_after_rounds(struct after_rounds *a, struct pen_status *st)
{
    struct pen_batch_context *context = a->keeper.context;
    const bool is_long = pen_layer_work(a->layer, context->request.cost) > 0;
    while (a->done < a->tiles) {
        struct pen_layer_tiles run = {.first = a->done,
                                      .count = a->tiles - a->done,
                                      .pause = is_long ? pen_batch_keeper_pauses : NULL,
                                      .pause_user = &a->keeper};
        if (!render_tiles(context, a->layer, a->film, 0, &run, st))
            return false;
        a->done += run.count;
        if (a->done < a->tiles && pen_batch_is_overdue(context))
            return pen_batch_fail_overdue(context, st);
        if (a->done < a->tiles && !keep(a))
            return pen_fail(st, PEN_UNAVAILABLE, "interrupted after %d tiles of a layer", a->done);
    }
    return true;
}

bool pen_batch_layers_after_rounds(struct pen_batch_context *context,
                                   const struct pen_render_stats *stats, struct pen_status *st)
{
    const struct pen_settings *s = &context->request.settings;
    const struct pen_film picture = {s->width, s->height, context->image};
    const bool resumes = context->rounds_kept;
    bool ok = true;
    for (int i = 0; ok && i < PEN_LAYER_COUNT; i++) {
        if (!is_wanted(context, (enum pen_layer)i))
            continue;
        const uint32_t hash = (uint32_t)pen_film_hash(&picture);
        struct after_rounds a = {.keeper = pen_keeper_make(context, PEN_KEEP_MS, PEN_ASK_MS),
                                 .layer = (enum pen_layer)i,
                                 .picture = hash,
                                 .film = pen_film_new(s->width, s->height, st),
                                 .stats = stats,
                                 .tiles = pen_tile_count(s->width, s->height, s->tile)};
        struct part_head head = {.picture = hash};
        bool found = false;
        ok = a.film && (!resumes || read_part(context, a.layer, 0, &head, a.film, &found, st));
        a.done = found ? (int)head.tiles : 0;
        ok = ok && render_after_rounds(&a, st) && store_file(context, a.layer, a.film, st);
        pen_film_free(a.film);
    }
    return ok;
}
