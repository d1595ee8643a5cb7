/* SPDX-License-Identifier: MIT */
/* Renders a whole view in rounds, in this process. */
#include <stdlib.h>

#include "base/clock.h"
#include "render/internal/refine.h"

/* Adds what one round took to the statistics of the render. Takes its tile_ms. */
static void add_round(struct pen_render_stats *sum, struct pen_render_stats *round)
{
    const struct pen_adaptive_stats adaptive = sum->adaptive;
    const struct pen_render_stats before = *sum;
    *sum = *round;
    sum->adaptive = adaptive;
    sum->cpu_ms += before.cpu_ms;
    sum->threads = before.threads > round->threads ? before.threads : round->threads;
    sum->float_resets += before.float_resets;
    pen_ray_counts_add(&sum->rays, &before.rays);
    sum->tests.boxes += before.tests.boxes;
    sum->tests.primitives += before.tests.primitives;
    for (uint32_t i = 0; before.tile_ms && sum->tile_ms && i < sum->tile_count; i++)
        sum->tile_ms[i] += before.tile_ms[i];
    free(before.tile_ms);
}

/* Decides after a round, and keeps what is found. */
static bool decide(struct pen_thread_pool *pool, struct pen_adaptive *a,
                   struct pen_adaptive_stats *stats, struct pen_round *round,
                   struct pen_decision *d, struct pen_status *st)
{
    if (!pen_adaptive_decide(a, pool, a->settings->target_error, d, st))
        return false;
    round->error = d->error;
    round->low = d->low;
    round->high = d->high;
    stats->round[stats->rounds++] = *round;
    stats->met = d->met;
    stats->capped = d->capped;
    return true;
}

static bool run_rounds(struct pen_thread_pool *pool, const struct pen_render_task *task,
                       struct pen_render_stats *stats, struct pen_status *st)
{
    struct pen_render_task one = *task;
    struct pen_round round = {.pixels = (uint64_t)task->settings->width *
                                        (uint64_t)task->settings->height};
    struct pen_decision d;
    one.tile_done = NULL;
    one.rows_done = NULL;
    for (;;) {
        struct pen_render_stats more;
        if (!pen_render_run(pool, &one, &more, st))
            return false;
        add_round(stats, &more);
        if (!decide(pool, one.adaptive, &stats->adaptive, &round, &d, st))
            return false;
        if (task->round_done)
            task->round_done(task->user, &round);
        if (d.done || stats->adaptive.rounds == PEN_ROUNDS_MAX)
            return true;
        round.level = d.level;
        if (!pen_adaptive_select(one.adaptive, pool, d.level, &round.pixels, st))
            return false;
    }
}

bool pen_render_rounds(struct pen_thread_pool *pool, const struct pen_render_task *task,
                       struct pen_adaptive *adaptive, struct pen_render_stats *stats,
                       struct pen_status *st)
{
    const struct pen_settings *s = task->settings;
    const int tiles = pen_tile_count(s->width, s->height, s->tile);
    struct pen_render_task rounds = *task;
    *stats = (struct pen_render_stats){0};
    if (task->first_tile != 0 || (task->tile_count >= 0 && task->tile_count != tiles))
        return pen_fail(st, PEN_INTERNAL, "an adaptive render of a part of the image");
    rounds.adaptive = adaptive;
    const int64_t begun = pen_clock_ns();
    if (!run_rounds(pool, &rounds, stats, st)) {
        free(stats->tile_ms);
        stats->tile_ms = NULL;
        return false;
    }
    stats->done_ns = pen_clock_ns();
    stats->render_ms = (double)(stats->done_ns - begun) * 1e-6;
    stats->adaptive.target = s->target_error;
    stats->adaptive.samples = pen_adaptive_spread(adaptive);
    for (int i = 0; task->tile_done && i < tiles; i++)
        task->tile_done(task->user, pen_tile_rect(s->width, s->height, s->tile, i));
    if (task->rows_done)
        task->rows_done(task->rows_user, s->height);
    return true;
}

bool pen_render_to_target(struct pen_thread_pool *pool, const struct pen_render_task *task,
                          struct pen_render_stats *stats, struct pen_status *st)
{
    struct pen_adaptive *adaptive = pen_adaptive_new(task->settings, st);
    const bool ok = adaptive && pen_render_rounds(pool, task, adaptive, stats, st);
    pen_adaptive_free(adaptive);
    return ok;
}
