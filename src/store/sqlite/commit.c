/* SPDX-License-Identifier: MIT */
/* The commit of a batch, rules R1 to R3 of the farm notes: fenced by the attempt, pixels and state
 * in one transaction, idempotent, and pictures made from committed pixels alone. */
#include "base/clock.h"
#include "store/sqlite/sqlite.h"

struct commit {
    const struct pen_claim *claim;
    const struct pen_result *result;
    struct pen_bytes pixels;
    struct pen_next *next; /* NULL: none wanted */
    struct pen_sqlite_standing standing;
};

static bool finish_batch(struct pen_sqlite_store *store, const struct commit *commit,
                         int64_t now_ms, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_BATCH_DONE);
    pen_sqlite_int(&query, commit->claim->batch);
    pen_sqlite_int(&query, commit->claim->attempt);
    pen_sqlite_text(&query, commit->result->stats);
    pen_sqlite_int(&query, now_ms);
    return pen_sqlite_run(&query, st);
}

static bool add_pixels(struct pen_sqlite_store *store, const struct commit *commit,
                       struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_PIXELS_ADD);
    pen_sqlite_int(&query, commit->claim->batch);
    pen_sqlite_blob(&query, commit->pixels.data, commit->pixels.bytes);
    return pen_sqlite_run(&query, st);
}

static bool add_artefact(struct pen_sqlite_store *store, const struct commit *commit,
                         struct pen_status *st)
{
    const struct pen_result *result = commit->result;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_ARTEFACT_PUT);
    pen_sqlite_int(&query, commit->standing.job);
    pen_sqlite_int(&query, commit->standing.view);
    pen_sqlite_text(&query, result->layer);
    pen_sqlite_text(&query, result->format);
    pen_sqlite_blob(&query, result->artefact, result->artefact_bytes);
    pen_sqlite_int(&query, pen_checksum(result->artefact, result->artefact_bytes));
    return pen_sqlite_run(&query, st);
}

static bool add_progress(struct pen_sqlite_store *store, const struct commit *commit,
                         int64_t now_ms, struct pen_status *st)
{
    const struct pen_sqlite_standing *standing = &commit->standing;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_JOB_PROGRESS);
    pen_sqlite_int(&query, standing->job);
    pen_sqlite_int(&query, standing->kind == PEN_BATCH_ASSEMBLE ? 0 : standing->pixels);
    pen_sqlite_int(&query, now_ms);
    pen_sqlite_int(&query, standing->kind == PEN_BATCH_STUDY); /* has been counting by itself */
    return pen_sqlite_run(&query, st);
}

static bool add_assemble_batch(struct pen_sqlite_store *store, const struct commit *commit,
                               struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_BATCH_ADD);
    pen_sqlite_int(&query, commit->standing.job);
    pen_sqlite_int(&query, commit->standing.view);
    pen_sqlite_int(&query, PEN_BATCH_ASSEMBLE);
    pen_sqlite_int(&query, 0);
    pen_sqlite_int(&query, 0);
    pen_sqlite_int(&query, 0);
    store->base.work = true;
    return pen_sqlite_run(&query, st);
}

static bool end_view(struct pen_sqlite_store *store, const struct commit *commit, int64_t now_ms,
                     struct pen_status *st)
{
    if (!commit->result->artefact)
        return pen_fail(st, PEN_INTERNAL,
                        "the batch that ends a view was committed without what it was to make");
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_JOB_VIEW_ENDED);
    pen_sqlite_int(&query, commit->standing.job);
    pen_sqlite_int(&query, now_ms);
    return pen_sqlite_run(&query, st);
}

/* Counts a batch off its view; the last of several calls for an assemble batch. */
static bool count_down(struct pen_sqlite_store *store, const struct commit *commit, int64_t now_ms,
                       struct pen_status *st)
{
    struct pen_sqlite_query down = pen_sqlite_query(store, SQL_VIEW_COUNT_DOWN);
    pen_sqlite_int(&down, commit->standing.job);
    pen_sqlite_int(&down, commit->standing.view);
    struct pen_sqlite_query view = pen_sqlite_query(store, SQL_VIEW_GET);
    pen_sqlite_int(&view, commit->standing.job);
    pen_sqlite_int(&view, commit->standing.view);
    bool row;
    if (!pen_sqlite_run(&down, st) || !pen_sqlite_next(&view, &row, st))
        return false;
    if (!row)
        return pen_fail(st, PEN_STORAGE, "a batch without a view");
    int64_t batches = pen_sqlite_column_int(&view, 0), open = pen_sqlite_column_int(&view, 1);
    pen_sqlite_end(&view);
    if (open > 0)
        return true;
    return batches == 1 ? end_view(store, commit, now_ms, st)
                        : add_assemble_batch(store, commit, st);
}

static bool write_result(struct pen_sqlite_store *store, const struct commit *commit,
                         struct pen_status *st)
{
    int64_t now_ms = pen_clock_wall_ms();
    bool render = commit->standing.kind == PEN_BATCH_RENDER;
    store->base.changed = true;
    /* Progress first: the batch takes note of the revision that it gives the job. */
    if (!add_progress(store, commit, now_ms, st) || !finish_batch(store, commit, now_ms, st) ||
        (render && !add_pixels(store, commit, st)) ||
        (commit->result->artefact && !add_artefact(store, commit, st)))
        return false;
    if (commit->standing.kind == PEN_BATCH_ASSEMBLE)
        return end_view(store, commit, now_ms, st);
    return count_down(store, commit, now_ms, st);
}

/* Whether the result is one for this batch; a claim names both, so this is about the caller. */
static bool check_result(const struct commit *commit, struct pen_status *st)
{
    const struct pen_result *result = commit->result;
    bool render = commit->standing.kind == PEN_BATCH_RENDER;
    bool any = commit->pixels.bytes > 0;
    if (render ? !any || result->pixels != commit->standing.pixels : any)
        return pen_fail(st, PEN_INTERNAL, "a result of %lld pixels for a batch of %lld",
                        (long long)result->pixels, (long long)commit->standing.pixels);
    return true;
}

static bool write_commit(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    struct commit *commit = arg;
    if (!pen_sqlite_standing(store, commit->claim, &commit->standing, st))
        return false;
    const struct pen_sqlite_standing *standing = &commit->standing;
    bool duplicate = standing->exists && standing->state == PEN_BATCH_DONE &&
                     standing->attempt == commit->claim->attempt;
    if (!duplicate) {
        if (!standing->held)
            return pen_fail(st, PEN_STALE, "the batch is no longer held; its result was refused");
        if (!check_result(commit, st) || !write_result(store, commit, st))
            return false;
    }
    return !commit->next || pen_sqlite_take_next(store, commit->next, st);
}

/* Packs the pixels, unless they come packed. */
static bool pack_result(struct pen_sqlite_store *store, struct commit *commit,
                        struct pen_status *st)
{
    const struct pen_result *result = commit->result;
    const struct pen_pixels *packed = result->encoded;
    if (!packed && !result->rgb)
        return true;
    if (!packed) {
        if (!store->pixels && !(store->pixels = pen_pixels_new()))
            return pen_fail(st, PEN_NO_MEMORY, "no memory to pack pixels");
        pen_pixels_begin(store->pixels);
        if (!pen_pixels_add(store->pixels, result->rgb, result->pixels, st))
            return false;
        packed = store->pixels;
    }
    if (pen_pixels_count(packed) != result->pixels)
        return pen_fail(st, PEN_INTERNAL, "%lld packed pixels in a result of %lld",
                        (long long)pen_pixels_count(packed), (long long)result->pixels);
    commit->pixels = pen_pixels_encoded(packed);
    return true;
}

bool pen_sqlite_commit(struct pen_store *base, const struct pen_claim *claim,
                       const struct pen_result *result, struct pen_next *next,
                       struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(base);
    struct commit commit = {.claim = claim, .result = result, .next = next};
    if (next)
        next->found = false;
    if (!pack_result(store, &commit, st))
        return false;
    return pen_sqlite_transaction(store, write_commit, &commit, st);
}
