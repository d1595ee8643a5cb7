/* SPDX-License-Identifier: MIT */
/* The statements of the SQLite engine. Parameters are bound in the order of their question marks.
 */
#include "store/sqlite/sqlite.h"

#define JOB_COLUMNS                                                                                \
    "number, id, state, revision, kind, request, error, priority, max_attempts, charges,"          \
    " timeout_ms, created_ms, started_ms, finished_ms, updated_ms, done_pixels, total_pixels"

/* What a claim says; pen_sqlite_read_claim reads it. */
#define BATCH_COLUMNS                                                                              \
    "b.id, b.attempt, b.kind, b.job, b.view, b.first_tile, b.tile_count, b.pixels, v.batches,"     \
    " j.id, j.created_ms, j.started_ms, j.timeout_ms, s.sha256"
#define BATCH_TABLES                                                                               \
    " FROM batch b JOIN job j ON j.number = b.job JOIN view v ON v.job = b.job AND v.view = "      \
    "b.view"                                                                                       \
    " JOIN scene s ON s.id = j.scene"

/* Leases of ?2, and those that ran out before ?1. */
#define LOST "state = 1 AND (lease_until_ms < ?1 OR worker = ?2)"

static const char *const sql_text[SQL_COUNT] = {
    [SQL_BEGIN_READ] = "BEGIN",
    [SQL_BEGIN_WRITE] = "BEGIN IMMEDIATE",
    [SQL_COMMIT] = "COMMIT",
    [SQL_ROLLBACK] = "ROLLBACK",
    /* Any change will do, as long as it is written and synced. */
    [SQL_PROBE] = "INSERT INTO idempotency (key, body_sha256, answer, created_ms)"
                  " VALUES ('', zeroblob(32), '', ?) ON CONFLICT (key)"
                  " DO UPDATE SET answer = '', created_ms = excluded.created_ms",

    [SQL_PROBE_LARGE] = "INSERT INTO idempotency (key, body_sha256, answer, created_ms)"
                        " VALUES ('', zeroblob(32), hex(zeroblob(524288)), ?) ON CONFLICT (key)"
                        " DO UPDATE SET answer = excluded.answer,"
                        " created_ms = excluded.created_ms",

    [SQL_KEY_FIND] = "SELECT body_sha256, answer FROM idempotency WHERE key = ?",
    [SQL_KEY_ADD] = "INSERT INTO idempotency (key, body_sha256, answer, created_ms)"
                    " VALUES (?, ?, ?, ?)",
    [SQL_SCENE_FIND] = "SELECT id FROM scene WHERE sha256 = ?",
    [SQL_SCENE_ADD] = "INSERT INTO scene (sha256, document) VALUES (?, ?)",
    [SQL_JOB_ADD] = "INSERT INTO job (id, kind, scene, priority, max_attempts, timeout_ms,"
                    " created_ms, updated_ms, total_pixels, open_views, request)"
                    " VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    [SQL_VIEW_ADD] = "INSERT INTO view (job, view, name, width, height, batches, open_batches)"
                     " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?6)",
    [SQL_BATCH_ADD] =
        "INSERT INTO batch (job, view, kind, first_tile, tile_count, pixels, priority)"
        " VALUES (?1, ?2, ?3, ?4, ?5, ?6, (SELECT priority FROM job"
        " WHERE number = ?1))",

    [SQL_JOB_GET] = "SELECT " JOB_COLUMNS " FROM job WHERE id = ?",
    [SQL_JOB_LIST] = "SELECT " JOB_COLUMNS " FROM job WHERE number < ?1"
                     " AND (?2 IS NULL OR kind = ?2) ORDER BY number DESC LIMIT ?3",
    [SQL_JOB_LIST_STATE] = "SELECT " JOB_COLUMNS " FROM job WHERE number < ?1"
                           " AND (?2 IS NULL OR kind = ?2) AND state = ?4"
                           " ORDER BY number DESC LIMIT ?3",
    [SQL_JOB_NUMBER] = "SELECT number, state, scene FROM job WHERE id = ?",
    [SQL_SCENE_GET] = "SELECT s.document FROM job j JOIN scene s ON s.id = j.scene WHERE j.id = ?",

    [SQL_JOB_END] = "UPDATE job SET state = ?2, error = ?3, finished_ms = ?4, updated_ms = ?4,"
                    " revision = revision + 1 WHERE number = ?1 AND state IN (0, 1)",
    [SQL_BATCHES_END] = "UPDATE batch SET state = 3, worker = NULL, lease_until_ms = NULL,"
                        " suspect = 0 WHERE job = ? AND state IN (0, 1)",
    [SQL_JOB_REMOVE] = "DELETE FROM job WHERE number = ?",
    [SQL_SCENE_REMOVE_UNUSED] = "DELETE FROM scene WHERE id = ?1"
                                " AND NOT EXISTS (SELECT 1 FROM job WHERE scene = ?1)",

    [SQL_OPEN_ANY] = "SELECT 1 FROM batch WHERE state = 0 LIMIT 1",
    [SQL_OPEN_NEXT] = "SELECT " BATCH_COLUMNS BATCH_TABLES
                      " WHERE b.state = 0 AND j.rest_until_ms <= ?1 AND b.suspect <= ?2"
                      " ORDER BY b.priority DESC, b.job, b.id LIMIT 1",
    [SQL_HELD_BY] = "SELECT count(*), coalesce(max(suspect OR kind = 2), 0) FROM batch"
                    " WHERE state = 1 AND worker = ?",
    [SQL_BATCH_LEASE] = "UPDATE batch SET state = 1, attempt = ?2, worker = ?3, lease_until_ms = ?4"
                        " WHERE id = ?1 AND state = 0",
    [SQL_JOB_START] = "UPDATE job SET state = 1, started_ms = ?2, updated_ms = ?2,"
                      " revision = revision + 1 WHERE number = ?1 AND state = 0",

    [SQL_BATCH_GET] = "SELECT job, view, kind, state, attempt, pixels, lease_until_ms FROM batch"
                      " WHERE id = ?",
    [SQL_BATCH_DONE] =
        "UPDATE batch SET state = 2, worker = NULL, lease_until_ms = NULL, stats = ?3,"
        " done_ms = ?4, suspect = 0,"
        " revision = (SELECT revision FROM job WHERE number = batch.job)"
        " WHERE id = ?1 AND attempt = ?2 AND state = 1",
    [SQL_PIXELS_ADD] = "INSERT INTO pixels (batch, data) VALUES (?, ?)",
    [SQL_VIEW_COUNT_DOWN] = "UPDATE view SET open_batches = open_batches - 1"
                            " WHERE job = ? AND view = ?",
    [SQL_VIEW_GET] = "SELECT batches, open_batches FROM view WHERE job = ? AND view = ?",
    [SQL_JOB_PROGRESS] = "UPDATE job SET done_pixels = ?2 + CASE WHEN ?4 THEN 0"
                         " ELSE done_pixels END, updated_ms = ?3,"
                         " charges = 0, deaths = 0, rest_until_ms = 0, revision = revision + 1"
                         " WHERE number = ?1",
    [SQL_STUDY_PROGRESS] = "UPDATE job SET done_pixels = min(?2, total_pixels), updated_ms = ?3,"
                           " revision = revision + 1 WHERE number = ?1",
    [SQL_JOB_VIEW_ENDED] = "UPDATE job SET open_views = open_views - 1,"
                           " state = CASE WHEN open_views = 1 THEN 2 ELSE state END,"
                           " finished_ms = CASE WHEN open_views = 1 THEN ?2 ELSE finished_ms END"
                           " WHERE number = ?1",
    [SQL_BATCH_OPEN] = "UPDATE batch SET state = 0, worker = NULL, lease_until_ms = NULL"
                       " WHERE id = ? AND attempt = ? AND state = 1",
    [SQL_LEASE_EXTEND] = "UPDATE batch SET lease_until_ms = ?3"
                         " WHERE id = ?1 AND attempt = ?2 AND state = 1",
    [SQL_LOST_ANY] = "SELECT 1 FROM batch WHERE " LOST " LIMIT 1",
    /* The first death of a job is retried in its turn; from the second on it rests, 0.5 s to 1 min.
     */
    [SQL_LOST_JOBS] = "UPDATE job SET deaths = deaths + 1, rest_until_ms = CASE WHEN deaths = 0"
                      " THEN 0 ELSE ?3 + min(60000, 250 << min(deaths, 8)) END"
                      " WHERE number IN (SELECT job FROM batch WHERE " LOST ")",
    [SQL_LOST_OPEN] =
        "UPDATE batch SET state = 0, worker = NULL, lease_until_ms = NULL, suspect = 1"
        " WHERE " LOST,
    [SQL_LEFT_OPEN] = "UPDATE batch SET state = 0, worker = NULL, lease_until_ms = NULL"
                      " WHERE state = 1 AND worker = ?",
    [SQL_CHARGE_WHOM] = "SELECT " BATCH_COLUMNS ", j.charges, j.max_attempts" BATCH_TABLES
                        " WHERE b.state = 1 AND b.worker = ?1 AND 1 = (SELECT count(DISTINCT job)"
                        " FROM batch WHERE state = 1 AND worker = ?1) ORDER BY b.id LIMIT 1",
    [SQL_CHARGE] = "UPDATE job SET charges = charges + 1, updated_ms = ?2, revision = revision + 1"
                   " WHERE number = ?1",

    [SQL_PIXELS_LIST] = "SELECT b.first_tile, b.tile_count, b.pixels, p.data"
                        " FROM batch b JOIN pixels p ON p.batch = b.id"
                        " WHERE b.job = ? AND b.view = ? AND b.kind = 0 ORDER BY b.id",
    [SQL_STATS_LIST] = "SELECT view, kind, done_ms, stats FROM batch"
                       " WHERE job = ? AND state = 2 AND stats IS NOT NULL ORDER BY id",
    [SQL_BATCH_LIST] = "SELECT id, attempt, kind, state, view, first_tile, tile_count, pixels,"
                       " worker, suspect FROM batch WHERE job = ? ORDER BY id",
    [SQL_COMMIT_LIST] = "SELECT revision, view, first_tile, tile_count FROM batch"
                        " WHERE job = ? AND revision > ? AND kind = 0 ORDER BY revision",
    [SQL_ARTEFACT_GET] = "SELECT data, sum FROM artefact"
                         " WHERE job = ? AND view = ? AND layer = ? AND format = ?",
    [SQL_ARTEFACT_PUT] = "INSERT INTO artefact (job, view, layer, format, data, sum)"
                         " VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT (job, view, layer, format)"
                         " DO UPDATE SET data = excluded.data, sum = excluded.sum",

    [SQL_WORKER_SEEN] = "INSERT INTO worker (name, threads, lease_ms, started_ms, seen_ms)"
                        " VALUES (?1, ?2, ?3, ?4, ?4) ON CONFLICT (name) DO UPDATE SET"
                        " threads = ?2, lease_ms = ?3, seen_ms = ?4",
    [SQL_WORKER_GONE] = "DELETE FROM worker WHERE name = ?",
    [SQL_WORKER_LIST] = "SELECT w.name, w.threads, w.started_ms, max(w.seen_ms,"
                        " coalesce(b.lease_until_ms - w.lease_ms, 0)), j.id, v.name, b.id,"
                        " b.attempt, b.kind, b.pixels FROM worker w"
                        " LEFT JOIN batch b ON b.state = 1 AND b.worker = w.name"
                        " LEFT JOIN job j ON j.number = b.job"
                        " LEFT JOIN view v ON v.job = b.job AND v.view = b.view"
                        " ORDER BY w.started_ms, w.name, b.id",

    [SQL_TIDY_WORKERS] = "DELETE FROM worker WHERE seen_ms < ?",
    [SQL_TIDY_KEYS] = "DELETE FROM idempotency WHERE created_ms < ?",
    [SQL_TIDY_SCENES] = "DELETE FROM scene WHERE NOT EXISTS"
                        " (SELECT 1 FROM job WHERE job.scene = scene.id)",
    [SQL_FREE_PAGES] = "PRAGMA freelist_count",
    [SQL_VACUUM] = "PRAGMA incremental_vacuum(2048)",
};

const char *pen_sqlite_sql_text(enum pen_sqlite_sql sql)
{
    return sql_text[sql];
}
