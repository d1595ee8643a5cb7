/* SPDX-License-Identifier: MIT */
/* Rows of batches and their leases. */
#include <stdio.h>
#include <string.h>

#include "store/sqlite/sqlite.h"

bool pen_sqlite_batch_add(struct pen_driver *driver, const struct pen_batch_add *add, bool *added,
                          struct pen_status *st)
{
    const struct pen_batch_new *batch = &add->batch;
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_BATCH_ADD);
    pen_sqlite_int(&query, add->job);
    pen_sqlite_int(&query, batch->view);
    pen_sqlite_int(&query, batch->kind);
    pen_sqlite_int(&query, batch->first_tile);
    pen_sqlite_int(&query, batch->tile_count);
    pen_sqlite_int(&query, batch->pixels);
    return pen_sqlite_run_changed(&query, added, st);
}

bool pen_sqlite_any_open(struct pen_driver *driver, bool *any, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_ANY_OPEN);
    if (!pen_sqlite_next(&query, any, st))
        return false;
    pen_sqlite_end(&query);
    return true;
}

/* Whether a statement about a batch, and the time until which jobs may be paused, has a row. */
static bool any_open_to(struct pen_sqlite_store *store, enum pen_sqlite_sql sql, int64_t batch,
                        int64_t now_ms, bool *any, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, sql);
    pen_sqlite_int(&query, now_ms);
    pen_sqlite_int(&query, batch);
    if (!pen_sqlite_next(&query, any, st))
        return false;
    if (*any)
        pen_sqlite_end(&query);
    return true;
}

bool pen_sqlite_open_above(struct pen_driver *driver, int64_t batch, int64_t now_ms, bool aged,
                           bool equal, bool *any, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    if (!any_open_to(store, SQL_OPEN_ABOVE, batch, now_ms, any, st) ||
        (aged && !*any && !any_open_to(store, SQL_OPEN_AGED, batch, now_ms, any, st)))
        return false;
    return *any || !equal || any_open_to(store, SQL_OPEN_BESIDE, batch, now_ms, any, st);
}

bool pen_sqlite_open_elsewhere(struct pen_driver *driver, int64_t batch, int64_t paused_until_ms,
                               bool *any, struct pen_status *st)
{
    return any_open_to(pen_sqlite_of(driver), SQL_OPEN_ELSEWHERE, batch, paused_until_ms, any, st);
}

#define COLUMN(name, value) CLAIM_##name,
enum { PEN_SQLITE_CLAIM_COLUMNS(COLUMN, COLUMN) };

/* Reads a row of the claim columns as a claim of the batch's present attempt; *job: its job's
 * number. */
static void read_claim(const struct pen_sqlite_query *row, struct pen_claim *claim, int64_t *job)
{
    *claim = (struct pen_claim){
        .batch = pen_sqlite_column_int(row, CLAIM_batch),
        .attempt = pen_sqlite_column_int(row, CLAIM_attempt),
        .kind = (enum pen_batch_kind)pen_sqlite_column_int(row, CLAIM_kind),
        .view = (int)pen_sqlite_column_int(row, CLAIM_view),
        .first_tile = (int)pen_sqlite_column_int(row, CLAIM_first_tile),
        .tile_count = (int)pen_sqlite_column_int(row, CLAIM_tile_count),
        .pixels = pen_sqlite_column_int(row, CLAIM_pixels),
        .view_batches = (int)pen_sqlite_column_int(row, CLAIM_view_batches),
        .submitted_ms = pen_sqlite_column_int(row, CLAIM_submitted_ms),
        .started_ms = pen_sqlite_column_int(row, CLAIM_started_ms),
        .timeout_ms = pen_sqlite_column_int(row, CLAIM_timeout_ms),
        .job_spent_us = pen_sqlite_column_int(row, CLAIM_job_spent_us),
        .job_work = pen_sqlite_column_int(row, CLAIM_job_work),
    };
    *job = pen_sqlite_column_int(row, CLAIM_job);
    const char *id = pen_sqlite_column_text(row, CLAIM_job_id);
    snprintf(claim->job_id, sizeof claim->job_id, "%s", id ? id : "");
    struct pen_bytes hash = pen_sqlite_column_blob(row, CLAIM_scene_sha256);
    if (hash.bytes == sizeof claim->scene_sha256)
        memcpy(claim->scene_sha256, hash.data, hash.bytes);
}

static bool first_claim(struct pen_sqlite_query *query, struct pen_claim *claim, int64_t *job,
                        bool *found, struct pen_status *st)
{
    if (!pen_sqlite_next(query, found, st))
        return false;
    if (*found) {
        read_claim(query, claim, job);
        pen_sqlite_end(query);
    }
    return true;
}

bool pen_sqlite_first_open(struct pen_driver *driver, int64_t job, bool quarantined,
                           struct pen_claim *claim, int64_t *number, bool *found,
                           struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_FIRST_OPEN);
    pen_sqlite_int(&query, job);
    pen_sqlite_int(&query, quarantined);
    return first_claim(&query, claim, number, found, st);
}

bool pen_sqlite_first_held(struct pen_driver *driver, const char *worker, struct pen_claim *claim,
                           int64_t *job, bool *found, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_FIRST_HELD);
    pen_sqlite_text(&query, worker);
    return first_claim(&query, claim, job, found, st);
}

bool pen_sqlite_held_by(struct pen_driver *driver, const char *worker, int *count, int *alone,
                        struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_HELD_BY);
    bool row;
    *count = *alone = 0;
    pen_sqlite_text(&query, worker);
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (row) {
        *count = (int)pen_sqlite_column_int(&query, 0);
        *alone = (int)pen_sqlite_column_int(&query, 1);
        pen_sqlite_end(&query);
    }
    return true;
}

bool pen_sqlite_batch_get(struct pen_driver *driver, int64_t batch, struct pen_batch_row *row,
                          bool *found, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_BATCH_GET);
    pen_sqlite_int(&query, batch);
    if (!pen_sqlite_next(&query, found, st))
        return false;
    if (!*found)
        return true;
    *row = (struct pen_batch_row){
        .job = pen_sqlite_column_int(&query, 0),
        .view = (int)pen_sqlite_column_int(&query, 1),
        .kind = (enum pen_batch_kind)pen_sqlite_column_int(&query, 2),
        .state = (enum pen_batch_state)pen_sqlite_column_int(&query, 3),
        .attempt = pen_sqlite_column_int(&query, 4),
        .pixels = pen_sqlite_column_int(&query, 5),
        .lease_until_ms = pen_sqlite_column_int(&query, 6),
        .spent_us = pen_sqlite_column_int(&query, 7),
        .job_spent_us = pen_sqlite_column_int(&query, 8),
        .job_deaths = pen_sqlite_column_int(&query, 9),
        .job_started_ms = pen_sqlite_column_int(&query, 10),
        .work = pen_sqlite_column_int(&query, 11),
        .job_work = pen_sqlite_column_int(&query, 12),
        .job_pixels = pen_sqlite_column_int(&query, 13),
    };
    pen_sqlite_end(&query);
    return true;
}

bool pen_sqlite_batch_lease(struct pen_driver *driver, int64_t batch, int64_t attempt,
                            const char *worker, int64_t until_ms, bool *changed,
                            struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_BATCH_LEASE);
    pen_sqlite_int(&query, batch);
    pen_sqlite_int(&query, attempt);
    pen_sqlite_text(&query, worker);
    pen_sqlite_int(&query, until_ms);
    return pen_sqlite_run_changed(&query, changed, st);
}

bool pen_sqlite_batch_open(struct pen_driver *driver, int64_t batch, int64_t attempt, bool *changed,
                           struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_BATCH_OPEN);
    pen_sqlite_int(&query, batch);
    pen_sqlite_int(&query, attempt);
    return pen_sqlite_run_changed(&query, changed, st);
}

bool pen_sqlite_batch_split(struct pen_driver *driver, int64_t batch, int64_t attempt,
                            int tile_count, int64_t pixels, bool *changed, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    const enum pen_sqlite_sql statements[] = {SQL_BATCH_REST, SQL_BATCH_CUT};
    *changed = true;
    for (int i = 0; i < 2 && *changed; i++) {
        struct pen_sqlite_query query = pen_sqlite_query(store, statements[i]);
        pen_sqlite_int(&query, batch);
        pen_sqlite_int(&query, attempt);
        pen_sqlite_int(&query, tile_count);
        pen_sqlite_int(&query, pixels);
        if (!pen_sqlite_run_changed(&query, changed, st))
            return false;
    }
    return !*changed || pen_sqlite_run_with(store, SQL_VIEW_SPLIT, batch, st);
}

bool pen_sqlite_batch_done(struct pen_driver *driver, int64_t batch, int64_t attempt,
                           const struct pen_batch_end *end, bool *changed, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_BATCH_DONE);
    pen_sqlite_int(&query, batch);
    pen_sqlite_int(&query, attempt);
    pen_sqlite_text(&query, end->stats);
    pen_sqlite_int(&query, end->now_ms);
    pen_sqlite_int(&query, end->commit_us);
    return pen_sqlite_run_changed(&query, changed, st);
}

bool pen_sqlite_batch_extend(struct pen_driver *driver, int64_t batch, int64_t attempt,
                             int64_t until_ms, bool *changed, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_BATCH_EXTEND);
    pen_sqlite_int(&query, batch);
    pen_sqlite_int(&query, attempt);
    pen_sqlite_int(&query, until_ms);
    return pen_sqlite_run_changed(&query, changed, st);
}

bool pen_sqlite_view_batch_done(struct pen_driver *driver, int64_t job, int view, int64_t *batches,
                                int64_t *open, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_VIEW_BATCH_DONE);
    bool row;
    pen_sqlite_int(&query, job);
    pen_sqlite_int(&query, view);
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (!row)
        return pen_fail(st, PEN_STORAGE, "a batch without a view");
    *batches = pen_sqlite_column_int(&query, 0);
    *open = pen_sqlite_column_int(&query, 1);
    return pen_sqlite_run(&query, st);
}

static struct pen_sqlite_query lost_query(struct pen_driver *driver, enum pen_sqlite_sql sql,
                                          const struct pen_lost *lost)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), sql);
    pen_sqlite_int(&query, lost->before_ms);
    pen_sqlite_text(&query, lost->worker);
    return query;
}

bool pen_sqlite_any_lost(struct pen_driver *driver, const struct pen_lost *lost, bool *any,
                         struct pen_status *st)
{
    struct pen_sqlite_query query = lost_query(driver, SQL_ANY_LOST, lost);
    if (!pen_sqlite_next(&query, any, st))
        return false;
    pen_sqlite_end(&query);
    return true;
}

bool pen_sqlite_lost_jobs(struct pen_driver *driver, const struct pen_lost *lost, int64_t after,
                          struct pen_lost_job *jobs, int capacity, int *count,
                          struct pen_status *st)
{
    struct pen_sqlite_query query = lost_query(driver, SQL_LOST_JOBS, lost);
    bool ok;
    pen_sqlite_int(&query, after);
    pen_sqlite_int(&query, capacity);
    *count = 0;
    while (pen_sqlite_next_row(&query, &ok, st))
        jobs[(*count)++] = (struct pen_lost_job){
            .number = pen_sqlite_column_int(&query, 0),
            .deaths = pen_sqlite_column_int(&query, 1),
            .charges = pen_sqlite_column_int(&query, 2),
            .max_attempts = pen_sqlite_column_int(&query, 3),
        };
    return ok;
}

bool pen_sqlite_open_lost(struct pen_driver *driver, const struct pen_lost *lost, bool quarantine,
                          int *opened, struct pen_status *st)
{
    struct pen_sqlite_query query = lost_query(driver, SQL_OPEN_LOST, lost);
    pen_sqlite_int(&query, quarantine);
    if (!pen_sqlite_run(&query, st))
        return false;
    *opened = sqlite3_changes(pen_sqlite_of(driver)->db);
    return true;
}

/* Begins the query for a page of a job's batches above `after`. */
static struct pen_sqlite_query page_query(struct pen_driver *driver, enum pen_sqlite_sql sql,
                                          int64_t job, int64_t after, int capacity)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), sql);
    pen_sqlite_int(&query, job);
    pen_sqlite_int(&query, after);
    pen_sqlite_int(&query, capacity);
    return query;
}

bool pen_sqlite_stats_page(struct pen_driver *driver, int64_t job, int64_t after,
                           struct pen_arena *arena, struct pen_stats_row *rows, int capacity,
                           int *count, struct pen_status *st)
{
    struct pen_sqlite_query query = page_query(driver, SQL_STATS_PAGE, job, after, capacity);
    bool ok, memory = true;
    *count = 0;
    while (pen_sqlite_next_row(&query, &ok, st))
        rows[(*count)++] = (struct pen_stats_row){
            .batch = pen_sqlite_column_int(&query, 0),
            .stats = {.view = (int)pen_sqlite_column_int(&query, 1),
                      .kind = (enum pen_batch_kind)pen_sqlite_column_int(&query, 2),
                      .commit_us = pen_sqlite_column_int(&query, 3),
                      .stats = pen_sqlite_column_keep(&query, 4, arena, &memory)},
        };
    return ok && (memory || pen_fail(st, PEN_NO_MEMORY, "no memory for statistics"));
}

bool pen_sqlite_batch_page(struct pen_driver *driver, int64_t job, int64_t after,
                           struct pen_arena *arena, struct pen_batch_record *rows, int capacity,
                           int *count, struct pen_status *st)
{
    struct pen_sqlite_query query = page_query(driver, SQL_BATCH_PAGE, job, after, capacity);
    bool ok, memory = true;
    *count = 0;
    while (pen_sqlite_next_row(&query, &ok, st))
        rows[(*count)++] = (struct pen_batch_record){
            .batch = pen_sqlite_column_int(&query, 0),
            .attempt = pen_sqlite_column_int(&query, 1),
            .kind = (enum pen_batch_kind)pen_sqlite_column_int(&query, 2),
            .state = (enum pen_batch_state)pen_sqlite_column_int(&query, 3),
            .view = (int)pen_sqlite_column_int(&query, 4),
            .first_tile = (int)pen_sqlite_column_int(&query, 5),
            .tile_count = (int)pen_sqlite_column_int(&query, 6),
            .pixels = pen_sqlite_column_int(&query, 7),
            .worker = pen_sqlite_column_keep(&query, 8, arena, &memory),
            .quarantined = pen_sqlite_column_int(&query, 9) != 0,
        };
    return ok && (memory || pen_fail(st, PEN_NO_MEMORY, "no memory for a list of batches"));
}

bool pen_sqlite_commit_page(struct pen_driver *driver, int64_t job, int64_t after,
                            struct pen_commit_record *rows, int capacity, int *count,
                            struct pen_status *st)
{
    struct pen_sqlite_query query = page_query(driver, SQL_COMMIT_PAGE, job, after, capacity);
    bool ok;
    *count = 0;
    while (pen_sqlite_next_row(&query, &ok, st))
        rows[(*count)++] = (struct pen_commit_record){
            .revision = pen_sqlite_column_int(&query, 0),
            .view = (int)pen_sqlite_column_int(&query, 1),
            .first_tile = (int)pen_sqlite_column_int(&query, 2),
            .tile_count = (int)pen_sqlite_column_int(&query, 3),
        };
    return ok;
}
