/* SPDX-License-Identifier: MIT */
/* Batches whose worker is gone (README.md, "Lost workers"). Until more is known any of them may
 * have killed it, so all are quarantined. Only the crash of a worker that held one job's batches
 * alone is charged, and to the job: its batches share the scene. */
#include <stdlib.h>

#include "store/internal/policy.h"

enum {
    PAGE = 16,
    FIRST_PAUSE_MS = 250, /* doubled before its first use: the second loss pauses 0.5 s */
    LONGEST_PAUSE_MS = 60000,
    DOUBLINGS = 8,
    TRIES = 8 /* to find the same charge twice */
};

/* What to charge, and to which job: a batch of the only job that the worker held, if there is one.
 */
struct charge {
    bool any;
    struct pen_claim claim;
    int64_t job, charges, max_attempts; /* charges: with this one */
};

/* One call that opens lost batches. */
struct loss {
    struct pen_lost lost;
    bool left;                   /* the worker gave them back: they are not quarantined */
    const struct charge *charge; /* NULL: none is wanted */
    const char *error;           /* of the job that the charge ends; NULL: it does not */
    bool outdated;               /* out: the charge is no longer the one that the error is for */
    int opened;
};

static int64_t pause_ms(int64_t deaths)
{
    int64_t ms = (int64_t)FIRST_PAUSE_MS << (deaths < DOUBLINGS ? deaths : DOUBLINGS);
    return ms < LONGEST_PAUSE_MS ? ms : LONGEST_PAUSE_MS;
}

/* The first loss of a job is retried in its turn; from the second on the job is paused. */
static bool count_death(struct pen_driver *driver, const struct pen_lost_job *job, int64_t now_ms,
                        struct pen_status *st)
{
    int64_t until_ms = job->deaths == 0 ? 0 : now_ms + pause_ms(job->deaths);
    return driver->ops->job_set_deaths(driver, job->number, job->deaths + 1, until_ms, st);
}

static bool count_deaths(struct pen_driver *driver, const struct pen_lost *lost,
                         struct pen_status *st)
{
    struct pen_lost_job jobs[PAGE];
    int64_t now_ms, after = 0;
    int count = PAGE;
    if (!driver->ops->now(driver, &now_ms, st))
        return false;
    while (count == PAGE) {
        if (!driver->ops->lost_jobs(driver, lost, after, jobs, PAGE, &count, st))
            return false;
        for (int i = 0; i < count; i++) {
            if (!count_death(driver, &jobs[i], now_ms, st))
                return false;
            after = jobs[i].number;
        }
    }
    return true;
}

static bool find_charge(struct pen_store *store, const char *worker, struct charge *charge,
                        struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_lost held = {.worker = worker, .before_ms = INT64_MIN};
    struct pen_lost_job jobs[2];
    int count;
    *charge = (struct charge){0};
    if (!driver->ops->lost_jobs(driver, &held, 0, jobs, 2, &count, st))
        return false;
    if (count != 1)
        return true;
    charge->charges = jobs[0].charges + 1;
    charge->max_attempts = jobs[0].max_attempts;
    return driver->ops->first_held(driver, worker, &charge->claim, &charge->job, &charge->any, st);
}

static bool ends_job(const struct charge *charge)
{
    return charge->any && charge->charges >= charge->max_attempts;
}

static bool is_same(const struct charge *a, const struct charge *b)
{
    return a->any == b->any &&
           (!a->any || (a->claim.batch == b->claim.batch && a->claim.attempt == b->claim.attempt &&
                        a->charges == b->charges && a->max_attempts == b->max_attempts));
}

/* Charges the job, and ends it if that was its last attempt. */
static bool write_charge(struct pen_store *store, const struct loss *loss, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    const struct charge *charge = loss->charge;
    int64_t now_ms;
    store->changed = true;
    return driver->ops->now(driver, &now_ms, st) &&
           driver->ops->job_set_charges(driver, charge->job, charge->charges, now_ms, st) &&
           (!loss->error || pen_end_job(store, charge->job, PEN_JOB_FAILED, loss->error, st));
}

/* Whether what was found before the transaction still holds in it. */
static bool confirm_charge(struct pen_store *store, struct loss *loss, struct pen_status *st)
{
    struct charge now;
    if (!loss->charge)
        return true;
    if (!find_charge(store, loss->lost.worker, &now, st))
        return false;
    loss->outdated = !is_same(&now, loss->charge);
    return true;
}

static bool write_loss(struct pen_store *store, void *arg, struct pen_status *st)
{
    struct loss *loss = arg;
    struct pen_driver *driver = store->driver;
    if (!confirm_charge(store, loss, st))
        return false;
    if (loss->outdated)
        return true;
    if ((!loss->left && !count_deaths(driver, &loss->lost, st)) ||
        !driver->ops->open_lost(driver, &loss->lost, !loss->left, &loss->opened, st))
        return false;
    if (loss->error)
        loss->opened = 0; /* they were of this job alone, and it ends */
    store->work = loss->opened > 0;
    return !loss->charge || !loss->charge->any || write_charge(store, loss, st);
}

/* Reads first: most calls find nothing to do. */
static bool open_lost(struct pen_store *store, struct loss *loss, struct pen_status *st)
{
    bool any;
    return store->driver->ops->any_lost(store->driver, &loss->lost, &any, st) &&
           (!any || pen_store_write(store, write_loss, loss, st));
}

bool pen_policy_expire_leases(struct pen_store *store, const char *dead_worker, int *opened,
                              struct pen_status *st)
{
    struct loss loss = {.lost = {.worker = dead_worker}};
    *opened = 0;
    if (!store->driver->ops->now(store->driver, &loss.lost.before_ms, st) ||
        !open_lost(store, &loss, st))
        return false;
    *opened = loss.opened;
    return true;
}

/* One try to bury a crashed worker: what to charge, then the error (the caller's function, outside
 * any transaction), then all changes. */
static bool try_crash(struct pen_store *store, const struct pen_worker_death *death,
                      struct loss *loss, struct pen_status *st)
{
    struct charge charge;
    char *error = NULL;
    if (!find_charge(store, death->worker, &charge, st))
        return false;
    if (ends_job(&charge)) {
        error = death->error(death->user, &charge.claim, (int)charge.charges);
        if (!error)
            return pen_fail(st, PEN_NO_MEMORY, "no memory for the error of a job");
    }
    loss->charge = &charge;
    loss->error = error;
    loss->outdated = false;
    bool ok = open_lost(store, loss, st);
    loss->charge = NULL;
    free(error);
    return ok;
}

static bool open_crashed(struct pen_store *store, const struct pen_worker_death *death,
                         struct loss *loss, struct pen_status *st)
{
    for (int i = 0; i < TRIES; i++) {
        if (!try_crash(store, death, loss, st))
            return false;
        if (!loss->outdated)
            return true;
    }
    return pen_fail(st, PEN_UNAVAILABLE, "the batches of worker %s keep changing", death->worker);
}

bool pen_policy_worker_ended(struct pen_store *store, const struct pen_worker_death *death,
                             int *opened, struct pen_status *st)
{
    struct loss loss = {.lost = {.worker = death->worker, .before_ms = INT64_MIN},
                        .left = death->end == PEN_WORKER_LEFT};
    bool ok = death->end == PEN_WORKER_CRASHED ? open_crashed(store, death, &loss, st)
                                               : open_lost(store, &loss, st);
    *opened = loss.opened;
    return ok;
}

/* Opens the batches of one worker if it does not live, and removes it from the list. */
static bool release_if_dead(struct pen_store *store, const char *id, int *opened,
                            struct pen_status *st)
{
    struct pen_worker_death death = {.worker = id, .end = PEN_WORKER_DIED};
    int more = 0;
    bool lives;
    if (!store->driver->ops->worker_lives(store->driver, id, &lives, st))
        return false;
    if (lives)
        return true;
    if (!pen_policy_worker_ended(store, &death, &more, st) ||
        !pen_policy_worker_gone(store, id, st))
        return false;
    *opened += more;
    return true;
}

/* One page of workers; *last is the last of them, "" after the last page. */
static bool release_page(struct pen_store *store, struct pen_arena *arena, const char **last,
                         int *opened, struct pen_status *st)
{
    const char *ids[PAGE];
    int count;
    if (!store->driver->ops->worker_id_page(store->driver, *last, arena, ids, PAGE, &count, st))
        return false;
    for (int i = 0; i < count; i++) {
        if (!release_if_dead(store, ids[i], opened, st))
            return false;
    }
    *last = count == PAGE ? ids[PAGE - 1] : NULL;
    return true;
}

bool pen_policy_release_dead(struct pen_store *store, int *opened, struct pen_status *st)
{
    struct pen_arena *arena = pen_arena_new(0);
    const char *last = "";
    *opened = 0;
    if (!arena)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a list of workers");
    bool ok = true;
    while (ok && last)
        ok = release_page(store, arena, &last, opened, st);
    pen_arena_free(arena);
    return ok;
}
