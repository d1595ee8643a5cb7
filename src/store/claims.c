/* SPDX-License-Identifier: MIT */
/* Leases: claim, heartbeat, progress, estimate, release, fail. A lease is (batch, attempt). The
 * attempt grows with every claim, and every call of a holder names both (README.md, "Leases and
 * fencing"). */
#include <stdlib.h>

#include "store/internal/policy.h"

/* What a worker may claim, given what it holds. */
struct allowance {
    bool any;   /* anything: it holds no batch that must be held alone */
    bool alone; /* also quarantined batches and studies: it holds nothing */
};

static bool read_allowance(struct pen_driver *driver, const char *worker,
                           struct allowance *allowance, struct pen_status *st)
{
    int count, alone;
    if (!driver->ops->held_by(driver, worker, &count, &alone, st))
        return false;
    *allowance = (struct allowance){.any = alone == 0, .alone = count == 0};
    return true;
}

/* Finds the open batch that is next. Batches of paused jobs come after all others. */
static bool find_open(struct pen_driver *driver, int64_t now_ms, bool alone, struct pen_next *next,
                      int64_t *job, struct pen_status *st)
{
    const struct pen_driver_ops *ops = driver->ops;
    struct pen_claim *claim = &next->claim;
    if (!ops->next_open(driver, now_ms, alone, claim, job, &next->found, st))
        return false;
    return next->found || ops->next_open(driver, INT64_MAX, alone, claim, job, &next->found, st);
}

static bool lease(struct pen_store *store, struct pen_next *next, int64_t job, int64_t now_ms,
                  struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_claim *claim = &next->claim;
    bool started;
    claim->attempt++;
    claim->claimed_ms = now_ms;
    if (claim->started_ms == 0)
        claim->started_ms = now_ms;
    if (!driver->ops->batch_lease(driver, claim->batch, claim->attempt, next->worker,
                                  now_ms + next->lease_ms, &next->found, st))
        return false;
    if (!next->found)
        return true;
    if (!driver->ops->share_served(driver, claim->batch, now_ms, st) ||
        !driver->ops->job_start(driver, job, now_ms, &started, st))
        return false;
    store->changed = store->changed || started;
    return true;
}

bool pen_take_next(struct pen_store *store, struct pen_next *next, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct allowance allowance;
    int64_t now_ms, job = 0;
    next->found = false;
    if (!driver->ops->now(driver, &now_ms, st) ||
        !read_allowance(driver, next->worker, &allowance, st))
        return false;
    if (!allowance.any)
        return true;
    if (!find_open(driver, now_ms, allowance.alone, next, &job, st))
        return false;
    /* A study is not passed over: the worker claims nothing until it holds nothing. */
    if (next->found && next->claim.kind == PEN_BATCH_STUDY && !allowance.alone)
        next->found = false;
    return !next->found || lease(store, next, job, now_ms, st);
}

static bool write_claim(struct pen_store *store, void *arg, struct pen_status *st)
{
    return pen_take_next(store, arg, st);
}

/* Reads first, so that an idle worker does not write. */
bool pen_policy_claim(struct pen_store *store, const char *worker, int64_t lease_ms,
                      struct pen_claim *claim, bool *found, struct pen_status *st)
{
    struct pen_next next = {.worker = worker, .lease_ms = lease_ms};
    bool any;
    *found = false;
    if (!store->driver->ops->any_open(store->driver, &any, st))
        return false;
    if (!any)
        return true;
    if (!pen_store_write(store, write_claim, &next, st))
        return false;
    *found = next.found;
    if (next.found)
        *claim = next.claim;
    return true;
}

bool pen_check_fence(struct pen_store *store, const struct pen_claim *claim,
                     struct pen_batch_row *row, bool *held, struct pen_status *st)
{
    bool found;
    *row = (struct pen_batch_row){.state = PEN_BATCH_STATE_COUNT};
    if (!store->driver->ops->batch_get(store->driver, claim->batch, row, &found, st))
        return false;
    *held = found && row->state == PEN_BATCH_LEASED && row->attempt == claim->attempt;
    return true;
}

bool pen_charge_time(struct pen_store *store, const struct pen_claim *claim, struct pen_status *st)
{
    return claim->spent_us <= 0 ||
           store->driver->ops->batch_spend(store->driver, claim->batch, claim->attempt,
                                           claim->spent_us, st);
}

int64_t pen_work_of_pixels(const struct pen_batch_row *batch, int64_t pixels)
{
    const double share = (double)pixels / (double)batch->job_pixels;
    return (int64_t)(share < 1 ? PEN_WORK_ALL * share : PEN_WORK_ALL);
}

struct progress {
    const struct pen_claim *claim;
    struct pen_progress what;
    bool runs; /* it is a study's, which tells time and work, too */
};

static bool write_progress(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct progress *in = arg;
    struct pen_driver *driver = store->driver;
    struct pen_batch_row batch;
    struct pen_progress progress = in->what;
    bool held;
    if (!pen_check_fence(store, in->claim, &batch, &held, st) ||
        !driver->ops->now(driver, &progress.now_ms, st))
        return false;
    if (!held)
        return pen_fail(st, PEN_STALE, "the batch is no longer held; its progress was refused");
    progress.job = batch.job;
    if (in->runs) {
        progress.batch = in->claim->batch;
        progress.work = pen_work_of_pixels(&batch, progress.pixels);
    }
    store->changed = true;
    return pen_charge_time(store, in->claim, st) &&
           driver->ops->job_progress(driver, &progress, st);
}

bool pen_policy_progress(struct pen_store *store, const struct pen_claim *claim, int64_t done,
                         struct pen_status *st)
{
    struct progress progress = {claim, {.pixels = done, .estimate_ms = claim->estimate_ms}, true};
    return pen_store_write(store, write_progress, &progress, st);
}

/* A batch that takes long gives way from time to time to others of its priority, and to those that
 * have come above it by waiting. Of these there may be many: so it has a turn between two of them
 * that is longer than what it takes to keep its state and to read it again. */
enum { TURN_MS = 60000, AGED_TURN_MS = 5000 };

bool pen_outranked(struct pen_driver *driver, const struct pen_claim *claim, int64_t now_ms,
                   bool *outranked, struct pen_status *st)
{
    const int64_t held_ms = pen_since_ms(claim->claimed_ms, now_ms);
    return driver->ops->open_above(driver, claim->batch, now_ms, held_ms >= AGED_TURN_MS,
                                   held_ms >= TURN_MS, outranked, st);
}

struct keep {
    const struct pen_claim *claim;
    const struct pen_kept *kept;
    struct pen_value *values; /* the state, then the parts that come with it */
    bool outranked;
};

static int64_t kept_bytes(const struct pen_kept *kept)
{
    size_t bytes = kept->bytes;
    for (int i = 0; i < kept->part_count; i++)
        bytes += kept->parts[i].bytes;
    return (int64_t)bytes;
}

/* Stores the values, so far as they are too large for one transaction. */
static bool store_values(struct pen_store *store, struct keep *keep, struct pen_status *st)
{
    const struct pen_kept *kept = keep->kept;
    keep->values = calloc((size_t)kept->part_count + 1, sizeof *keep->values);
    if (!keep->values)
        return pen_fail(st, PEN_NO_MEMORY, "no memory to keep what a batch has");
    bool ok = pen_value_store_if(store, keep->claim, pen_admit_kept, kept->data, kept->bytes,
                                 keep->values, st);
    for (int i = 0; ok && i < kept->part_count; i++)
        ok = pen_value_store_if(store, keep->claim, pen_admit_kept, kept->parts[i].data,
                                kept->parts[i].bytes, &keep->values[i + 1], st);
    return ok;
}

/* Refuses what is not stored yet, if there is no space for it. */
static bool admit_rest(struct pen_store *store, const struct keep *keep, struct pen_status *st)
{
    int64_t bytes = 0;
    for (int i = 0; i <= keep->kept->part_count; i++)
        bytes += keep->values[i].object > 0 ? 0 : (int64_t)keep->values[i].bytes;
    return bytes == 0 || pen_admit_kept(store, bytes, st);
}

/* Makes the values those that the batch keeps. */
static bool put_kept(struct pen_store *store, const struct pen_batch_row *batch,
                     const struct keep *keep, struct pen_status *st)
{
    struct pen_artefact_key key = {
        .job = batch->job, .view = batch->view, .layer = PEN_KEPT_LAYER, .format = PEN_KEPT_STATE};
    int64_t number;
    bool ok = !keep->kept->data || pen_put_artefact(store, &key, keep->values, &number, st);
    for (int i = 0; ok && i < keep->kept->part_count; i++) {
        key.format = keep->kept->parts[i].name;
        ok = pen_put_artefact(store, &key, &keep->values[i + 1], &number, st);
    }
    return ok;
}

static bool write_kept(struct pen_store *store, void *arg, struct pen_status *st)
{
    struct keep *keep = arg;
    struct pen_driver *driver = store->driver;
    struct pen_batch_row batch;
    struct pen_progress progress = {.pixels = keep->kept->done};
    bool held;
    if (!pen_check_fence(store, keep->claim, &batch, &held, st) ||
        !driver->ops->now(driver, &progress.now_ms, st))
        return false;
    if (!held)
        return pen_fail(st, PEN_STALE, "the batch is no longer held; what it kept was refused");
    progress.job = batch.job;
    progress.raise = batch.kind == PEN_BATCH_RENDER;
    progress.batch = keep->kept->done < 0 ? 0 : keep->claim->batch;
    progress.work = pen_work_of_pixels(&batch, progress.pixels);
    if (progress.work < batch.work)
        progress.work = batch.work;
    store->changed = true;
    return admit_rest(store, keep, st) &&
           (keep->kept->done < 0 || driver->ops->job_progress(driver, &progress, st)) &&
           put_kept(store, &batch, keep, st) &&
           pen_outranked(driver, keep->claim, progress.now_ms, &keep->outranked, st);
}

bool pen_policy_keep(struct pen_store *store, const struct pen_claim *claim,
                     const struct pen_kept *kept, bool *outranked, struct pen_status *st)
{
    struct keep keep = {.claim = claim, .kept = kept};
    const bool ok = pen_admit_kept(store, kept_bytes(kept), st) && store_values(store, &keep, st) &&
                    pen_store_write(store, write_kept, &keep, st);
    for (int i = 0; !ok && keep.values && i <= kept->part_count; i++)
        pen_value_drop(store, &keep.values[i]);
    free(keep.values);
    *outranked = ok && keep.outranked;
    return ok;
}

bool pen_policy_estimate(struct pen_store *store, const struct pen_claim *claim,
                         int64_t estimate_ms, const struct pen_buf *cost_map, struct pen_status *st)
{
    struct progress progress = {
        claim, {.add = true, .estimate_ms = estimate_ms, .cost_map = cost_map}, false};
    return pen_store_write(store, write_progress, &progress, st);
}

static bool write_release(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct pen_claim *claim = arg;
    return pen_charge_time(store, claim, st) &&
           store->driver->ops->batch_open(store->driver, claim->batch, claim->attempt, &store->work,
                                          st);
}

bool pen_policy_release(struct pen_store *store, const struct pen_claim *claim,
                        struct pen_status *st)
{
    return pen_store_write(store, write_release, (void *)(uintptr_t)claim, st);
}

struct failure {
    const struct pen_claim *claim;
    const char *error;
};

static bool write_failure(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct failure *failure = arg;
    struct pen_batch_row batch;
    bool held;
    if (!pen_check_fence(store, failure->claim, &batch, &held, st))
        return false;
    if (!held)
        return pen_fail(st, PEN_STALE, "the batch is no longer held; its job was left as it is");
    return pen_charge_time(store, failure->claim, st) &&
           pen_end_job(store, batch.job, PEN_JOB_FAILED, failure->error, st);
}

bool pen_policy_fail(struct pen_store *store, const struct pen_claim *claim, const char *error,
                     struct pen_status *st)
{
    struct failure failure = {claim, error};
    return pen_store_write(store, write_failure, &failure, st);
}

struct extension {
    const struct pen_claim *claim;
    int64_t job, now_ms, until_ms;
    bool held;
};

static bool tell(struct pen_store *store, const struct extension *extension, struct pen_status *st)
{
    const struct pen_claim *claim = extension->claim;
    const struct pen_progress progress = {.job = extension->job,
                                          .now_ms = extension->now_ms,
                                          .add = true,
                                          .estimate_ms = claim->estimate_ms,
                                          .batch = claim->batch,
                                          .work = claim->work};
    store->changed = true;
    return store->driver->ops->job_progress(store->driver, &progress, st);
}

/* Mends times, too, since a worker with a batch that takes long does nothing else that would. */
static bool write_extension(struct pen_store *store, void *arg, struct pen_status *st)
{
    struct extension *extension = arg;
    return store->driver->ops->times_mend(store->driver, extension->now_ms, st) &&
           pen_charge_time(store, extension->claim, st) &&
           store->driver->ops->batch_extend(store->driver, extension->claim->batch,
                                            extension->claim->attempt, extension->until_ms,
                                            &extension->held, st) &&
           (!extension->held || extension->claim->estimate_ms == 0 || tell(store, extension, st));
}

bool pen_policy_heartbeat(struct pen_store *store, struct pen_claim *claim, int64_t lease_ms,
                          bool *held, struct pen_status *st)
{
    struct pen_batch_row batch;
    int64_t now_ms;
    if (!pen_check_fence(store, claim, &batch, held, st) ||
        !store->driver->ops->now(store->driver, &now_ms, st))
        return false;
    if (*held) {
        claim->job_spent_us = batch.job_spent_us - batch.spent_us;
        claim->job_work = batch.job_work - batch.work;
    }
    const int64_t left_ms = batch.lease_until_ms > now_ms ? batch.lease_until_ms - now_ms : 0;
    if (!*held ||
        (claim->estimate_ms == 0 && left_ms >= lease_ms - lease_ms / 3 && left_ms <= lease_ms))
        return true;
    struct extension extension = {
        .claim = claim, .job = batch.job, .now_ms = now_ms, .until_ms = now_ms + lease_ms};
    if (!pen_store_write(store, write_extension, &extension, st))
        return false;
    *held = extension.held;
    return true;
}
