/* SPDX-License-Identifier: MIT */
#include "jobs/internal/keep.h"

#include "base/clock.h"

enum { KEEP_TIMES = 20 };

struct pen_keeper pen_keeper_make(struct pen_batch_context *context, const struct pen_claim *claim,
                                  int64_t wait_ms, int64_t ask_ms)
{
    const bool given = context->keep_ms > 0;
    return (struct pen_keeper){.context = context,
                               .claim = claim,
                               .wait_ms = given ? context->keep_ms : wait_ms,
                               .times = given ? 0 : KEEP_TIMES,
                               .ask_ms = ask_ms,
                               .kept_ns = pen_clock_ns()};
}

bool pen_keeper_is_due(struct pen_keeper *k, bool *outranked)
{
    const int64_t now_ns = pen_clock_ns(), since_ns = now_ns - k->kept_ns;
    struct pen_status ignored;
    *outranked = false;
    if (now_ns - k->asked_ns >= k->ask_ms * 1000000) {
        k->asked_ns = now_ns;
        if (!pen_store_outranked(k->context->store, k->claim, outranked, &ignored))
            *outranked = false;
    }
    return *outranked || (since_ns >= k->wait_ms * 1000000 && since_ns >= k->times * k->took_ns);
}

bool pen_keeper_keep(struct pen_keeper *k, const struct pen_kept *kept, int64_t begun_ns,
                     bool *outranked)
{
    struct pen_status ignored;
    const bool ok = pen_store_keep(k->context->store, k->claim, kept, outranked, &ignored);
    k->kept_ns = pen_clock_ns();
    k->took_ns = k->kept_ns - begun_ns;
    k->context->store_ms += (double)k->took_ns * 1e-6;
    return ok;
}
