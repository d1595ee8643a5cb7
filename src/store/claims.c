/* SPDX-License-Identifier: MIT */
/* What a worker does with claims: claim, heartbeat, estimate, release, fail. A claim locks only
 * batches and never waits for a job. The other calls lock the job first. */
#include <string.h>

#include "store/internal/handle.h"

/* Leases the first open batch. A quarantined batch needs a worker that holds no other batch. A
 * study needs one too, but is not passed over: it waits for such a worker. Batches that wait after
 * lost workers come last; `waiting` includes them. */
static bool lease(struct pen_store *store, const struct pen_next *next, int64_t held, bool waiting,
                  int64_t *batch, int64_t *job, struct pen_status *st)
{
    return pen_row_numbers(
        pen_db_rows(
            store->db, st,
            "UPDATE batch SET state = 1, attempt = attempt + 1, worker = $1, serial = $2, "
            "claimed_ms = (SELECT now_ms()), lease_ms = (SELECT now_ms()) + $3, spent_us = 0 "
            "WHERE number = (SELECT number FROM batch WHERE state = 0 AND "
            "($5 = 1 OR not_before_ms <= (SELECT now_ms())) AND alone <= $4 ORDER BY priority "
            "DESC, turn, number LIMIT 1 {skip_locked}) "
            "AND (kind <> 2 OR $4 = 1) RETURNING number, job",
            "tiiii", next->worker, next->serial, next->lease_ms, (int64_t)(held == 0),
            (int64_t)waiting),
        batch, job, NULL);
}

bool pen_claim_read(struct pen_store *store, int64_t batch, struct pen_claim *claim, bool *found,
                    struct pen_status *st)
{
    size_t bytes;
    struct pen_rows *rows = pen_db_rows(
        store->db, st,
        "SELECT batch.attempt, batch.kind, batch.view, batch.first_tile, batch.tile_count, "
        "batch.pixels, batch.claimed_ms, job.id, job.created_ms, job.started_ms, job.timeout_ms, "
        "job.spent_us - batch.spent_us, job.work - batch.work, view.batches, scene.sha256 "
        "FROM batch JOIN job ON job.number = batch.job "
        "LEFT JOIN view ON view.job = batch.job AND view.view = batch.view "
        "LEFT JOIN scene ON scene.number = job.scene WHERE batch.number = $1",
        "i", batch);
    *claim = (struct pen_claim){.batch = batch};
    *found = pen_db_next(rows);
    if (*found) {
        *claim = (struct pen_claim){.batch = batch,
                                    .attempt = pen_db_int(rows, 0),
                                    .kind = (enum pen_batch_kind)pen_db_int(rows, 1),
                                    .view = (int)pen_db_int(rows, 2),
                                    .first_tile = (int)pen_db_int(rows, 3),
                                    .tile_count = (int)pen_db_int(rows, 4),
                                    .pixels = pen_db_int(rows, 5),
                                    .claimed_ms = pen_db_int(rows, 6),
                                    .submitted_ms = pen_db_int(rows, 8),
                                    .started_ms = pen_db_int(rows, 9),
                                    .timeout_ms = pen_db_int(rows, 10),
                                    .job_spent_us = pen_db_int(rows, 11),
                                    .job_work = pen_db_int(rows, 12),
                                    .view_batches = (int)pen_db_int(rows, 13)};
        memcpy(claim->job_id, pen_db_text(rows, 7), sizeof claim->job_id);
        if (claim->started_ms ==
            0) /* another transaction holds the job's lock; the job is started later */
            claim->started_ms = claim->claimed_ms;
        const void *sha256 = pen_db_bytes(rows, 14, &bytes);
        if (bytes == sizeof claim->scene_sha256)
            memcpy(claim->scene_sha256, sha256, bytes);
    }
    return pen_db_done(rows);
}

/* Leases a batch, unless the worker holds a study or a quarantined batch, and starts its job. */
static bool take(struct pen_store *store, const struct pen_next *next, int64_t *batch,
                 struct pen_status *st)
{
    int64_t held, alone, job;
    if (!pen_row_numbers(pen_db_rows(store->db, st,
                                     "SELECT count(*), CAST(sum(CASE WHEN alone = 1 OR kind = 2 "
                                     "THEN 1 ELSE 0 END) AS BIGINT) "
                                     "FROM batch WHERE state = 1 AND worker = $1",
                                     "t", next->worker),
                         &held, &alone, NULL))
        return false;
    return alone > 0 || (lease(store, next, held, false, batch, &job, st) &&
                         (*batch > 0 || lease(store, next, held, true, batch, &job, st)) &&
                         (*batch == 0 || pen_job_start(store, job, st)));
}

bool pen_claim_next(struct pen_store *store, struct pen_next *next, struct pen_status *st)
{
    int64_t batch;
    next->found = false;
    return pen_db_value(store->db, st, &batch,
                        "SELECT number FROM batch WHERE state = 1 AND worker = $1 AND serial = $2",
                        "ti", next->worker, next->serial) &&
           (batch > 0 || take(store, next, &batch, st)) &&
           (batch == 0 || pen_claim_read(store, batch, &next->claim, &next->found, st));
}

/* Reads first, so that an idle worker does not write. */
bool pen_store_claim(struct pen_store *store, const char *worker, int64_t lease_ms, int64_t serial,
                     struct pen_claim *claim, bool *found, struct pen_status *st)
{
    struct pen_next next = {.worker = worker, .lease_ms = lease_ms, .serial = serial};
    int64_t any;
    *found = false;
    if (!pen_db_value(store->db, st, &any,
                      "SELECT 1 FROM batch WHERE state = 0 UNION ALL SELECT 1 FROM batch "
                      "WHERE state = 1 AND worker = $1 AND serial = $2 LIMIT 1",
                      "ti", worker, serial))
        return false;
    if (any == 0)
        return true;
    if (!pen_db_begin(store->db, PEN_DB_WRITE, st) ||
        !pen_db_end(store->db, pen_claim_next(store, &next, st), st))
        return false;
    *found = next.found;
    if (next.found) {
        *claim = next.claim;
        pen_db_wake(store->db);
    }
    return true;
}

bool pen_store_heartbeat(struct pen_store *store, struct pen_claim *claim, int64_t lease_ms,
                         bool *held, struct pen_status *st)
{
    struct pen_batch batch;
    int64_t found, left_ms, spent_us, work;
    *held = false;
    if (!pen_row_numbers(
            pen_db_rows(store->db, st,
                        "SELECT 1, batch.lease_ms - (SELECT now_ms()), "
                        "job.spent_us - batch.spent_us, job.work - batch.work FROM batch "
                        "JOIN job ON job.number = batch.job "
                        "WHERE batch.number = $1 AND batch.attempt = $2 AND batch.state = 1",
                        "ii", claim->batch, claim->attempt),
            &found, &left_ms, &spent_us, &work, NULL))
        return false;
    if (found == 0)
        return true;
    *held = true;
    claim->job_spent_us = spent_us;
    claim->job_work = work;
    if (claim->estimate_ms == 0 && left_ms >= lease_ms - lease_ms / 3 && left_ms <= lease_ms)
        return true;
    if (!pen_db_begin(store->db, PEN_DB_WRITE, st) ||
        !pen_write_end(
            store,
            pen_claim_lock(store, claim, &batch, st) &&
                (!batch.held ||
                 (pen_db_run(store->db, st, NULL,
                             "UPDATE batch SET lease_ms = (SELECT now_ms()) + $2 WHERE number = $1",
                             "ii", claim->batch, lease_ms) &&
                  (claim->estimate_ms == 0 ||
                   pen_claim_tell(store, &batch, 0, claim->work, claim->estimate_ms, st)))),
            st))
        return false;
    *held = batch.held;
    return true;
}

bool pen_store_estimate(struct pen_store *store, const struct pen_claim *claim, int64_t estimate_ms,
                        const struct pen_buf *cost_map, struct pen_status *st)
{
    struct pen_batch batch;
    return pen_db_begin(store->db, PEN_DB_WRITE, st) &&
           pen_write_end(store,
                         pen_claim_hold(store, claim, "its estimate was refused", &batch, st) &&
                             pen_claim_tell(store, &batch, 0, 0, estimate_ms, st) &&
                             (!cost_map ||
                              pen_db_run(store->db, st, NULL,
                                         "UPDATE job SET cost_map = $2 WHERE number = $1", "ib",
                                         batch.job, (const void *)cost_map->data, cost_map->bytes)),
                         st);
}

bool pen_store_release(struct pen_store *store, const struct pen_claim *claim,
                       struct pen_status *st)
{
    struct pen_opening opening = {.batch = claim->batch, .worker = "", .before_ms = INT64_MAX};
    struct pen_batch batch;
    int64_t opened;
    if (!pen_db_begin(store->db, PEN_DB_WRITE, st))
        return false;
    const bool ok = pen_claim_lock(store, claim, &batch, st);
    opening.job = batch.job;
    return pen_write_end(store,
                         ok && (!batch.held || pen_batches_open(store, &opening, &opened, st)), st);
}

bool pen_store_fail(struct pen_store *store, const struct pen_claim *claim, const char *error,
                    struct pen_status *st)
{
    struct pen_batch batch;
    return pen_db_begin(store->db, PEN_DB_WRITE, st) &&
           pen_write_end(store,
                         pen_claim_hold(store, claim, "its job was left as it is", &batch, st) &&
                             pen_job_end(store, batch.job, PEN_JOB_FAILED, error, st),
                         st);
}
