/* SPDX-License-Identifier: MIT */
/* The worker's loop, and what it does when something goes wrong:
 *
 *   the job's fault (scene, memory, time)   the job fails with the problem
 *   the lease is lost, the job cancelled    the result is thrown away
 *   it is to end in mid benchmark           the benchmark is given back, to begin anew elsewhere
 *   the store is busy, full or ill          it tries again, holding what it has; the store mends
 *                                           itself under such calls once its disk works again
 *   the store could not be read meanwhile   the batch is begun again once it can
 *
 * A result is kept until the store has said that it is stored or not wanted: an unknown outcome is
 * asked again, since a commit may be repeated. */
#include "jobs/worker.h"

#include <stdlib.h>
#include <time.h>

#include "base/clock.h"
#include "base/log.h"
#include "jobs/internal/batch.h"
#include "jobs/internal/failure.h"
#include "jobs/internal/jobs.h"

enum {
    LEASE_MS = 15000,
    IDLE_MS = 1000,       /* how long to wait for a hint before looking anyway */
    RETRY_MS = 250,       /* between tries of a busy or failing store */
    SAY_MS = 10000,       /* between lines of the log about the same failure */
    READ_TRIES = 5,       /* of a batch that the store could not be read for */
    MEMORY_TRIES = 20,    /* of what there was no memory for; memory held here does not come back */
    SWEEP_MS = 1000,      /* between looks for leases that ran out */
    TIDY_MS = 600000,     /* between housekeepings */
    SEEN_MS = 15000,      /* between signs of life in the list of workers */
    KEY_AGE_MS = 86400000 /* idempotency keys hold for 24 hours */
};

struct worker {
    const struct pen_worker_options *options;
    const atomic_bool *stop;
    int64_t lease_ms;
    struct pen_store *store;
    struct pen_batch_room room;
    int64_t swept_ns, tidied_ns, seen_ns;
    int memory_tries; /* in a row */
    int64_t said_ns;  /* when a failure of the store was last logged */
    enum pen_code said;
    uint32_t seen; /* the last hint */
};

static bool stopped(const struct worker *w)
{
    return atomic_load_explicit(w->stop, memory_order_relaxed);
}

static void pause_ms(int ms)
{
    struct timespec time = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L};
    nanosleep(&time, NULL);
}

/* Whether waiting may help. */
static bool is_passing(const struct pen_status *st)
{
    return st->code == PEN_UNAVAILABLE || st->code == PEN_STORAGE_FULL || st->code == PEN_STORAGE ||
           st->code == PEN_NO_MEMORY;
}

/* A store may be ill for hours: the log is told now and then. */
static void say(struct worker *w, const char *what, const struct pen_status *st)
{
    int64_t now_ns = pen_clock_ns();
    if (w->said == st->code && now_ns - w->said_ns < (int64_t)SAY_MS * 1000000)
        return;
    w->said = st->code;
    w->said_ns = now_ns;
    pen_log(PEN_LOG_WARN, "%s: %s; trying again", what, st->msg);
}

/* Waits before the next try of what the store refused. Returns whether to try at all. */
static bool wait_to_retry(struct worker *w, const char *what, const struct pen_status *st)
{
    w->memory_tries = st->code == PEN_NO_MEMORY ? w->memory_tries + 1 : 0;
    if (!is_passing(st) || stopped(w) || w->memory_tries > MEMORY_TRIES)
        return false;
    say(w, what, st);
    pause_ms(RETRY_MS);
    return true;
}

/* Ends the job as failed. A claim that is no longer held means that it has ended otherwise.
 * Takes the error. */
static bool fail_job(struct worker *w, const struct pen_claim *claim, char *error,
                     struct pen_status *st)
{
    if (!error)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for an error");
    bool ok;
    do {
        ok = pen_failure_store(w->store, claim, error, st) || st->code == PEN_STALE;
    } while (!ok && wait_to_retry(w, "failing a job", st));
    free(error);
    return ok;
}

static bool release(struct worker *w, const struct pen_claim *claim, struct pen_status *st)
{
    return pen_store_release(w->store, claim, st) || is_passing(st);
}

/* Commits; the next claim comes in the same transaction unless the worker is to stop. */
static bool commit(struct worker *w, const struct pen_claim *claim,
                   const struct pen_batch_work *work, struct pen_next *next, struct pen_status *st)
{
    struct pen_log_about about = pen_claim_about(claim);
    int64_t begin_ns = pen_clock_ns();
    bool ok;
    do {
        if (stopped(w))
            ok = pen_store_commit(w->store, claim, &work->result, st);
        else
            ok = pen_store_commit_and_claim(w->store, claim, &work->result, next, st);
    } while (!ok && wait_to_retry(w, "committing a batch", st));
    w->room.store_ms += (double)(pen_clock_ns() - begin_ns) * 1e-6;
    if (pen_store_checkpoint_due(w->store))
        pen_heartbeat_settle(w->room.heart);
    if (!ok && st->code == PEN_STALE)
        pen_log_about(PEN_LOG_INFO, &about, "the batch was no longer wanted");
    return ok || st->code == PEN_STALE;
}

/* What to do about a batch that did not come out. */
static bool give_up(struct worker *w, const struct pen_claim *claim, enum pen_beat_end ended,
                    const struct pen_status *why, struct pen_status *st)
{
    if (ended == PEN_BEAT_LOST || why->code == PEN_NOT_FOUND || why->code == PEN_STALE)
        return true;
    if (ended == PEN_BEAT_TIME_UP)
        return fail_job(w, claim, pen_failure_of_time(w->store, claim, NULL), st);
    bool stopped_ill = why->code == PEN_STORAGE && stopped(w);
    if (ended == PEN_BEAT_STOPPED || why->code == PEN_UNAVAILABLE ||
        why->code == PEN_STORAGE_FULL || stopped_ill)
        return release(w, claim, st);
    return fail_job(w, claim, pen_failure_of(w->store, claim, why), st);
}

/* Whether the job had no time left when this claim was taken; the heartbeat sees only those who
 * run out of it while they work. */
static bool is_late(const struct pen_claim *claim)
{
    return claim->timeout_ms && claim->claimed_ms - claim->started_ms >= claim->timeout_ms;
}

/* Whether the store takes writes, now or after a while. */
static bool wait_for_store(struct worker *w)
{
    struct pen_status st;
    while (!pen_store_probe(w->store, &st)) {
        if (!wait_to_retry(w, "reading what a batch needs", &st))
            return false;
    }
    return true;
}

/* What scenes of earlier jobs take is not this job's fault: without them it gets a second try. */
static bool do_batch(struct worker *w, const struct pen_claim *claim, struct pen_batch_work *work,
                     struct pen_status *why)
{
    if (pen_batch_do(&w->room, claim, work, why))
        return true;
    if (why->code != PEN_NO_MEMORY ||
        atomic_load_explicit(&w->room.exhausted, memory_order_relaxed))
        return false;
    pen_batch_room_empty(&w->room);
    return pen_batch_do(&w->room, claim, work, why);
}

/* What the store could not be read for is tried again; what is wrong with a store that is well is
 * wrong with what it has of this job. */
static bool do_batch_with_patience(struct worker *w, const struct pen_claim *claim,
                                   struct pen_batch_work *work, struct pen_status *why)
{
    for (int tries = 1;; tries++) {
        if (do_batch(w, claim, work, why))
            return true;
        if (why->code != PEN_STORAGE || tries == READ_TRIES || !wait_for_store(w))
            return false;
    }
}

/* Works on a claim. *next is the claim after it, if one came along. */
static bool work_on(struct worker *w, const struct pen_claim *claim, struct pen_next *next,
                    struct pen_status *st)
{
    struct pen_batch_work work;
    struct pen_status why;
    if (is_late(claim))
        return fail_job(w, claim, pen_failure_of_time(w->store, claim, NULL), st);
    struct pen_log_about about = pen_claim_about(claim);
    if (claim->kind == PEN_BATCH_STUDY)
        pen_log_about(PEN_LOG_INFO, &about, "a benchmark of %lld runs", (long long)claim->pixels);
    else if (claim->kind == PEN_BATCH_RENDER)
        pen_log_about(PEN_LOG_DEBUG, &about, "%d tiles of view %d from %d on", claim->tile_count,
                      claim->view, claim->first_tile);
    else
        pen_log_about(PEN_LOG_DEBUG, &about, "the picture of view %d", claim->view);
    /* A study takes too long to be waited for. */
    pen_heartbeat_begin(w->room.heart, claim, claim->kind == PEN_BATCH_STUDY ? w->stop : NULL);
    bool done = do_batch_with_patience(w, claim, &work, &why);
    if (done && pen_heartbeat_is_late(w->room.heart)) {
        pen_batch_work_release(&work);
        done = pen_fail(&why, PEN_CANCELLED, "the time is up");
    }
    bool ok = !done || commit(w, claim, &work, next, st);
    enum pen_beat_end ended = pen_heartbeat_end(w->room.heart);
    if (!done)
        return give_up(w, claim, ended, &why, st);
    pen_batch_work_release(&work);
    return ok;
}

/* Says that it is there. Nothing depends on it: the next time will do. */
static void show_up(struct worker *w, int64_t now_ns)
{
    struct pen_status ignored;
    if (w->seen_ns && now_ns - w->seen_ns < (int64_t)SEEN_MS * 1000000)
        return;
    w->seen_ns = now_ns;
    pen_store_worker_seen(w->store, w->options->name, pen_thread_pool_size(w->room.pool),
                          w->lease_ms, &ignored);
}

static bool sweep_and_tidy(struct worker *w, struct pen_status *st)
{
    int64_t now_ns = pen_clock_ns();
    int opened = 0;
    show_up(w, now_ns);
    if (now_ns - w->swept_ns >= (int64_t)SWEEP_MS * 1000000) {
        w->swept_ns = now_ns;
        if (!pen_store_expire_leases(w->store, NULL, &opened, st))
            return is_passing(st);
        if (opened > 0)
            pen_log(PEN_LOG_WARN, "%d batches were opened again: their leases ran out", opened);
    }
    if (now_ns - w->tidied_ns >= (int64_t)TIDY_MS * 1000000) {
        w->tidied_ns = now_ns;
        if (!pen_store_purge(w->store, KEY_AGE_MS, st))
            return is_passing(st);
    }
    return true;
}

/* Claims, waiting for a hint or a while when there is nothing. */
static bool claim_or_wait(struct worker *w, struct pen_next *next, struct pen_status *st)
{
    next->found = false;
    if (!pen_store_claim(w->store, next->worker, next->lease_ms, &next->claim, &next->found, st))
        return wait_to_retry(w, "claiming a batch", st) || is_passing(st);
    if (!next->found && !stopped(w))
        pen_store_wait(w->store, PEN_SIGNAL_WORK, &w->seen, IDLE_MS);
    return true;
}

static bool run(struct worker *w, struct pen_status *st)
{
    struct pen_next next = {.worker = w->options->name, .lease_ms = w->lease_ms};
    pen_store_wait(w->store, PEN_SIGNAL_WORK, &w->seen, 0);
    w->tidied_ns = pen_clock_ns();
    while (!stopped(w)) {
        if (!sweep_and_tidy(w, st) || !claim_or_wait(w, &next, st))
            return false;
        while (next.found && !stopped(w)) {
            struct pen_claim claim = next.claim;
            next.found = false;
            if (!work_on(w, &claim, &next, st) || !sweep_and_tidy(w, st))
                return false;
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
    w->room.trace = o->trace;
    w->room.fault = o->fault;
    w->store = w->room.store = pen_store_open(o->store_url, st);
    if (!w->store || !(w->room.pool = pen_thread_pool_new(o->threads, st)) ||
        !(w->room.heart = pen_heartbeat_new(o, w->lease_ms, st)))
        return false;
    pen_store_observe(w->store, o->observer);
    pen_store_delegate_checkpoints(w->store);
    if (!(w->room.packing = pen_packing_new(o->observer, st)))
        return false;
    w->room.scenes = pen_scene_cache_new(o->scene_cap_bytes);
    return w->room.scenes || pen_fail(st, PEN_NO_MEMORY, "no memory for the worker");
}

static void tear_down(struct worker *w)
{
    pen_heartbeat_free(w->room.heart);
    pen_packing_free(w->room.packing);
    pen_thread_pool_free(w->room.pool);
    pen_scene_cache_free(w->room.scenes);
    pen_batch_room_release(&w->room);
    pen_store_close(w->store);
}

bool pen_worker_run(const struct pen_worker_options *options, const atomic_bool *stop,
                    struct pen_status *st)
{
    struct worker w = {.options = options, .stop = stop};
    bool ok = set_up(&w, st) && run(&w, st);
    struct pen_status ignored;
    if (w.store)
        pen_store_worker_gone(w.store, options->name, &ignored);
    tear_down(&w);
    return ok;
}
