/* SPDX-License-Identifier: MIT */
/* Batches whose worker is lost (README.md, "Lost workers, charges and pauses"). Any of them may
 * have killed the worker, so all are quarantined. A crash is charged only if the worker held
 * batches of one job, and it is charged to the job, because its batches share the scene. Also here:
 * batches that are set back since the disk has no space for their results. */
#include <stdlib.h>

#include "store/internal/policy.h"

enum {
    PAGE = 16,
    FIRST_PAUSE_MS = 250, /* doubled once before its first use: the second loss pauses for 0.5 s */
    DOUBLINGS = 8,
    TRIES = 8,           /* to find the same charge before and in the transaction */
    SET_BACKS = 16,      /* for lack of space; then the job fails, */
    SET_BACK_MS = 600000 /* but not so soon after its begin */
};

/* A charge for a crash. */
struct charge {
    bool any;               /* false: the worker held no batch, or batches of several jobs */
    struct pen_claim claim; /* a batch that the worker held */
    int64_t job, charges, max_attempts; /* charges: of the job, including this one */
};

/* The input and output of a call that opens lost batches. */
struct loss {
    struct pen_lost lost;
    bool left;                   /* the worker gave its batches back: they are not quarantined */
    const struct charge *charge; /* NULL: nothing is charged */
    const char *error;           /* of the job, if the charge ends it; else NULL */
    bool outdated;               /* out: the charge has changed since the error was made */
    int opened;                  /* out: number of batches */
};

static int64_t pause_ms(int64_t deaths)
{
    int64_t ms = (int64_t)FIRST_PAUSE_MS << (deaths < DOUBLINGS ? deaths : DOUBLINGS);
    return ms < PEN_PAUSE_MAX_MS ? ms : PEN_PAUSE_MAX_MS;
}

/* After its first loss a job is retried in its turn; from the second loss on it is paused. */
static bool count_death(struct pen_driver *driver, const struct pen_lost_job *job, int64_t now_ms,
                        struct pen_status *st)
{
    int64_t until_ms = job->deaths == 0 ? 0 : now_ms + pause_ms(job->deaths);
    return driver->ops->job_set_deaths(driver, job->number, job->deaths + 1, until_ms, st);
}

struct set_back {
    const struct pen_claim *claim;
    const char *error;
};

/* It counts as a loss of the job, and pauses it at once: others shall come before it. */
static bool write_set_back(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct set_back *in = arg;
    struct pen_driver *driver = store->driver;
    struct pen_batch_row batch;
    int64_t now_ms;
    bool held;
    if (!pen_check_fence(store, in->claim, &batch, &held, st) ||
        !driver->ops->now(driver, &now_ms, st))
        return false;
    if (!held)
        return true;
    if (!pen_charge_time(store, in->claim, st))
        return false;
    const int64_t deaths = batch.job_deaths > 0 ? batch.job_deaths : 1;
    if (deaths >= SET_BACKS && pen_since_ms(batch.job_started_ms, now_ms) >= SET_BACK_MS)
        return pen_end_job(store, batch.job, PEN_JOB_FAILED, in->error, st);
    return driver->ops->job_set_deaths(driver, batch.job, deaths + 1, now_ms + pause_ms(deaths),
                                       st) &&
           driver->ops->batch_open(driver, in->claim->batch, in->claim->attempt, &store->work, st);
}

bool pen_policy_set_back(struct pen_store *store, const struct pen_claim *claim, const char *error,
                         bool always, bool *set_back, struct pen_status *st)
{
    struct set_back in = {claim, error};
    struct pen_driver *driver = store->driver;
    int64_t now_ms;
    *set_back = always;
    if (!always && (!driver->ops->now(driver, &now_ms, st) ||
                    !driver->ops->open_elsewhere(driver, claim->batch, now_ms, set_back, st)))
        return false;
    if (!*set_back)
        return true;
    *set_back = pen_store_write(store, write_set_back, &in, st);
    return *set_back;
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

/* Charges the job, and ends it if this was its last attempt. */
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

/* Finds out, in the transaction, whether the charge found before it is still the same. */
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
        loss->opened = 0; /* all were batches of this job, which ends */
    store->work = loss->opened > 0;
    return !loss->charge || !loss->charge->any || write_charge(store, loss, st);
}

/* Reads first, because most calls find nothing to do. */
static bool open_lost(struct pen_store *store, struct loss *loss, struct pen_status *st)
{
    bool any;
    if (!store->driver->ops->any_lost(store->driver, &loss->lost, &any, st) ||
        (any && !pen_store_write(store, write_loss, loss, st)))
        return false;
    if (!loss->left && !loss->outdated && loss->opened > 0)
        pen_store_tally_add(store, PEN_TALLY_LEASES_LOST, (uint64_t)loss->opened);
    return true;
}

bool pen_policy_expire_leases(struct pen_store *store, const char *dead_worker, int *opened,
                              struct pen_status *st)
{
    struct loss loss = {.lost = {.worker = dead_worker}};
    *opened = 0;
    if (!store->driver->ops->now(store->driver, &loss.lost.before_ms, st) ||
        !pen_times_mend(store, loss.lost.before_ms, st) || !open_lost(store, &loss, st))
        return false;
    *opened = loss.opened;
    return true;
}

/* One try to handle a crash: finds the charge, lets the caller make the error, outside any
 * transaction, and then makes all changes in one transaction. */
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

/* If the worker is dead, opens its batches and removes it from the list. */
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

/* Does so for a page of workers above *last, which becomes the last of them; NULL: there are no
 * more. */
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
