/* SPDX-License-Identifier: MIT */
/* The rounds of a view with a target error. The store keeps the state between two rounds and, as a
 * round may take hours, between two tiles of a round: so a worker that ends loses the tiles since,
 * and no more; and there the view gives way to a batch of higher priority, and goes on after it.
 * The picture gets the same bytes.
 *
 * A state has 65 bytes for each pixel. So it is kept at most every ten seconds, and not for more
 * than a twentieth of the time. With a budget of time there is none: that runs from the claim.
 *
 * Before each tile a render thread asks whether there is a reason to pause: that a state is due, or
 * twice a second whether the store has a batch of higher priority. Only then the threads stop. To
 * stop them at regular times to look would cost more, as they have to wait for the slowest.
 *
 * With the state goes the progress of the job: the view's pixels times the share of its rays. */
#include <stdlib.h>

#include "base/clock.h"
#include "base/log.h"
#include "jobs/internal/batch.h"
#include "render/adaptive_state.h"
#include "study/host.h"

enum { KEEP_MS = 10000, KEEP_TIMES = 20, LOOK_MS = 500 };

static const size_t keep_bytes_max = (size_t)1 << 30; /* a row of the store */

/* Used by the worker's thread, and by render threads while that one waits for them. */
struct keeper {
    struct pen_batch_context *context;
    const struct pen_claim *claim;
    json_t *host;
    int64_t kept_ns, took_ns; /* when it was last kept, and how long that took */
    int64_t looked_ns;        /* when the store was last asked for batches of higher priority */
};

static const char *build_of(const struct keeper *k)
{
    const char *build = json_string_value(json_object_get(k->host, "build"));
    return build ? build : "";
}

static bool is_due(const struct keeper *k)
{
    const int64_t now_ns = pen_clock_ns(),
                  wait_ms = k->context->keep_ms > 0 ? k->context->keep_ms : KEEP_MS;
    return now_ns - k->kept_ns >= wait_ms * 1000000 &&
           now_ns - k->kept_ns >= KEEP_TIMES * k->took_ns;
}

static bool is_outranked(struct keeper *k)
{
    struct pen_status ignored;
    bool outranked = false;
    k->looked_ns = pen_clock_ns();
    return pen_store_outranked(k->context->store, k->claim, &outranked, &ignored) && outranked;
}

static bool can_keep(const struct pen_batch_context *context)
{
    return pen_adaptive_state_bytes(&context->request.settings) <= keep_bytes_max;
}

static bool pause_round(void *user)
{
    struct keeper *k = user;
    return is_due(k) ||
           (pen_clock_ns() - k->looked_ns >= (int64_t)LOOK_MS * 1000000 && is_outranked(k));
}

/* Stores the state. A failure is ignored: the next time may succeed. Returns whether it is kept. */
static bool store_state(struct keeper *k, const struct pen_adaptive *adaptive,
                        const struct pen_render_stats *stats, bool *outranked)
{
    struct pen_buf state = {0};
    struct pen_status ignored;
    const int64_t begun_ns = pen_clock_ns();
    pen_adaptive_save(adaptive, stats, build_of(k), &state);
    const double share = pen_adaptive_share(&stats->adaptive, (int)stats->tile_count);
    const struct pen_kept kept = {(int64_t)(share * (double)k->claim->pixels), state.data,
                                  state.bytes};
    const bool ok =
        !state.failed && pen_store_keep(k->context->store, k->claim, &kept, outranked, &ignored);
    pen_buf_release(&state);
    k->kept_ns = pen_clock_ns();
    k->took_ns = k->kept_ns - begun_ns;
    k->context->store_ms += (double)k->took_ns * 1e-6;
    return ok;
}

static bool keep(void *user, const struct pen_adaptive *adaptive,
                 const struct pen_render_stats *stats)
{
    struct keeper *k = user;
    bool outranked = is_outranked(k);
    if (!outranked && !is_due(k))
        return true;
    return !store_state(k, adaptive, stats, &outranked) || !outranked;
}

/* Reads what an earlier worker has kept into a new state. Returns whether there was something. */
static bool read_kept(struct keeper *k, const struct pen_render_task *task,
                      struct pen_adaptive *adaptive, struct pen_render_stats *earlier)
{
    struct pen_buf state = {0};
    struct pen_status ignored;
    const bool ok = pen_store_kept(k->context->store, k->claim, &state, &ignored) &&
                    pen_adaptive_load(adaptive, state.data, state.bytes, build_of(k), earlier,
                                      task->rgb, &ignored);
    pen_buf_release(&state);
    if (ok) {
        const struct pen_log_about about = pen_claim_about(k->claim);
        const struct pen_adaptive_stats *a = &earlier->adaptive;
        pen_log_about(PEN_LOG_INFO, &about, "goes on after %d rounds and %d tiles", a->rounds,
                      a->round[a->rounds].tiles);
    }
    return ok;
}

bool pen_batch_rounds(struct pen_batch_context *context, const struct pen_claim *claim,
                      const struct pen_render_task *task, struct pen_render_stats *stats,
                      struct pen_status *st)
{
    const int64_t now_ns = pen_clock_ns();
    struct keeper k = {.context = context, .claim = claim, .kept_ns = now_ns, .looked_ns = now_ns};
    struct pen_render_stats earlier = {0};
    struct pen_render_task rounds = *task;
    context->adaptive = pen_adaptive_new(task->settings, st);
    if (!context->adaptive)
        return false;
    if (task->deadline_ns == 0 && can_keep(context)) {
        k.host = pen_host_json();
        if (read_kept(&k, task, context->adaptive, &earlier))
            rounds.earlier = &earlier;
        rounds.pause = pause_round;
        rounds.paused = keep;
        rounds.pause_user = &k;
    }
    const bool ok = pen_render_rounds(context->pool, &rounds, context->adaptive, stats, st);
    free(earlier.tile_ms);
    json_decref(k.host);
    return ok;
}
