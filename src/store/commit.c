/* SPDX-License-Identifier: MIT */
/* The commit of a batch (README.md, "Commit"): fenced by the attempt, idempotent; pixels and state
 * become visible in one transaction. Assemble batches make pictures from committed pixels. */
#include "base/clock.h"
#include "store/internal/policy.h"

struct commit {
    const struct pen_claim *claim;
    const struct pen_result *result;
    struct pen_value pixels, artefact; /* the pixels are encoded */
    struct pen_next *next;             /* NULL: none wanted */
    bool duplicate;                    /* out */
    struct pen_batch_row batch;
    int64_t now_ms;
};

static bool add_progress(struct pen_driver *driver, const struct commit *commit,
                         struct pen_status *st)
{
    const struct pen_batch_row *batch = &commit->batch;
    struct pen_progress progress = {
        .job = batch->job,
        .pixels = batch->kind == PEN_BATCH_ASSEMBLE ? 0 : batch->pixels,
        .now_ms = commit->now_ms,
        .batch = commit->claim->batch,
        .work = commit->result->work,
        .estimate_ms = commit->claim->estimate_ms,
        .add = batch->kind != PEN_BATCH_STUDY, /* a study has stored its progress already */
        .forgive = true,
        /* A batch that has a view for itself may have told a part of its pixels (pen_store_keep).
         */
        .raise = batch->kind == PEN_BATCH_RENDER && commit->claim->view_batches <= 1,
    };
    if (progress.work == 0)
        progress.work = pen_work_of_pixels(batch, progress.pixels);
    return driver->ops->job_progress(driver, &progress, st);
}

static bool add_pixels(struct pen_store *store, const struct commit *commit, struct pen_status *st)
{
    struct pen_blob_start start = pen_value_begin(&commit->pixels);
    int64_t batch = commit->claim->batch;
    return store->driver->ops->pixels_add(store->driver, batch, &start, st) &&
           pen_value_finish(store, PEN_BLOB_PIXELS, batch, &commit->pixels, st);
}

static bool add_artefact(struct pen_store *store, const struct commit *commit,
                         struct pen_status *st)
{
    const struct pen_result *result = commit->result;
    struct pen_artefact_key key = {.job = commit->batch.job,
                                   .view = commit->batch.view,
                                   .layer = result->layer,
                                   .format = result->format};
    int64_t number;
    return pen_put_artefact(store, &key, &commit->artefact, &number, st);
}

/* If the view has an assemble batch already, the unique index on these leaves it the only one. */
static bool add_assemble_batch(struct pen_store *store, const struct commit *commit,
                               struct pen_status *st)
{
    struct pen_batch_add add = {.job = commit->batch.job,
                                .batch = {.view = commit->batch.view, .kind = PEN_BATCH_ASSEMBLE}};
    bool added;
    store->work = true;
    return store->driver->ops->batch_add(store->driver, &add, &added, st);
}

/* What the view's batches kept is of no more use. */
static bool drop_kept(struct pen_store *store, const struct commit *commit, struct pen_status *st)
{
    const struct pen_artefact_key key = {
        .job = commit->batch.job, .view = commit->batch.view, .layer = PEN_KEPT_LAYER};
    return store->driver->ops->artefacts_drop(store->driver, &key, st);
}

static bool end_view(struct pen_store *store, const struct commit *commit, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    int64_t open_views;
    if (!commit->result->artefact)
        return pen_fail(st, PEN_INTERNAL,
                        "the batch that ends a view was committed without its picture or report");
    if (!drop_kept(store, commit, st) ||
        !driver->ops->job_view_ended(driver, commit->batch.job, &open_views, st))
        return false;
    return open_views > 0 ||
           driver->ops->job_succeed(driver, commit->batch.job, commit->now_ms, st);
}

/* Subtracts a batch from the view's open ones. After the last one the view ends or, if it had
 * several, gets its assemble batch. */
static bool count_down(struct pen_store *store, const struct commit *commit, struct pen_status *st)
{
    int64_t batches, open;
    if (!store->driver->ops->view_batch_done(store->driver, commit->batch.job, commit->batch.view,
                                             &batches, &open, st))
        return false;
    if (open > 0)
        return true;
    return batches == 1 ? end_view(store, commit, st) : add_assemble_batch(store, commit, st);
}

/* Makes what a result of the first tiles lacks a batch of its own. */
static bool split(struct pen_store *store, struct commit *commit, struct pen_status *st)
{
    const struct pen_result *result = commit->result;
    bool changed;
    if (result->part_tiles == 0)
        return true;
    if (!store->driver->ops->batch_split(store->driver, commit->claim->batch,
                                         commit->claim->attempt, result->part_tiles, result->pixels,
                                         &changed, st))
        return false;
    if (!changed)
        return pen_fail(st, PEN_INTERNAL, "a result of %d tiles for a batch that has no more",
                        result->part_tiles);
    commit->batch.pixels = result->pixels;
    store->work = true;
    return true;
}

static bool write_result(struct pen_store *store, struct commit *commit, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    enum pen_batch_kind kind = commit->batch.kind;
    const int64_t handed_ns = commit->result->handed_ns;
    const struct pen_batch_end end = {.stats = commit->result->stats,
                                      .now_ms = commit->now_ms,
                                      .commit_us =
                                          handed_ns ? (pen_clock_ns() - handed_ns) / 1000 : 0};
    bool done;
    store->changed = true;
    /* Progress comes first: it gives the job the revision that batch_done stores with the batch. */
    if (!split(store, commit, st) || !pen_charge_time(store, commit->claim, st) ||
        !add_progress(driver, commit, st) ||
        !driver->ops->batch_done(driver, commit->claim->batch, commit->claim->attempt, &end, &done,
                                 st))
        return false;
    if (!done)
        return pen_fail(st, PEN_STALE, "the batch is no longer held; its result was refused");
    if ((kind == PEN_BATCH_RENDER && !add_pixels(store, commit, st)) ||
        (commit->result->artefact && !add_artefact(store, commit, st)))
        return false;
    return kind == PEN_BATCH_ASSEMBLE ? end_view(store, commit, st) : count_down(store, commit, st);
}

/* Checks that the result fits the kind and the size of the batch. Fails: PEN_INTERNAL. */
static bool check_result(const struct commit *commit, struct pen_status *st)
{
    const struct pen_result *result = commit->result;
    bool render = commit->batch.kind == PEN_BATCH_RENDER;
    bool any = commit->pixels.bytes > 0;
    bool part = render && result->part_tiles > 0 && !result->artefact;
    bool fits = part ? result->pixels < commit->batch.pixels
                     : result->part_tiles == 0 && result->pixels == commit->batch.pixels;
    if (render ? !any || !fits : any)
        return pen_fail(st, PEN_INTERNAL, "a result of %lld pixels for a batch of %lld",
                        (long long)result->pixels, (long long)commit->batch.pixels);
    return true;
}

static bool write_commit(struct pen_store *store, void *arg, struct pen_status *st)
{
    struct commit *commit = arg;
    const struct pen_batch_row *batch = &commit->batch;
    bool held;
    if (!pen_check_fence(store, commit->claim, &commit->batch, &held, st) ||
        !store->driver->ops->now(store->driver, &commit->now_ms, st))
        return false;
    commit->duplicate = batch->state == PEN_BATCH_DONE && batch->attempt == commit->claim->attempt;
    if (!commit->duplicate) {
        if (!held)
            return pen_fail(st, PEN_STALE, "the batch is no longer held; its result was refused");
        if (!check_result(commit, st) || !write_result(store, commit, st))
            return false;
    }
    return !commit->next || pen_take_next(store, commit->next, st);
}

/* Encodes the pixels, unless the caller has done so. */
static bool encode_result(struct pen_store *store, struct commit *commit, struct pen_status *st)
{
    const struct pen_result *result = commit->result;
    const struct pen_pixels *encoded = result->encoded;
    if (!encoded && !result->rgb)
        return true;
    if (!encoded) {
        if (!store->pixels && !(store->pixels = pen_pixels_new()))
            return pen_fail(st, PEN_NO_MEMORY, "no memory to encode pixels");
        pen_pixels_begin(store->pixels);
        if (!pen_pixels_add(store->pixels, result->rgb, result->pixels, st))
            return false;
        encoded = store->pixels;
    }
    if (pen_pixels_count(encoded) != result->pixels)
        return pen_fail(st, PEN_INTERNAL, "%lld encoded pixels in a result of %lld",
                        (long long)pen_pixels_count(encoded), (long long)result->pixels);
    const struct pen_bytes bytes = pen_pixels_encoded(encoded);
    commit->pixels = (struct pen_value){.data = bytes.data, .bytes = bytes.bytes};
    return true;
}

/* Stores what is too large for the transaction. That of a claim that does not hold is not stored:
 * the transaction tells whether it was committed before. */
static bool store_values(struct pen_store *store, struct commit *commit, struct pen_status *st)
{
    const struct pen_result *result = commit->result;
    const bool ok = pen_value_store(store, commit->claim, commit->pixels.data, commit->pixels.bytes,
                                    &commit->pixels, st) &&
                    pen_value_store(store, commit->claim, result->artefact, result->artefact_bytes,
                                    &commit->artefact, st);
    return ok || st->code == PEN_STALE;
}

bool pen_policy_commit(struct pen_store *store, const struct pen_claim *claim,
                       const struct pen_result *result, struct pen_next *next,
                       struct pen_status *st)
{
    struct commit commit = {.claim = claim, .result = result, .next = next};
    if (next)
        next->found = false;
    const bool ok = encode_result(store, &commit, st) && store_values(store, &commit, st) &&
                    pen_store_write(store, write_commit, &commit, st);
    if (!ok || commit.duplicate) {
        pen_value_drop(store, &commit.pixels);
        pen_value_drop(store, &commit.artefact);
    }
    if (ok)
        pen_store_tally_add(store,
                            commit.duplicate ? PEN_TALLY_COMMIT_DUPLICATE : PEN_TALLY_COMMIT_OK, 1);
    else if (st->code == PEN_STALE)
        pen_store_tally_add(store, PEN_TALLY_COMMIT_STALE, 1);
    if (ok && !commit.duplicate)
        pen_timing_add(store, PEN_TIMING_BATCH, claim->spent_us);
    return ok;
}
