/* SPDX-License-Identifier: MIT */
/* The worker's loop, and what the worker does about failures:
 *
 *   - The job is at fault (scene, memory, time): the job fails with a problem document.
 *   - The lease is lost, or the job was cancelled: the result is dropped.
 *   - The worker must stop during a study: it gives the study back, to be started again.
 *   - The store is busy or full: the worker keeps the result and tries again.
 *   - The store has an I/O error: the worker ends, and is not charged. The next worker recovers.
 *   - A batch yields to a batch that comes first: it is given back with its state
 *     (internal/keep.h).
 *   - The stored job is damaged: the job fails.
 *
 * A result is kept until the store has stored or refused it. A commit with an unknown outcome is
 * repeated, which does no harm. */
#include "jobs/worker.h"

#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "jobs/internal/batch.h"
#include "jobs/internal/failure.h"
#include "jobs/internal/housekeeper.h"
#include "jobs/internal/jobs.h"

enum {
    LEASE_MS = 15000,
    IDLE_MS = 1000,    /* until an idle worker tries to claim without a wake-up */
    RETRY_MS = 250,    /* between tries of a busy or failing store */
    LOG_MS = 10000,    /* between log lines about the same failure */
    MEMORY_TRIES = 20, /* times that a store call is tried while memory is short */
    EXPIRE_MS = 1000,  /* between calls of pen_store_expire_leases */
    SEEN_MS = 15000    /* between updates of this worker's row in the list of workers */
};

struct worker {
    const struct pen_worker_options *options;
    const atomic_bool *stop;
    int64_t lease_ms;
    struct pen_store *store;
    struct pen_batch_context context;
    struct pen_housekeeper *housekeeper;
    int64_t expired_ns, seen_ns; /* when maintain last did each of them */
    int64_t worked_ns;    /* when there was last work, or when the worker began to look for work */
    int memory_tries;     /* in a row */
    int64_t serial;       /* of the last claim */
    bool has_rate;        /* the row has a rate */
    int64_t logged_ns;    /* when a failure of the store was last logged */
    enum pen_code logged; /* the code of that failure */
    uint32_t wakeups;     /* pen_store_changes, from before the last claim that found none */
};

static bool stopped(const struct worker *w)
{
    return atomic_load_explicit(w->stop, memory_order_relaxed);
}

/* Returns true if the same call may succeed later. */
static bool is_temporary(const struct pen_status *st)
{
    return st->code == PEN_UNAVAILABLE || st->code == PEN_STORAGE_FULL || st->code == PEN_NO_MEMORY;
}

/* Logs a failure of the store, at most once in LOG_MS, because it may last for hours. */
static void log_failure(struct worker *w, const char *what, const struct pen_status *st)
{
    int64_t now_ns = pen_clock_ns();
    if (w->logged == st->code && now_ns - w->logged_ns < (int64_t)LOG_MS * 1000000)
        return;
    w->logged = st->code;
    w->logged_ns = now_ns;
    pen_log(PEN_LOG_WARN, "%s: %s; trying again", what, st->msg);
}

/* Waits after a failed store call. Returns true if the call should be tried again. */
static bool wait_to_retry(struct worker *w, const char *what, const struct pen_status *st)
{
    w->memory_tries = st->code == PEN_NO_MEMORY ? w->memory_tries + 1 : 0;
    if (!is_temporary(st) || stopped(w) || w->memory_tries > MEMORY_TRIES)
        return false;
    log_failure(w, what, st);
    usleep(RETRY_MS * 1000);
    return true;
}

/* Ends the job as failed. `why` NULL: its time is up. PEN_STALE means that the claim is no longer
 * held, because the job has ended in another way. */
static bool fail_job(struct worker *w, const struct pen_claim *claim, const struct pen_status *why,
                     struct pen_status *st)
{
    bool ok;
    do {
        ok = pen_failure_store(w->store, claim, why, NULL, st) || st->code == PEN_STALE;
    } while (!ok && wait_to_retry(w, "failing a job", st));
    return ok;
}

/* Gives the batch back to the store. If that fails, the lease expires later. */
static bool release(struct worker *w, const struct pen_claim *claim, struct pen_status *st)
{
    return pen_store_release(w->store, claim, st) || is_temporary(st);
}

/* Commits a batch. Unless the worker must stop, the same transaction claims the next batch. */
static bool commit(struct worker *w, const struct pen_claim *claim,
                   const struct pen_batch_output *output, struct pen_next *next,
                   struct pen_status *st)
{
    struct pen_log_about about = pen_claim_about(claim);
    int64_t begin_ns = pen_clock_ns();
    bool ok;
    next->serial = w->serial + 1;
    do {
        ok = pen_store_commit(w->store, claim, &output->result, stopped(w) ? NULL : next, st);
    } while (!ok && wait_to_retry(w, "committing a batch", st));
    w->serial += next->found;
    w->context.store_ms += pen_ms_since(begin_ns);
    if (!ok && st->code == PEN_STALE)
        pen_log_about(PEN_LOG_INFO, &about, "the result was dropped: the claim is no longer held");
    return ok || st->code == PEN_STALE;
}

/* Ends a claim whose batch has failed. If the claim is no longer held, there is nothing to do. Else
 * the job fails, or the batch is given back. */
static bool end_failed(struct worker *w, const struct pen_claim *claim, enum pen_claim_end ended,
                       const struct pen_status *why, struct pen_status *st)
{
    if (ended == PEN_CLAIM_LOST || why->code == PEN_NOT_FOUND || why->code == PEN_GONE ||
        why->code == PEN_STALE)
        return true;
    if (ended == PEN_CLAIM_TIMED_OUT)
        return fail_job(w, claim, NULL, st);
    if (ended == PEN_CLAIM_STOPPED || why->code == PEN_UNAVAILABLE || why->code == PEN_STORAGE_FULL)
        return release(w, claim, st);
    if (why->code == PEN_STORAGE && pen_store_is_broken(w->store, NULL)) {
        *st = *why;
        return false;
    }
    return fail_job(w, claim, why, st);
}

/* Runs the batch. If memory runs out, the caches of earlier jobs are dropped, because this job has
 * not filled them, and the batch is tried once more. */
static bool run_batch(struct worker *w, struct pen_batch_output *output, struct pen_status *why)
{
    if (pen_batch_run(&w->context, output, why))
        return true;
    if (why->code != PEN_NO_MEMORY ||
        atomic_load_explicit(&w->context.exhausted, memory_order_relaxed))
        return false;
    pen_batch_context_drop_caches(&w->context);
    return pen_batch_run(&w->context, output, why);
}

/* Handles a claim: runs the batch and commits the result; then *proven is true. *next becomes the
 * next claim if the commit has taken one. The job is not charged for the time of the commit,
 * because it waits for the store. */
static bool handle_claim(struct worker *w, struct pen_claim *claim, struct pen_next *next,
                         bool *proven, struct pen_status *st)
{
    struct pen_batch_output output;
    struct pen_status why = {.code = PEN_CANCELLED};
    w->context.claim = claim;
    if (!pen_batch_expected(&w->context, &why))
        return fail_job(w, claim, &why, st);
    struct pen_log_about about = pen_claim_about(claim);
    if (claim->kind == PEN_BATCH_STUDY)
        pen_log_about(PEN_LOG_INFO, &about, "%lld runs", (long long)claim->pixels);
    else if (claim->kind == PEN_BATCH_RENDER)
        pen_log_about(PEN_LOG_DEBUG, &about, "%d tiles of view %d from %d on", claim->tile_count,
                      claim->view, claim->first_tile);
    else
        pen_log_about(PEN_LOG_DEBUG, &about, "the picture of view %d", claim->view);
    /* A stop does not wait for a study, which may take long. */
    pen_heartbeat_begin(w->context.heart, claim, claim->kind == PEN_BATCH_STUDY ? w->stop : NULL);
    bool done = !pen_heartbeat_is_late(w->context.heart) && run_batch(w, &output, &why);
    pen_heartbeat_pause(w->context.heart);
    claim->spent_us = pen_heartbeat_spent_us(w->context.heart);
    if (done && claim->kind == PEN_BATCH_RENDER)
        claim->estimate_ms =
            pen_batch_expected_ms(&w->context, (double)output.result.work / PEN_WORK_ALL);
    if (done && pen_heartbeat_is_late(w->context.heart)) {
        pen_batch_output_release(&output);
        done = pen_fail(&why, PEN_CANCELLED, "the time is up");
    }
    bool ok = !done || commit(w, claim, &output, next, st);
    *proven = done && ok;
    enum pen_claim_end ended = pen_heartbeat_end(w->context.heart);
    if (!done)
        return end_failed(w, claim, ended, &why, st);
    pen_batch_output_release(&output);
    return ok;
}

/* Updates this worker's row in the list of workers. After a failure that may pass, the next update
 * tries again. */
static bool update_row(struct worker *w, int64_t now_ns, struct pen_status *st)
{
    const bool has_rate = w->context.rays_per_s > 0;
    if (w->seen_ns && now_ns - w->seen_ns < (int64_t)SEEN_MS * 1000000 && has_rate == w->has_rate)
        return true;
    w->seen_ns = now_ns;
    w->has_rate = has_rate;
    struct pen_worker_new worker = {.id = w->options->id,
                                    .supervisor = w->options->supervisor,
                                    .threads = pen_thread_pool_size(w->context.pool),
                                    .lease_ms = w->lease_ms,
                                    .rays_per_s = (int64_t)w->context.rays_per_s};
    return pen_store_worker_seen(w->store, &worker, st) || is_temporary(st);
}

/* Periodic work: updates this worker's row, opens batches whose leases have expired. */
static bool maintain(struct worker *w, struct pen_status *st)
{
    int64_t now_ns = pen_clock_ns();
    int opened = 0;
    if (!update_row(w, now_ns, st))
        return false;
    if (now_ns - w->expired_ns >= (int64_t)EXPIRE_MS * 1000000) {
        w->expired_ns = now_ns;
        if (!pen_store_expire_leases(w->store, &opened, st))
            return is_temporary(st);
        if (opened > 0)
            pen_log(PEN_LOG_WARN, "%d batches are open again: their leases ran out", opened);
    }
    return true;
}

/* Returns true if the worker must end because it had no work for a while. */
static bool idled(const struct worker *w)
{
    return w->options->idle_ms && pen_clock_ns() - w->worked_ns >= w->options->idle_ms * 1000000;
}

/* Claims a batch. If there is none, waits for a wake-up, at most IDLE_MS. A store that does not
 * answer does not count as no work. */
static bool claim_or_wait(struct worker *w, struct pen_next *next, struct pen_status *st)
{
    next->found = false;
    w->wakeups = pen_store_changes();
    if (!pen_store_claim(w->store, next->worker, next->lease_ms, w->serial + 1, &next->claim,
                         &next->found, st)) {
        w->worked_ns = pen_clock_ns();
        return wait_to_retry(w, "claiming a batch", st) || is_temporary(st);
    }
    w->serial += next->found;
    if (!next->found && !stopped(w))
        pen_store_wait(w->store, &w->wakeups, IDLE_MS);
    return true;
}

static bool run(struct worker *w, struct pen_status *st)
{
    struct pen_next next = {.worker = w->options->id, .lease_ms = w->lease_ms};
    struct pen_trace *trace = w->options->trace;
    pen_store_count(PEN_COUNT_WORKER_STARTS, 1);
    w->worked_ns = pen_clock_ns();
    while (!stopped(w) && !idled(w)) {
        if (!maintain(w, st) || !claim_or_wait(w, &next, st))
            return false;
        while (next.found && !stopped(w)) {
            struct pen_claim claim = next.claim;
            bool proven = false;
            next.found = false;
            if (trace)
                pen_trace_batch(trace, claim.job_id);
            const bool ok = handle_claim(w, &claim, &next, &proven, st);
            if (trace)
                pen_trace_batch_ended(trace, proven);
            if (!ok || !maintain(w, st))
                return false;
            w->worked_ns = pen_clock_ns();
        }
        if (next.found && !release(w, &next.claim, st))
            return false;
    }
    return true;
}

static bool set_up(struct worker *w, struct pen_status *st)
{
    const struct pen_worker_options *o = w->options;
    w->lease_ms = o->lease_ms > 0 ? o->lease_ms : LEASE_MS;
    w->store = w->context.store = pen_store_open(o->store_url, false, st);
    if (!w->store || !(w->context.pool = pen_thread_pool_new(o->threads, st)) ||
        !(w->context.heart = pen_heartbeat_new(o, w->context.pool, w->lease_ms, pen_batch_work_now,
                                               &w->context, st)))
        return false;
    w->context.scenes = pen_scene_cache_new(o->scene_cap_bytes);
    if (!w->context.scenes)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the worker");
    w->housekeeper = pen_housekeeper_new(o, st);
    return w->housekeeper != NULL;
}

static void tear_down(struct worker *w)
{
    pen_housekeeper_free(w->housekeeper);
    pen_heartbeat_free(w->context.heart);
    pen_thread_pool_free(w->context.pool);
    pen_scene_cache_free(w->context.scenes);
    pen_batch_context_release(&w->context);
    pen_store_close(w->store);
}

bool pen_worker_run(const struct pen_worker_options *options, const atomic_bool *stop,
                    struct pen_status *st)
{
    struct worker w = {.options = options,
                       .stop = stop,
                       .context.options = options,
                       .context.work.lock = PTHREAD_MUTEX_INITIALIZER};
    bool ok = set_up(&w, st) && run(&w, st);
    struct pen_status ignored;
    if (w.store)
        pen_worker_check_store(options, w.store);
    if (w.store)
        pen_store_worker_gone(w.store, options->id, &ignored);
    tear_down(&w);
    return ok;
}
