/* SPDX-License-Identifier: MIT */
/* The rounds of a view with a target error. The store keeps the state between two rounds and,
 * because a round may take hours, between two tiles of a round. So a worker that ends loses only
 * the tiles since then. There the view also yields to a batch that comes first, and continues
 * later. The bytes of the picture are the same.
 *
 * A state has 65 bytes a pixel, for views of any size. So it is kept at most every ten seconds, and
 * keeping takes at most a twentieth of the time.
 *
 * A budget of time begins with the claim. A worker that continues from a kept state has the rest of
 * the budget. The kept rounds have used their time, and waiting does not count.
 *
 * Before each tile, a render thread asks whether to pause: because a state is due, or because the
 * store has a batch that comes first (asked twice a second). Only then the threads stop. To stop
 * them at regular intervals would cost more, because they wait for the slowest thread.
 *
 * Only the clock says for sure how long the rounds take. So rounds that take longer than the
 * operator allows end at that time.
 *
 * The job's progress is stored with the state: the view's pixels times the share of its rays or,
 * with a budget and no target, of its time. Between two states, readers see what the worker
 * expects. With a budget it is the share of the time; else the share of the rays plus what the pace
 * adds. */
#include <math.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/log.h"
#include "jobs/internal/batch.h"
#include "jobs/internal/keep.h"
#include "render/adaptive_state.h"
#include "study/host.h"

static const char *build_of(const json_t *host)
{
    const char *build = json_string_value(json_object_get(host, "build"));
    return build ? build : "";
}

/* Writes the state of the rounds, whose statistics are these. */
static void save(const struct pen_batch_context *context, const struct pen_render_stats *stats,
                 struct pen_buf *state)
{
    json_t *host = pen_host_json();
    pen_adaptive_save(context->adaptive, stats, build_of(host), state);
    json_decref(host);
}

bool pen_batch_keep_after_rounds(struct pen_keeper *keeper, const struct pen_render_stats *stats,
                                 int64_t done, const struct pen_kept_part *part, int64_t begun_ns)
{
    struct pen_batch_context *context = keeper->context;
    struct pen_buf state = {0};
    bool gives_way;
    if (context->adaptive && !context->rounds_kept)
        save(context, stats, &state);
    const bool ok = part->bytes > 0 && !state.failed;
    const struct pen_kept kept = {
        .done = done, .data = state.data, .bytes = state.bytes, .parts = part, .part_count = 1};
    if (pen_keeper_keep(keeper, ok ? &kept : NULL, begun_ns, &gives_way))
        context->rounds_kept = context->adaptive != NULL;
    pen_buf_release(&state);
    return !gives_way;
}

bool pen_batch_keeper_pauses(void *user)
{
    struct pen_keeper *keeper = user;
    return pen_batch_is_overdue(keeper->context) || pen_keeper_is_due(keeper);
}

/* Returns the finished share of the view, whose layers follow. */
static double share_of(const struct pen_batch_context *context,
                       const struct pen_render_stats *stats)
{
    const double most = 0.99, budget_ms = (double)context->budget_ns * 1e-6,
                 by_rays = pen_adaptive_share(&stats->adaptive, (int)stats->tile_count),
                 by_time = budget_ms > 0 ? stats->render_ms / budget_ms : 0;
    return fmin(most, fmax(by_rays, by_time)) / (1 + pen_batch_layer_work(context));
}

/* Reports the work that the rounds have done to the heartbeat. */
static void tell(struct pen_batch_context *context, const struct pen_render_stats *stats)
{
    const double view = 1.0 / context->request.view_count, ms = stats->render_ms,
                 budget_ms = 1000 * context->request.budget_s * (1 + pen_batch_layer_work(context)),
                 done = budget_ms > 0 ? ms / budget_ms : view * share_of(context, stats);
    struct pen_work work = {.done = done, .begun = INFINITY, .per_ms = 1 / budget_ms};
    if (budget_ms <= 0) {
        work.begun = view - done;
        work.per_ms = done > 0 || context->work.expected_ms > 0
                          ? pen_work_pace(done, ms, context->work.expected_ms)
                          : 0;
    }
    pen_batch_work_tell(context, &work);
}

/* Keeps the state, if that is due. Returns true if the rounds go on. */
static bool keep(void *user, const struct pen_adaptive *adaptive,
                 const struct pen_render_stats *stats)
{
    struct pen_keeper *keeper = user;
    struct pen_batch_context *context = keeper->context;
    struct pen_buf state = {0};
    bool gives_way;
    (void)adaptive; /* the context's */
    if (pen_batch_is_overdue(context))
        return false;
    tell(context, stats);
    if (!pen_keeper_is_due(keeper))
        return true;
    const int64_t begun_ns = pen_clock_ns();
    save(context, stats, &state);
    const struct pen_kept kept = {
        .done = (int64_t)(share_of(context, stats) * (double)context->claim->pixels),
        .data = state.data,
        .bytes = state.bytes};
    pen_keeper_keep(keeper, state.failed ? NULL : &kept, begun_ns, &gives_way);
    pen_buf_release(&state);
    return !gives_way;
}

/* Reads the kept state of an earlier worker into a new state. Returns true if there was one. */
static bool read_kept(struct pen_batch_context *context, float *rgb,
                      struct pen_render_stats *earlier)
{
    struct pen_buf state = {0};
    struct pen_status ignored;
    json_t *host = pen_host_json();
    const bool ok =
        pen_store_kept(context->store, context->claim, PEN_KEPT_STATE, &state, &ignored) &&
        pen_adaptive_load(context->adaptive, state.data, state.bytes, build_of(host), earlier, rgb,
                          &ignored);
    pen_buf_release(&state);
    json_decref(host);
    if (ok) {
        const struct pen_log_about about = pen_claim_about(context->claim);
        const struct pen_adaptive_stats *a = &earlier->adaptive;
        pen_log_about(PEN_LOG_INFO, &about, "goes on after %d rounds and %d tiles", a->rounds,
                      a->ended ? 0 : a->round[a->rounds].tiles);
    }
    return ok;
}

bool pen_batch_rounds(struct pen_batch_context *context, const struct pen_render_task *task,
                      struct pen_render_stats *stats, struct pen_status *st)
{
    struct pen_keeper keeper = pen_keeper_make(context, PEN_KEEP_MS, PEN_ASK_MS);
    struct pen_render_stats earlier = {0};
    struct pen_render_task rounds = *task;
    context->adaptive = pen_adaptive_new(task->settings, st);
    if (!context->adaptive)
        return false;
    if (read_kept(context, task->rgb, &earlier))
        rounds.earlier = &earlier;
    tell(context, &earlier);
    context->rounds_kept = rounds.earlier && earlier.adaptive.ended;
    rounds.pause = pen_batch_keeper_pauses;
    rounds.paused = keep;
    rounds.pause_user = &keeper;
    if (context->budget_ns > 0)
        rounds.deadline_ns =
            context->begun_ns + context->budget_ns - (int64_t)(earlier.render_ms * 1e6);
    bool ok = pen_render_rounds(context->pool, &rounds, context->adaptive, stats, st);
    if (!ok && st->code == PEN_UNAVAILABLE && pen_batch_is_overdue(context))
        ok = pen_batch_fail_overdue(context, st);
    free(earlier.tile_ms);
    return ok;
}
