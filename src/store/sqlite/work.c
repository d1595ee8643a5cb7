/* SPDX-License-Identifier: MIT */
/* Leases: claim, heartbeat, release, fail. A lease is (batch, attempt); the attempt grows
 * with every claim, and everything a holder does names both. Time is the wall clock of the host
 * that holds the database file. */
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "store/sqlite/sqlite.h"

void pen_sqlite_read_claim(const struct pen_sqlite_query *row, struct pen_claim *claim,
                           int64_t *job)
{
    *claim = (struct pen_claim){
        .batch = pen_sqlite_column_int(row, 0),
        .attempt = pen_sqlite_column_int(row, 1),
        .kind = (enum pen_batch_kind)pen_sqlite_column_int(row, 2),
        .view = (int)pen_sqlite_column_int(row, 4),
        .first_tile = (int)pen_sqlite_column_int(row, 5),
        .tile_count = (int)pen_sqlite_column_int(row, 6),
        .pixels = pen_sqlite_column_int(row, 7),
        .view_batches = (int)pen_sqlite_column_int(row, 8),
        .submitted_ms = pen_sqlite_column_int(row, 10),
        .started_ms = pen_sqlite_column_int(row, 11),
        .timeout_ms = pen_sqlite_column_int(row, 12),
    };
    *job = pen_sqlite_column_int(row, 3);
    const char *id = pen_sqlite_column_text(row, 9);
    snprintf(claim->job_id, sizeof claim->job_id, "%s", id ? id : "");
    struct pen_bytes hash = pen_sqlite_column_blob(row, 13);
    if (hash.bytes == sizeof claim->scene_sha256)
        memcpy(claim->scene_sha256, hash.data, hash.bytes);
}

static bool lease_batch(struct pen_sqlite_store *store, const struct pen_claim *claim,
                        const char *worker, int64_t lease_ms, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_BATCH_LEASE);
    pen_sqlite_int(&query, claim->batch);
    pen_sqlite_int(&query, claim->attempt);
    pen_sqlite_text(&query, worker);
    pen_sqlite_int(&query, claim->claimed_ms + lease_ms);
    return pen_sqlite_run(&query, st);
}

static bool start_job(struct pen_sqlite_store *store, int64_t number, int64_t now_ms,
                      struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_JOB_START);
    pen_sqlite_int(&query, number);
    pen_sqlite_int(&query, now_ms);
    if (!pen_sqlite_run(&query, st))
        return false;
    if (pen_sqlite_changes(store))
        store->base.changed = true;
    return true;
}

/* Whether the worker may be given anything, and what is worked on alone too: it holds nothing. */
static bool may_take(struct pen_sqlite_store *store, const char *worker, bool *any, bool *alone,
                     struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_HELD_BY);
    bool row;
    pen_sqlite_text(&query, worker);
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    *alone = !row || pen_sqlite_column_int(&query, 0) == 0;
    *any = *alone || pen_sqlite_column_int(&query, 1) == 0;
    pen_sqlite_end(&query);
    return true;
}

/* The open batch whose turn it is, of the jobs that rest no longer than until `rested_ms`. A
 * suspect is passed over by a worker that holds something. */
static bool find_open(struct pen_sqlite_store *store, int64_t rested_ms, bool alone,
                      struct pen_next *next, int64_t *job, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_OPEN_NEXT);
    pen_sqlite_int(&query, rested_ms);
    pen_sqlite_int(&query, alone);
    if (!pen_sqlite_next(&query, &next->found, st))
        return false;
    if (!next->found)
        return true;
    pen_sqlite_read_claim(&query, &next->claim, job);
    pen_sqlite_end(&query);
    return true;
}

bool pen_sqlite_take_next(struct pen_sqlite_store *store, struct pen_next *next,
                          struct pen_status *st)
{
    int64_t now_ms = pen_clock_wall_ms(), job = 0;
    bool any, alone;
    next->found = false;
    if (!may_take(store, next->worker, &any, &alone, st))
        return false;
    if (any && !find_open(store, now_ms, alone, next, &job, st))
        return false;
    /* Jobs that rest let others go first; when there are none, they may go on. */
    if (any && !next->found && !find_open(store, INT64_MAX, alone, next, &job, st))
        return false;
    /* A study is not passed over: the worker becomes idle for it. */
    if (next->found && next->claim.kind == PEN_BATCH_STUDY && !alone)
        next->found = false;
    if (!next->found)
        return true;
    struct pen_claim *claim = &next->claim;
    claim->attempt++;
    claim->claimed_ms = now_ms;
    if (claim->started_ms == 0)
        claim->started_ms = now_ms;
    return lease_batch(store, claim, next->worker, next->lease_ms, st) &&
           start_job(store, job, now_ms, st);
}

static bool write_claim(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    return pen_sqlite_take_next(store, arg, st);
}

bool pen_sqlite_any_row(struct pen_sqlite_query *query, bool *any, struct pen_status *st)
{
    if (!pen_sqlite_next(query, any, st))
        return false;
    pen_sqlite_end(query);
    return true;
}

bool pen_sqlite_claim(struct pen_store *base, const char *worker, int64_t lease_ms,
                      struct pen_claim *claim, bool *found, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(base);
    struct pen_sqlite_query open = pen_sqlite_query(store, SQL_OPEN_ANY);
    if (!pen_sqlite_any_row(&open, found, st))
        return false;
    if (!*found)
        return true;
    struct pen_next next = {.worker = worker, .lease_ms = lease_ms};
    if (!pen_sqlite_transaction(store, write_claim, &next, st))
        return false;
    *found = next.found;
    if (next.found)
        *claim = next.claim;
    return true;
}

bool pen_sqlite_standing(struct pen_sqlite_store *store, const struct pen_claim *claim,
                         struct pen_sqlite_standing *standing, struct pen_status *st)
{
    *standing = (struct pen_sqlite_standing){0};
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_BATCH_GET);
    pen_sqlite_int(&query, claim->batch);
    if (!pen_sqlite_next(&query, &standing->exists, st))
        return false;
    if (!standing->exists)
        return true;
    standing->job = pen_sqlite_column_int(&query, 0);
    standing->view = (int)pen_sqlite_column_int(&query, 1);
    standing->kind = (enum pen_batch_kind)pen_sqlite_column_int(&query, 2);
    standing->state = (enum pen_batch_state)pen_sqlite_column_int(&query, 3);
    standing->attempt = pen_sqlite_column_int(&query, 4);
    standing->pixels = pen_sqlite_column_int(&query, 5);
    standing->lease_until_ms = pen_sqlite_column_int(&query, 6);
    standing->held = standing->state == PEN_BATCH_LEASED && standing->attempt == claim->attempt;
    pen_sqlite_end(&query);
    return true;
}

struct progress {
    const struct pen_claim *claim;
    int64_t done;
};

static bool write_progress(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const struct progress *progress = arg;
    struct pen_sqlite_standing standing;
    if (!pen_sqlite_standing(store, progress->claim, &standing, st))
        return false;
    if (!standing.held)
        return pen_fail(st, PEN_STALE, "the batch is no longer held; its progress was refused");
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_STUDY_PROGRESS);
    pen_sqlite_int(&query, standing.job);
    pen_sqlite_int(&query, progress->done);
    pen_sqlite_int(&query, pen_clock_wall_ms());
    store->base.changed = true;
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_progress(struct pen_store *base, const struct pen_claim *claim, int64_t done,
                         struct pen_status *st)
{
    struct progress progress = {claim, done};
    return pen_sqlite_transaction(pen_sqlite_of(base), write_progress, &progress, st);
}

static bool open_batch(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const struct pen_claim *claim = arg;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_BATCH_OPEN);
    pen_sqlite_int(&query, claim->batch);
    pen_sqlite_int(&query, claim->attempt);
    if (!pen_sqlite_run(&query, st))
        return false;
    store->base.work = pen_sqlite_changes(store) > 0;
    return true;
}

bool pen_sqlite_release(struct pen_store *base, const struct pen_claim *claim,
                        struct pen_status *st)
{
    return pen_sqlite_transaction(pen_sqlite_of(base), open_batch, (void *)(uintptr_t)claim, st);
}

struct failure {
    const struct pen_claim *claim;
    const char *error;
};

static bool write_failure(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const struct failure *failure = arg;
    struct pen_sqlite_standing standing;
    if (!pen_sqlite_standing(store, failure->claim, &standing, st))
        return false;
    if (!standing.held)
        return pen_fail(st, PEN_STALE, "the batch is no longer held; its job was left as it is");
    return pen_sqlite_end_job(store, standing.job, PEN_JOB_FAILED, failure->error, st);
}

bool pen_sqlite_fail(struct pen_store *base, const struct pen_claim *claim, const char *error,
                     struct pen_status *st)
{
    struct failure failure = {claim, error};
    return pen_sqlite_transaction(pen_sqlite_of(base), write_failure, &failure, st);
}

struct beat {
    const struct pen_claim *claim;
    int64_t lease_until_ms;
    bool held;
};

static bool extend_lease(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    struct beat *beat = arg;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_LEASE_EXTEND);
    pen_sqlite_int(&query, beat->claim->batch);
    pen_sqlite_int(&query, beat->claim->attempt);
    pen_sqlite_int(&query, beat->lease_until_ms);
    if (!pen_sqlite_run(&query, st))
        return false;
    beat->held = pen_sqlite_changes(store) > 0;
    return true;
}

bool pen_sqlite_heartbeat(struct pen_store *base, const struct pen_claim *claim, int64_t lease_ms,
                          bool *held, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(base);
    struct pen_sqlite_standing standing;
    if (!pen_sqlite_standing(store, claim, &standing, st))
        return false;
    int64_t now_ms = pen_clock_wall_ms();
    *held = standing.held;
    if (!standing.held || standing.lease_until_ms - now_ms >= lease_ms - lease_ms / 3)
        return true;
    struct beat beat = {.claim = claim, .lease_until_ms = now_ms + lease_ms};
    if (!pen_sqlite_transaction(store, extend_lease, &beat, st))
        return false;
    *held = beat.held;
    return true;
}
