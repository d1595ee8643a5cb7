/* SPDX-License-Identifier: MIT */
/* The commit of a batch. It is fenced by the attempt and may be repeated. Pixels, picture,
 * statistics and state become visible in one transaction, which may also claim the worker's next
 * batch. */
#include <string.h>

#include "base/clock.h"
#include "store/internal/counters.h"
#include "store/internal/objects.h"

struct commit {
    const struct pen_claim *claim;
    const struct pen_result *result;
    struct pen_next *next;
    struct pen_bytes pixels;
    struct pen_object stored_pixels, artefact;
    struct pen_batch batch;
};

static bool encode(struct pen_store *store, struct commit *commit, struct pen_status *st)
{
    const struct pen_result *result = commit->result;
    if (!result->rgb)
        return true;
    if (!store->pixels && !(store->pixels = pen_pixels_new()))
        return pen_fail(st, PEN_NO_MEMORY, "no memory to encode pixels");
    return pen_pixels_encode(store->pixels, result->rgb, result->pixels, &commit->pixels, st);
}

/* Writes values that are too large for the transaction. Values of a stale claim are not written;
 * the transaction then finds out whether the claim was committed before. */
static bool load(struct pen_store *store, struct commit *commit, struct pen_status *st)
{
    const struct pen_claim *claim = commit->claim;
    const struct pen_result *result = commit->result;
    commit->stored_pixels = (struct pen_object){.view = claim->view,
                                                .batch = claim->batch,
                                                .attempt = claim->attempt,
                                                .layer = "",
                                                .format = "pixels",
                                                .data = commit->pixels.data,
                                                .bytes = commit->pixels.bytes};
    commit->artefact = (struct pen_object){.view = claim->view,
                                           .batch = claim->batch,
                                           .attempt = claim->attempt,
                                           .layer = result->layer,
                                           .format = result->format,
                                           .data = result->artefact,
                                           .bytes = result->artefact_bytes};
    return (pen_object_load(store, &commit->stored_pixels, claim, st) &&
            pen_object_load(store, &commit->artefact, claim, st)) ||
           st->code == PEN_STALE;
}

/* Fails (PEN_INTERNAL) unless the result fits the kind and the size of the batch. */
static bool check_result(const struct commit *commit, struct pen_status *st)
{
    const struct pen_result *result = commit->result;
    const bool render = commit->batch.kind == PEN_BATCH_RENDER;
    const bool any = commit->pixels.bytes > 0;
    const bool part = render && result->part_tiles > 0 && !result->artefact;
    const bool fits = part ? result->pixels < commit->batch.pixels &&
                                 result->part_tiles < commit->batch.tile_count
                           : result->part_tiles == 0 && result->pixels == commit->batch.pixels;
    return (render ? any && fits : !any) ||
           pen_fail(st, PEN_INTERNAL, "a result of %lld pixels for a batch of %lld",
                    (long long)result->pixels, (long long)commit->batch.pixels);
}

#define NEW_BATCH                                                                                  \
    "INSERT INTO batch (job, view, kind, first_tile, tile_count, pixels, told_pixels, work, "      \
    "state, priority, client, turn, not_before_ms, alone, attempt, serial, claimed_ms, lease_ms, " \
    "spent_us, revision, commit_us) SELECT job, view, "
#define OF_BATCH                                                                                   \
    ", 0, 0, 0, priority, client, turn, 0, 0, 0, 0, 0, 0, 0, 0, 0 FROM batch WHERE number = $1"

/* Makes a new batch of the tiles that the result lacks, with the same turn. */
static bool split(struct pen_store *store, struct commit *commit, struct pen_status *st)
{
    const int64_t tiles = commit->result->part_tiles, pixels = commit->result->pixels;
    if (tiles == 0)
        return true;
    commit->batch.pixels = pixels;
    return pen_db_run(store->db, st, NULL,
                      NEW_BATCH "kind, first_tile + $2, tile_count - $2, pixels - $3" OF_BATCH,
                      "iii", commit->claim->batch, tiles, pixels) &&
           pen_db_run(store->db, st, NULL,
                      "UPDATE batch SET tile_count = $2, pixels = $3 WHERE number = $1", "iii",
                      commit->claim->batch, tiles, pixels) &&
           pen_db_run(store->db, st, NULL,
                      "UPDATE view SET batches = batches + 1, open_batches = open_batches + 1 "
                      "WHERE job = $1 AND view = $2",
                      "ii", commit->batch.job, commit->batch.view);
}

static bool tell(struct pen_store *store, const struct commit *commit, struct pen_status *st)
{
    const int64_t work = commit->result->work;
    return pen_claim_tell(store, &commit->batch,
                          commit->batch.kind == PEN_BATCH_ASSEMBLE ? 0 : commit->batch.pixels,
                          work > 0 ? work : -1, commit->claim->estimate_ms, st);
}

/* A commit ends the charges, losses and waits of its job. */
static bool forgive(struct pen_store *store, const struct pen_batch *batch, struct pen_status *st)
{
    return batch->troubles == 0 ||
           (pen_db_run(store->db, st, NULL,
                       "UPDATE job SET charges = 0, losses = 0 WHERE number = $1", "i",
                       batch->job) &&
            pen_db_run(store->db, st, NULL,
                       "UPDATE batch SET not_before_ms = 0 WHERE job = $1 AND state = 0 "
                       "AND not_before_ms > 0",
                       "i", batch->job));
}

static bool set_done(struct pen_store *store, const struct commit *commit, struct pen_status *st)
{
    const int64_t handed_ns = commit->result->handed_ns;
    return pen_db_run(
        store->db, st, NULL,
        "UPDATE batch SET state = 2, worker = NULL, alone = 0, stats = $2, commit_us = $3, "
        "revision = (SELECT job.revision FROM job WHERE job.number = batch.job) "
        "WHERE number = $1",
        "iti", commit->claim->batch, commit->result->stats,
        handed_ns ? (pen_clock_ns() - handed_ns) / 1000 : 0);
}

static bool use_values(struct pen_store *store, struct commit *commit, struct pen_status *st)
{
    commit->stored_pixels.job = commit->artefact.job = commit->batch.job;
    return pen_object_use(store, &commit->stored_pixels, st) &&
           pen_object_use(store, &commit->artefact, st);
}

static bool end_view(struct pen_store *store, const struct commit *commit, struct pen_status *st)
{
    int64_t open;
    if (!commit->result->artefact)
        return pen_fail(st, PEN_INTERNAL,
                        "the batch that ends a view was committed without its picture or report");
    return pen_kept_drop(store, commit->batch.job, commit->batch.view, st) &&
           pen_db_value(store->db, st, &open,
                        "UPDATE job SET open_views = open_views - 1 WHERE number = $1 "
                        "RETURNING open_views",
                        "i", commit->batch.job) &&
           (open > 0 || pen_job_end(store, commit->batch.job, PEN_JOB_SUCCEEDED, NULL, st));
}

/* Counts the batch off its view. After the last of several render batches comes the assemble
 * batch. */
static bool count_off(struct pen_store *store, const struct commit *commit, struct pen_status *st)
{
    int64_t batches, open;
    if (!pen_row_numbers(pen_db_rows(store->db, st,
                                     "UPDATE view SET open_batches = open_batches - 1 "
                                     "WHERE job = $1 AND view = $2 RETURNING batches, open_batches",
                                     "ii", commit->batch.job, commit->batch.view),
                         &batches, &open, NULL))
        return false;
    if (open > 0)
        return true;
    if (batches <= 1 || commit->batch.kind == PEN_BATCH_ASSEMBLE)
        return end_view(store, commit, st);
    return pen_db_run(store->db, st, NULL, NEW_BATCH "1, 0, 0, 0" OF_BATCH, "i",
                      commit->claim->batch) &&
           pen_db_run(store->db, st, NULL,
                      "UPDATE view SET open_batches = 1 WHERE job = $1 AND view = $2", "ii",
                      commit->batch.job, commit->batch.view);
}

/* `tell` raises the job's revision, and set_done stores it with the batch. */
static bool write_commit(struct pen_store *store, struct commit *commit, bool *duplicate,
                         struct pen_status *st)
{
    if (!pen_claim_lock(store, commit->claim, &commit->batch, st))
        return false;
    *duplicate = commit->batch.done;
    if (!*duplicate && !commit->batch.held)
        return pen_fail(st, PEN_STALE, "the batch is no longer held; its result was refused");
    return (*duplicate ||
            (check_result(commit, st) && split(store, commit, st) && tell(store, commit, st) &&
             forgive(store, &commit->batch, st) && set_done(store, commit, st) &&
             use_values(store, commit, st) && count_off(store, commit, st))) &&
           (!commit->next || pen_claim_next(store, commit->next, st));
}

bool pen_store_commit(struct pen_store *store, const struct pen_claim *claim,
                      const struct pen_result *result, struct pen_next *next, struct pen_status *st)
{
    struct commit commit = {.claim = claim, .result = result, .next = next};
    bool duplicate = false;
    const bool ok = encode(store, &commit, st) && load(store, &commit, st) &&
                    pen_db_begin(store->db, PEN_DB_WRITE, st) &&
                    pen_write_end(store, write_commit(store, &commit, &duplicate, st), st);
    if (!ok) {
        if (next)
            next->found = false;
        if (st->code == PEN_STALE)
            pen_store_count(PEN_COUNT_COMMIT_STALE, 1);
        return false;
    }
    pen_store_count(duplicate ? PEN_COUNT_COMMIT_DUPLICATE : PEN_COUNT_COMMIT_OK, 1);
    if (!duplicate)
        pen_timing_add(PEN_TIMING_BATCH, claim->spent_us);
    return true;
}
