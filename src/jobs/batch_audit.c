/* SPDX-License-Identifier: MIT */
/* The audit of a view. The worker that ends the view makes it before the commit. The result is a
 * part of the batch's statistics.
 *
 * An audit of many pixels takes longer than the picture. So its progress is kept, like the state of
 * rounds, and the audit yields to a batch that comes first. The next worker that claims the batch
 * makes the picture again, then continues the audit. The seed is a hash of the picture, so a
 * picture with the same bytes has the same pixels drawn. */
#include "jobs/internal/batch.h"

#include <string.h>

#include "base/clock.h"
#include "study/hash.h"

#define PART "audit"

/* What is kept of an audit. */
struct kept_audit {
    uint64_t seed;
    struct pen_audit_progress progress;
};

/* Returns the kept progress of an audit with this seed, or no progress. */
static struct pen_audit_progress read_kept(struct pen_batch_context *context, uint64_t seed)
{
    struct kept_audit kept = {.seed = 0};
    struct pen_buf part = {0};
    struct pen_status ignored;
    if (pen_store_kept(context->store, context->claim, PART, &part, &ignored) &&
        part.bytes == sizeof kept)
        memcpy(&kept, part.data, sizeof kept);
    pen_buf_release(&part);
    return kept.seed == seed ? kept.progress : (struct pen_audit_progress){0};
}

static bool keep(struct pen_keeper *keeper, const struct pen_render_stats *stats, uint64_t seed,
                 const struct pen_audit_progress *progress)
{
    const struct kept_audit kept = {.seed = seed, .progress = *progress};
    const struct pen_kept_part part = {.name = PART, .data = &kept, .bytes = sizeof kept};
    const struct pen_claim *claim = keeper->context->claim;
    /* Of a view that is one batch, because its pixels were not reported since its rounds. */
    const int64_t done =
        claim->kind == PEN_BATCH_RENDER ? (int64_t)(0.99 * (double)claim->pixels) : -1;
    return pen_batch_keep_after_rounds(keeper, stats, done, &part, pen_clock_ns());
}

static bool run(struct pen_batch_context *context, struct pen_audit_task *task,
                const struct pen_render_stats *stats, struct pen_audit *audit,
                struct pen_status *st)
{
    struct pen_keeper keeper = pen_keeper_make(context, PEN_KEEP_MS, PEN_ASK_MS);
    struct pen_audit_progress progress = read_kept(context, task->seed);
    task->pause = pen_batch_keeper_pauses;
    task->pause_user = &keeper;
    do {
        if (!pen_audit_continue(context->pool, task, &progress, audit, st))
            return false;
        if (progress.left > 0 && pen_batch_is_overdue(context))
            return pen_batch_fail_overdue(context, st);
        if (progress.left > 0 && !keep(&keeper, stats, task->seed, &progress))
            return pen_fail(st, PEN_UNAVAILABLE, "interrupted after %llu pixels of an audit",
                            (unsigned long long)progress.done);
    } while (progress.left > 0);
    return true;
}

bool pen_batch_audit(struct pen_batch_context *context, const struct pen_film *film,
                     const struct pen_render_stats *stats, struct pen_audit *audit, bool *done,
                     struct pen_status *st)
{
    struct pen_scene_times times;
    struct pen_audit_task task = {.settings = &context->request.settings,
                                  .rgb = film->rgb,
                                  .pixels = context->request.audit_pixels,
                                  .threshold = context->request.audit_threshold,
                                  .adaptive = context->adaptive,
                                  .cancel = pen_heartbeat_cancel_flag(context->heart)};
    *done = context->request.audit;
    if (!*done)
        return true;
    task.scene = pen_batch_scene(context, &task.view, &times, st);
    task.seed = pen_audit_seed(film);
    return task.scene && run(context, &task, stats, audit, st);
}
