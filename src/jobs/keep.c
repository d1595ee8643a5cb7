/* SPDX-License-Identifier: MIT */
#include "jobs/internal/keep.h"

#include "base/clock.h"
#include "base/log.h"

enum {
    KEEP_TIMES = 20,
    RETRY_MS = 500, /* after the first try that fails */
    RETRY_MAX_MS = 60000,
    PATIENCE_MS = 10000, /* of those that wait for a batch whose state finds no room */
    DOUBLINGS = 20       /* of it: to four months */
};

struct pen_keeper pen_keeper_make(struct pen_batch_context *context, const struct pen_claim *claim,
                                  int64_t wait_ms, int64_t ask_ms)
{
    const bool given = context->keep_ms > 0;
    const int64_t now_ns = pen_clock_ns();
    return (struct pen_keeper){.context = context,
                               .claim = claim,
                               .wait_ms = given ? context->keep_ms : wait_ms,
                               .times = given ? 0 : KEEP_TIMES,
                               .ask_ms = ask_ms,
                               .kept_ns = now_ns,
                               .tried_ns = now_ns};
}

static void ask(struct pen_keeper *k)
{
    struct pen_status ignored;
    bool outranked;
    k->asked_ns = pen_clock_ns();
    if (!pen_store_outranked(k->context->store, k->claim, &outranked, &ignored) || !outranked)
        k->outranked_ns = 0;
    else if (k->outranked_ns == 0)
        k->outranked_ns = k->asked_ns;
}

/* What this worker has lost of the keeper's batch; NULL: nothing. */
static struct pen_batch_losses *losses_of(const struct pen_keeper *k)
{
    struct pen_batch_losses *losses = k->context->losses;
    for (int i = 0; i < PEN_BATCH_LOSSES; i++)
        if (losses[i].count > 0 && losses[i].batch == k->claim->batch)
            return &losses[i];
    return NULL;
}

/* Whether a batch that comes first has waited long enough for one whose state finds no room. */
static bool is_patience_over(const struct pen_keeper *k, int64_t now_ns)
{
    const struct pen_batch_losses *losses = losses_of(k);
    const int64_t first_ms = k->context->patience_ms > 0 ? k->context->patience_ms : PATIENCE_MS,
                  ms = first_ms << (losses ? losses->count : 0);
    return k->lacks_room && k->outranked_ns != 0 && now_ns - k->outranked_ns >= ms * 1000000;
}

bool pen_keeper_is_due(struct pen_keeper *k)
{
    const int64_t now_ns = pen_clock_ns(), since_ns = now_ns - k->tried_ns;
    if (now_ns - k->asked_ns >= k->ask_ms * 1000000)
        ask(k);
    if (is_patience_over(k, now_ns))
        return true;
    return since_ns >= k->retry_ms * 1000000 &&
           (k->outranked_ns != 0 ||
            (since_ns >= k->wait_ms * 1000000 && since_ns >= k->times * k->took_ns));
}

static void note_failure(struct pen_keeper *k, const struct pen_status *why)
{
    const struct pen_log_about about = pen_claim_about(k->claim);
    const int64_t next_ms = k->retry_ms > 0 ? 2 * k->retry_ms : RETRY_MS;
    k->lacks_room = why->code == PEN_STORAGE_FULL || why->code == PEN_NO_MEMORY;
    if (k->lacks_room && k->retry_ms == 0)
        pen_log_about(PEN_LOG_WARN, &about, "its state cannot be kept: %s", why->msg);
    k->retry_ms = next_ms < RETRY_MAX_MS ? next_ms : RETRY_MAX_MS;
}

/* Notes that the batch gives way although its state could not be kept. */
static void note_loss(struct pen_keeper *k, const struct pen_status *why)
{
    const struct pen_log_about about = pen_claim_about(k->claim);
    struct pen_batch_context *context = k->context;
    struct pen_batch_losses *losses = losses_of(k);
    if (!losses) {
        losses = &context->losses[context->losses_next];
        context->losses_next = (context->losses_next + 1) % PEN_BATCH_LOSSES;
        *losses = (struct pen_batch_losses){.batch = k->claim->batch};
    }
    losses->count += losses->count < DOUBLINGS;
    pen_log_about(PEN_LOG_WARN, &about,
                  "gives way to a batch that comes first, and loses its work of the last %.1f s: "
                  "its state cannot be kept: %s",
                  (double)(pen_clock_ns() - k->kept_ns) * 1e-9, why->msg);
}

bool pen_keeper_keep(struct pen_keeper *k, const struct pen_kept *kept, int64_t begun_ns,
                     bool *gives_way)
{
    struct pen_status st;
    pen_heartbeat_pause(k->context->heart);
    const bool ok = kept ? pen_store_keep(k->context->store, k->claim, kept, gives_way, &st)
                         : pen_fail(&st, PEN_NO_MEMORY, "no memory for it");
    pen_heartbeat_resume(k->context->heart);
    k->tried_ns = pen_clock_ns();
    k->took_ns = k->tried_ns - begun_ns;
    k->context->store_ms += (double)k->took_ns * 1e-6;
    if (ok) {
        k->kept_ns = k->tried_ns;
        k->outranked_ns = 0; /* or the batch ends */
        k->retry_ms = 0;
        k->lacks_room = false;
        return true;
    }
    note_failure(k, &st);
    ask(k);
    *gives_way = is_patience_over(k, k->asked_ns);
    if (*gives_way)
        note_loss(k, &st);
    return false;
}
