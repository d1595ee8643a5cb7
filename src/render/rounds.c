/* SPDX-License-Identifier: MIT */
/* Renders a whole view in rounds, in this process: until a target is met, until a deadline, or as
 * an earlier render did. A round takes the tiles in order. It can end or pause between two of them.
 * Then no more tiles are begun, and threads share the rest of those begun. So the finished part is
 * a number of tiles from the first on. Without a pause, no thread waits. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "math/fn.h"
#include "render/internal/kernel_input.h"
#include "render/internal/refine.h"

/* The rounds of one view. */
struct rounds {
    struct pen_thread_pool *pool;
    const struct pen_render_task *task;
    struct pen_adaptive *adaptive;
    struct pen_render_stats *stats;
    int tiles;
    int64_t begun_ns;
    double earlier_ms; /* time that an earlier render took for the earlier rounds */
    double ray_ns;     /* time of a camera ray and its secondary rays, in the last round */
};

/* Whether the deadline has passed. The first round is always complete. */
static bool is_over(const struct rounds *r)
{
    const int64_t deadline_ns = r->task->deadline_ns;
    return deadline_ns != 0 && r->stats->adaptive.rounds > 0 && pen_clock_ns() >= deadline_ns;
}

/* Adds the statistics of some tiles of a round to those of the render. Takes their tile_ms. */
static void add_tiles(struct rounds *r, struct pen_render_stats *more, int first_tile)
{
    struct pen_render_stats *sum = r->stats;
    sum->cpu_ms += more->cpu_ms;
    sum->threads = sum->threads > more->threads ? sum->threads : more->threads;
    sum->float_resets += more->float_resets;
    sum->kernel = more->kernel;
    sum->effects = more->effects;
    sum->tests_counted = more->tests_counted;
    pen_ray_counts_add(&sum->rays, &more->rays);
    sum->tests.boxes += more->tests.boxes;
    sum->tests.primitives += more->tests.primitives;
    for (uint32_t i = 0; sum->tile_ms && more->tile_ms && i < more->tile_count; i++)
        sum->tile_ms[(uint32_t)first_tile + i] += more->tile_ms[i];
    free(more->tile_ms);
}

/* Whether to begin no more tiles of a round. */
static bool pauses(void *user)
{
    const struct rounds *r = user;
    const struct pen_render_task *task = r->task;
    return is_over(r) || (task->pause && task->pause(task->pause_user));
}

/* Renders tiles of a round from number *done on, to `end` or until there is a pause. */
static bool run_tiles(struct rounds *r, int *done, int end, struct pen_status *st)
{
    struct pen_render_stats more;
    struct pen_render_task task = *r->task;
    task.adaptive = r->adaptive;
    task.tile_done = NULL;
    task.rows_done = NULL;
    task.first_tile = *done;
    task.tile_count = end - *done;
    task.pause = pauses;
    task.pause_user = r;
    if (!pen_render_run(r->pool, &task, &more, st))
        return false;
    *done += (int)more.tile_count;
    add_tiles(r, &more, task.first_tile);
    return true;
}

/* Lets the caller save the work so far, and asks it whether to continue. */
static bool ask_to_go_on(struct rounds *r, struct pen_status *st)
{
    const struct pen_render_task *task = r->task;
    const struct pen_adaptive_stats *a = &r->stats->adaptive;
    r->stats->render_ms = r->earlier_ms + (double)(pen_clock_ns() - r->begun_ns) * 1e-6;
    return !task->paused || task->paused(task->pause_user, r->adaptive, r->stats) ||
           pen_fail(st, PEN_UNAVAILABLE, "interrupted after %d rounds and %d tiles", a->rounds,
                    a->round[a->rounds].tiles);
}

/* Runs the current round, up to its recorded tile or the deadline. */
static bool run_round(struct rounds *r, struct pen_status *st)
{
    const struct pen_adaptive_stats *a = &r->stats->adaptive, *repeat = r->task->repeat;
    const int end = repeat && a->rounds > 0 ? repeat->round[a->rounds].tiles : r->tiles;
    int *done = &r->stats->adaptive.round[a->rounds].tiles;
    const int64_t begun = pen_clock_ns();
    const uint64_t before = r->stats->rays.primary;
    while (*done < end && !is_over(r)) {
        if (!run_tiles(r, done, end, st))
            return false;
        if (*done < end && !is_over(r) && !ask_to_go_on(r, st))
            return false;
    }
    const double rays = (double)(r->stats->rays.primary - before);
    if (rays > 0)
        r->ray_ns = (double)(pen_clock_ns() - begun) / rays;
    return true;
}

/* The number of camera rays that can be traced until the deadline. */
static uint64_t affordable(const struct rounds *r)
{
    const double left = (double)(r->task->deadline_ns - pen_clock_ns());
    if (r->task->deadline_ns == 0)
        return UINT64_MAX;
    return left > 0 && r->ray_ns > 0 ? (uint64_t)(left / r->ray_ns) : 0;
}

/* Decides after a round, and stores the results. */
static bool decide(struct rounds *r, struct pen_decision *d, struct pen_status *st)
{
    struct pen_adaptive_stats *a = &r->stats->adaptive;
    struct pen_round *round = &a->round[a->rounds];
    const struct pen_goal goal = {a->target, affordable(r)};
    if (!pen_adaptive_decide(r->adaptive, r->pool, &goal, d, st))
        return false;
    round->error = d->error;
    round->low = d->low;
    round->high = d->high;
    a->rounds++;
    a->met = d->met;
    a->capped = d->capped;
    a->unproven = d->unproven;
    if (r->task->round_done)
        r->task->round_done(r->task->user, round);
    return true;
}

/* Whether a round was the last one. If not, selects the pixels of the next. */
static bool select_next(struct rounds *r, const struct pen_decision *d, bool *last,
                        struct pen_status *st)
{
    const struct pen_adaptive_stats *repeat = r->task->repeat;
    struct pen_adaptive_stats *a = &r->stats->adaptive;
    const int done = a->rounds;
    *last = repeat ? done >= repeat->rounds
                   : d->done || done == PEN_ROUNDS_MAX || a->round[done - 1].tiles < r->tiles;
    a->ended = *last;
    if (*last)
        return true;
    struct pen_round *round = &a->round[done];
    *round = (struct pen_round){.level = repeat ? repeat->round[done].level : d->level};
    round->pixels = pen_adaptive_select(r->adaptive, round->level);
    if (!repeat || repeat->round[done].pixels == round->pixels)
        return !repeat || repeat->round[done].tiles <= r->tiles ||
               pen_fail(st, PEN_CONFLICT, "round %d has %d tiles, the picture only %d", done,
                        repeat->round[done].tiles, r->tiles);
    return pen_fail(st, PEN_CONFLICT,
                    "the rounds to be repeated are not of this scene, these settings and this "
                    "version: round %d refines %llu pixels instead of %llu",
                    done, (unsigned long long)round->pixels,
                    (unsigned long long)repeat->round[done].pixels);
}

static bool run_rounds(struct rounds *r, struct pen_status *st)
{
    struct pen_decision d;
    for (bool last = r->stats->adaptive.ended; !last;)
        if (!run_round(r, st) || !decide(r, &d, st) || !select_next(r, &d, &last, st) ||
            (!last && !ask_to_go_on(r, st)))
            return false;
    return true;
}

/* Completes the statistics, and makes the calls for a finished picture. */
static void finish(const struct rounds *r)
{
    const struct pen_render_task *task = r->task;
    const struct pen_settings *s = task->settings;
    if (!r->stats->kernel) { /* an earlier render has made all rounds */
        const struct pen_kernel_input input =
            pen_kernel_input_of(task->scene, task->view, &r->adaptive->sampling);
        r->stats->kernel = pen_kernel_select(input.effects, pen_cpu_isa())->name;
        r->stats->effects = input.effects;
    }
    for (int i = 0; task->tile_done && i < r->tiles; i++)
        task->tile_done(task->user, pen_tile_rect(s->width, s->height, s->tile, i));
    if (task->rows_done)
        task->rows_done(task->rows_user, s->height);
}

/* Sets the statistics before the first round, or those of an earlier render. */
static bool begin_stats(struct rounds *r, struct pen_status *st)
{
    const struct pen_render_task *task = r->task;
    const struct pen_render_stats *earlier = task->earlier;
    const struct pen_settings *s = task->settings;
    struct pen_render_stats *stats = r->stats;
    *stats = earlier ? *earlier : (struct pen_render_stats){.tile_count = (uint32_t)r->tiles};
    if (!earlier)
        stats->adaptive.round[0].pixels = (uint64_t)s->width * (uint64_t)s->height;
    r->earlier_ms = stats->render_ms;
    stats->tile_ms = NULL;
    stats->adaptive.target = s->target_error;
    stats->adaptive.timed = task->deadline_ns != 0 || (task->repeat && task->repeat->timed);
    if (task->first_tile != 0 || (task->tile_count >= 0 && task->tile_count != r->tiles))
        return pen_fail(st, PEN_INTERNAL, "an adaptive render of a part of the image");
    if (!task->keep_tile_ms)
        return true;
    stats->tile_ms = calloc((size_t)r->tiles, sizeof *stats->tile_ms);
    if (!stats->tile_ms)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory for the times of %d tiles", r->tiles);
    if (earlier && earlier->tile_ms)
        memcpy(stats->tile_ms, earlier->tile_ms, (size_t)r->tiles * sizeof *stats->tile_ms);
    return true;
}

/* Finds the small and bright things of the view, unless this has been done. */
static bool find_things(struct rounds *r, struct pen_status *st)
{
    struct pen_adaptive *a = r->adaptive;
    const struct pen_kernel_input input =
        pen_kernel_input_of(r->task->scene, r->task->view, &a->sampling);
    a->has_beams = a->has_beams || pen_beams_new(&input, r->pool, &a->beams, st);
    return a->has_beams;
}

bool pen_render_rounds(struct pen_thread_pool *pool, const struct pen_render_task *task,
                       struct pen_adaptive *adaptive, struct pen_render_stats *stats,
                       struct pen_status *st)
{
    const struct pen_settings *s = task->settings;
    struct rounds r = {.pool = pool,
                       .task = task,
                       .adaptive = adaptive,
                       .stats = stats,
                       .tiles = pen_tile_count(s->width, s->height, s->tile),
                       .begun_ns = pen_clock_ns()};
    if (!begin_stats(&r, st) || !find_things(&r, st))
        return false;
    if (!run_rounds(&r, st)) {
        free(stats->tile_ms);
        stats->tile_ms = NULL;
        return false;
    }
    stats->done_ns = pen_clock_ns();
    stats->render_ms = r.earlier_ms + (double)(stats->done_ns - r.begun_ns) * 1e-6;
    stats->adaptive.samples = pen_adaptive_spread(adaptive);
    finish(&r);
    return true;
}

bool pen_unproven_warning(const struct pen_adaptive_stats *a, char *text, size_t bytes)
{
    if (!(a->unproven > 0))
        return false;
    snprintf(text, bytes,
             "%.3g %% of the pixels may show small or bright objects that too few samples have "
             "looked for: give them more max_samples, or more time",
             100 * a->unproven);
    return true;
}

double pen_adaptive_share(const struct pen_adaptive_stats *a, int tiles)
{
    if (a->rounds == 0)
        return 0;
    const double most = 0.99, high = a->round[a->rounds - 1].high;
    const double before = high > a->target ? pen_pow(a->target / high, 8.0 / 5) : 1;
    const int done = a->rounds < PEN_ROUNDS_MAX ? a->round[a->rounds].tiles : 0;
    const double share = before * (1 + 0.5 * done / tiles);
    return share < most ? share : most;
}

bool pen_render_to_target(struct pen_thread_pool *pool, const struct pen_render_task *task,
                          struct pen_render_stats *stats, struct pen_status *st)
{
    struct pen_adaptive *adaptive = pen_adaptive_new(task->settings, st);
    const bool ok = adaptive && pen_render_rounds(pool, task, adaptive, stats, st);
    pen_adaptive_free(adaptive);
    return ok;
}
