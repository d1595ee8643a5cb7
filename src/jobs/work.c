/* SPDX-License-Identifier: MIT */
#include "jobs/internal/work.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "jobs/internal/batch.h"
#include "shade/kernel.h"

/* The weight of an estimate, as a share of the work. */
static const double ESTIMATE_WEIGHT = 0.05;

double pen_work_after(const struct pen_work *work, double ms)
{
    const double more = work->per_ms * ms, begun = work->begun;
    if (more <= begun / 2)
        return work->done + more;
    return work->done + begun * (1 - begun / (4 * more));
}

double pen_work_pace(double work, double ms, double expected_ms)
{
    const double weight = expected_ms > 0 ? ESTIMATE_WEIGHT : 0, all_ms = ms + weight * expected_ms;
    return all_ms > 0 ? (work + weight) / all_ms : 0;
}

int64_t pen_work_estimate_ms(double spent_ms, double done, double per_ms)
{
    return per_ms > 0 ? (int64_t)ceil(fmax(1, spent_ms + fmax(0, 1 - done) / per_ms)) : 0;
}

static double share_of(const struct pen_batch_context *context, int view, int tile)
{
    const struct pen_settings *s = &context->request.settings;
    return pen_cost_map_share(&context->work.map, view,
                              pen_tile_rect(s->width, s->height, s->tile, tile));
}

double pen_batch_work_of(const struct pen_batch_context *context, int tiles)
{
    double work = 0;
    for (int i = 0; i < tiles; i++)
        work += share_of(context, context->claim->view, context->claim->first_tile + i);
    return work;
}

const struct pen_batch_pace *pen_batch_pace_of(const struct pen_batch_context *context)
{
    for (int i = 0; i < PEN_BATCH_PACES; i++)
        if (strcmp(context->work.pace[i].job_id, context->claim->job_id) == 0)
            return &context->work.pace[i];
    return NULL;
}

/* Returns the pace of this worker in the claim's job, including work of the current batch. */
static double pace_with(const struct pen_batch_context *context, double work, double ms)
{
    const struct pen_batch_pace *pace = pen_batch_pace_of(context);
    return pen_work_pace(work + (pace ? pace->work : 0), ms + (pace ? pace->ms : 0),
                         context->work.expected_ms);
}

int64_t pen_batch_expected_ms(const struct pen_batch_context *context, double work)
{
    const double done = (double)context->claim->job_work / PEN_WORK_ALL + work,
                 spent_ms =
                     (double)(context->claim->job_spent_us + context->claim->spent_us) / 1000;
    return pen_work_estimate_ms(spent_ms, done, pace_with(context, 0, 0));
}

static double spent_ms(const struct pen_batch_context *context)
{
    return (double)pen_heartbeat_spent_us(context->heart) / 1000;
}

/* Replaces what is known of the batch; takes tile_done. */
static void know(struct pen_batch_context *context, const struct pen_work *known, double known_ms,
                 unsigned char *tile_done)
{
    pthread_mutex_lock(&context->work.lock);
    free(context->work.tile_done);
    context->work.tile_done = tile_done;
    context->work.known = *known;
    context->work.known_ms = known_ms;
    pthread_mutex_unlock(&context->work.lock);
}

void pen_batch_work_tell(struct pen_batch_context *context, const struct pen_work *work)
{
    know(context, work, spent_ms(context), NULL);
}

void pen_batch_paced(struct pen_batch_context *context, double work, double ms)
{
    struct pen_batch_work *w = &context->work;
    const struct pen_batch_pace *old = pen_batch_pace_of(context);
    const struct pen_work all = {.done = work, .per_ms = pace_with(context, work, ms)};
    if (!pen_settings_adaptive(&context->request.settings)) /* and no tile is being rendered */
        pen_batch_work_tell(context, &all);
    struct pen_batch_pace *pace = &w->pace[old ? old - w->pace : w->pace_next];
    if (!old) {
        w->pace_next = (w->pace_next + 1) % PEN_BATCH_PACES;
        *pace = (struct pen_batch_pace){.ms = 0};
        memcpy(pace->job_id, context->claim->job_id, sizeof pace->job_id);
    }
    pace->work += work;
    pace->ms += ms;
}

void pen_batch_work_end(struct pen_batch_context *context)
{
    const struct pen_work nothing = {0};
    know(context, &nothing, 0, NULL);
}

void pen_batch_work_begin(struct pen_batch_context *context, int tiles, enum pen_work_phase phase)
{
    struct pen_batch_work *w = &context->work;
    const double part = 1 / (1 + pen_batch_layer_work(context)), ms = spent_ms(context),
                 of_layers = (1 - part) * pen_batch_work_of(context, tiles);
    const struct pen_work known = {.done = phase == PEN_WORK_PIXELS_LAST ? of_layers : 0,
                                   .begun = phase == PEN_WORK_LAYERS ? of_layers : 0,
                                   .per_ms = pace_with(context, 0, 0)};
    know(context, &known, ms, NULL);
    w->tiles = tiles;
    w->part = part;
    if (phase != PEN_WORK_PIXELS_LAST)
        w->begun_ms = ms;
    if (phase != PEN_WORK_LAYERS)
        know(context, &known, ms, calloc((size_t)tiles, 1));
}

void pen_batch_tile_done(void *user, struct pen_rect rect)
{
    struct pen_batch_context *context = user;
    struct pen_batch_work *w = &context->work;
    const int edge = context->request.settings.tile,
              columns = pen_tile_count(context->request.settings.width, 1, edge),
              tile = rect.y / edge * columns + rect.x / edge;
    pthread_mutex_lock(&w->lock);
    if (w->tile_done) {
        w->tile_done[tile - context->claim->first_tile] = 1;
        w->known.done += w->part * share_of(context, context->claim->view, tile);
    }
    pthread_mutex_unlock(&w->lock);
}

/* Adds the finished part of a tile, and the block that is begun. The thread has come to this pixel,
 * the last of its block. */
static void add_tile(const struct pen_batch_context *context, struct pen_rect tile, int x, int y,
                     struct pen_work *now)
{
    const struct pen_batch_work *w = &context->work;
    const int side = PEN_BLOCK_SIDE, left = tile.x + (x - tile.x) / side * side,
              top = tile.y + (y - tile.y) / side * side, view = context->claim->view;
    const struct pen_rect above = {tile.x, tile.y, tile.width, top - tile.y},
                          before = {tile.x, top, left - tile.x, y + 1 - top},
                          block = {left, top, x + 1 - left, y + 1 - top};
    now->done += w->part * (pen_cost_map_share(&w->map, view, above) +
                            pen_cost_map_share(&w->map, view, before));
    now->begun += w->part * pen_cost_map_share(&w->map, view, block);
}

/* Adds what the render threads have done of unfinished tiles, by their places in the trace. If
 * several threads share a tile, at the end, the first of them counts. */
static void add_places(const struct pen_batch_context *context, struct pen_work *now)
{
    const struct pen_settings *s = &context->request.settings;
    const struct pen_batch_work *w = &context->work;
    int seen[PEN_TRACE_THREADS];
    for (int i = 0; i < PEN_TRACE_THREADS && i < pen_thread_pool_size(context->pool); i++) {
        const uint64_t pixel =
            atomic_load_explicit(&context->options->trace->place[i].pixel, memory_order_relaxed);
        const int x = (int)(uint32_t)(pixel - 1), y = (int)((pixel - 1) >> 32),
                  tile =
                      pixel ? y / s->tile * pen_tile_count(s->width, 1, s->tile) + x / s->tile : -1,
                  place = tile - context->claim->first_tile;
        bool known = place < 0 || place >= w->tiles || w->tile_done[place];
        for (int k = 0; k < i; k++)
            known = known || seen[k] == tile;
        seen[i] = tile;
        if (!known)
            add_tile(context, pen_tile_rect(s->width, s->height, s->tile, tile), x, y, now);
    }
}

double pen_batch_work_now(void *user, double spent_ms, double *per_ms)
{
    struct pen_batch_context *context = user;
    struct pen_batch_work *w = &context->work;
    pthread_mutex_lock(&w->lock);
    struct pen_work now = w->known;
    if (w->tile_done) {
        if (context->options->trace)
            add_places(context, &now);
        if (now.done != w->last_done) {
            w->last_done = now.done;
            w->known_ms = spent_ms;
        }
        now.per_ms = pace_with(context, now.done, spent_ms - w->begun_ms);
    }
    const double ms = spent_ms - w->known_ms;
    pthread_mutex_unlock(&w->lock);
    *per_ms = now.per_ms;
    return pen_work_after(&now, ms);
}
