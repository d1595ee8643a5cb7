/* SPDX-License-Identifier: MIT */
#include "jobs/internal/keep.h"

#include "base/clock.h"
#include "base/log.h"

enum {
    KEEP_TIMES = 20,
    RETRY_MS = 500, /* after the first failed try */
    RETRY_MAX_MS = 60000
};

struct pen_keeper pen_keeper_make(struct pen_batch_context *context, int64_t wait_ms,
                                  int64_t ask_ms)
{
    const bool given = context->options->keep_ms > 0;
    const int64_t now_ns = pen_clock_ns();
    return (struct pen_keeper){.context = context,
                               .wait_ms = given ? context->options->keep_ms : wait_ms,
                               .times = given ? 0 : KEEP_TIMES,
                               .ask_ms = ask_ms,
                               .tried_ns = now_ns};
}

static void ask(struct pen_keeper *k)
{
    struct pen_status ignored;
    k->asked_ns = pen_clock_ns();
    if (!pen_store_outranked(k->context->store, k->context->claim, &k->outranked, &ignored))
        k->outranked = false;
}

bool pen_keeper_is_due(struct pen_keeper *k)
{
    const int64_t now_ns = pen_clock_ns(), since_ns = now_ns - k->tried_ns;
    if (now_ns - k->asked_ns >= k->ask_ms * 1000000)
        ask(k);
    return since_ns >= k->retry_ms * 1000000 &&
           (k->outranked ||
            (since_ns >= k->wait_ms * 1000000 && since_ns >= k->times * k->took_ns));
}

static void note_failure(struct pen_keeper *k, const struct pen_status *why)
{
    const struct pen_log_about about = pen_claim_about(k->context->claim);
    const int64_t next_ms = k->retry_ms > 0 ? 2 * k->retry_ms : RETRY_MS;
    if (k->retry_ms == 0)
        pen_log_about(PEN_LOG_WARN, &about, "its state cannot be kept: %s", why->msg);
    k->retry_ms = next_ms < RETRY_MAX_MS ? next_ms : RETRY_MAX_MS;
}

bool pen_keeper_keep(struct pen_keeper *k, const struct pen_kept *kept, int64_t begun_ns,
                     bool *gives_way)
{
    struct pen_status st;
    pen_heartbeat_pause(k->context->heart);
    const bool ok = kept
                        ? pen_store_keep(k->context->store, k->context->claim, kept, gives_way, &st)
                        : pen_fail(&st, PEN_NO_MEMORY, "no memory for it");
    pen_heartbeat_resume(k->context->heart);
    k->tried_ns = pen_clock_ns();
    k->took_ns = k->tried_ns - begun_ns;
    k->context->store_ms += (double)k->took_ns * 1e-6;
    if (ok) {
        k->outranked = false; /* or the batch ends */
        k->retry_ms = 0;
        return true;
    }
    note_failure(k, &st);
    *gives_way = false;
    return false;
}
