/* SPDX-License-Identifier: MIT */
#include "support/store_sql.h"

#include <check.h>
#include <sqlite3.h>
#include <stdio.h>

void store_run_sql(const struct store_bed *bed, const char *sql, const void *blob, size_t bytes)
{
    sqlite3 *db;
    sqlite3_stmt *stmt;
    ck_assert_int_eq(sqlite3_open(bed->url, &db), SQLITE_OK);
    ck_assert_int_eq(sqlite3_prepare_v2(db, sql, -1, &stmt, NULL), SQLITE_OK);
    if (blob)
        sqlite3_bind_blob(stmt, 1, blob, (int)bytes, SQLITE_STATIC);
    ck_assert_msg(sqlite3_step(stmt) == SQLITE_DONE, "%s: %s", sql, sqlite3_errmsg(db));
    sqlite3_finalize(stmt);
    sqlite3_close(db);
}

/* undo[i] takes schema i + 2 back to i + 1; "" where the step changed no table. */
static const char *const undo[] = {
    "ALTER TABLE job DROP COLUMN deaths; ALTER TABLE job DROP COLUMN rest_until_ms;"
    "ALTER TABLE batch DROP COLUMN suspect",
    "DROP INDEX batch_by_revision; ALTER TABLE batch DROP COLUMN revision",
    "DROP TABLE worker",
    "",
    "",
    "ALTER TABLE artefact DROP COLUMN sum",
    "ALTER TABLE batch RENAME COLUMN quarantined TO suspect;"
    "ALTER TABLE job RENAME COLUMN paused_until_ms TO rest_until_ms;"
    "ALTER TABLE artefact RENAME COLUMN checksum TO sum; DROP INDEX batch_assemble;"
    "DROP TABLE worker; CREATE TABLE worker (name TEXT PRIMARY KEY, threads INTEGER NOT NULL,"
    " lease_ms INTEGER NOT NULL, started_ms INTEGER NOT NULL, seen_ms INTEGER NOT NULL)"
    " STRICT, WITHOUT ROWID",
    "ALTER TABLE worker DROP COLUMN lock_file",
    "ALTER TABLE job DROP COLUMN estimate_ms",
    "ALTER TABLE job DROP COLUMN spent_us; ALTER TABLE batch DROP COLUMN spent_us",
    "DROP INDEX job_by_service; DROP INDEX batch_open_of_lane;"
    "ALTER TABLE batch DROP COLUMN lane; ALTER TABLE job DROP COLUMN lane;"
    "ALTER TABLE job DROP COLUMN address; DROP TABLE lane; DROP TABLE peer;"
    "DROP TABLE level;"
    "DROP TABLE meta; DROP TABLE removed; DROP TABLE cached; DROP INDEX job_removed;"
    "DROP INDEX job_by_end; ALTER TABLE job DROP COLUMN removed_ms",
    "DROP TABLE attribute; DROP INDEX job_by_kind",
    "DROP TRIGGER artefact_removed; DROP TRIGGER artefact_replaced; DROP TRIGGER pixels_removed;"
    "DROP INDEX artefact_object; DROP INDEX pixels_object;"
    "ALTER TABLE artefact DROP COLUMN object; ALTER TABLE pixels DROP COLUMN object;"
    "DROP TABLE large_object_part; DROP TABLE large_object",
    "ALTER TABLE job DROP COLUMN committed_us; ALTER TABLE job DROP COLUMN committed_ms",
    "ALTER TABLE removed DROP COLUMN client;"
    "UPDATE job SET client = substr(client, 9) WHERE client LIKE 'address:%';"
    "UPDATE peer SET client = substr(client, 9) WHERE client LIKE 'address:%';"
    "ALTER TABLE job RENAME COLUMN client TO address;"
    "ALTER TABLE peer RENAME COLUMN client TO address;"
    "CREATE TABLE old_key (key TEXT PRIMARY KEY, body_sha256 BLOB NOT NULL"
    " CHECK (length(body_sha256) = 32), answer TEXT NOT NULL, created_ms INTEGER NOT NULL)"
    " STRICT, WITHOUT ROWID;"
    "INSERT OR IGNORE INTO old_key SELECT key, body_sha256, answer, created_ms FROM idempotency;"
    "DROP TABLE idempotency; ALTER TABLE old_key RENAME TO idempotency;"
    "CREATE INDEX idempotency_by_age ON idempotency(created_ms)",
    "DROP INDEX batch_open_of_peer; DROP INDEX job_by_service;"
    "CREATE TABLE lane (id INTEGER PRIMARY KEY AUTOINCREMENT,"
    " peer INTEGER NOT NULL REFERENCES peer(id), label TEXT NOT NULL,"
    " jobs INTEGER NOT NULL DEFAULT 0, served_us INTEGER NOT NULL DEFAULT 0,"
    " balance_us INTEGER NOT NULL DEFAULT 0, UNIQUE (peer, label)) STRICT;"
    "INSERT INTO lane (peer, label, jobs) SELECT id, '', jobs FROM peer WHERE jobs > 0;"
    "UPDATE job SET peer = coalesce((SELECT l.id FROM lane l WHERE l.peer = job.peer), 0);"
    "UPDATE batch SET peer = coalesce((SELECT l.id FROM lane l WHERE l.peer = batch.peer), 0);"
    "ALTER TABLE job RENAME COLUMN peer TO lane; ALTER TABLE batch RENAME COLUMN peer TO lane;"
    "ALTER TABLE peer DROP COLUMN balance_us;"
    "ALTER TABLE peer ADD COLUMN virtual_us INTEGER NOT NULL DEFAULT 0;"
    "CREATE INDEX batch_open_of_lane ON batch(lane, job, id) WHERE state = 0;"
    "CREATE INDEX job_by_service ON job(lane, spent_us, number) WHERE state < 2",
    "ALTER TABLE batch DROP COLUMN commit_us; ALTER TABLE job DROP COLUMN moment_ms;"
    "ALTER TABLE job DROP COLUMN moment_us; ALTER TABLE job DROP COLUMN moment_boot;"
    "ALTER TABLE job DROP COLUMN queue_us; ALTER TABLE job DROP COLUMN elapsed_us;"
    "UPDATE job SET told_elapsed_us = created_ms + told_elapsed_us / 1000"
    " WHERE told_elapsed_us > 0;"
    "ALTER TABLE job DROP COLUMN work; ALTER TABLE job DROP COLUMN cost_map;"
    "ALTER TABLE batch DROP COLUMN work;"
    "ALTER TABLE job RENAME COLUMN told_us TO committed_us;"
    "ALTER TABLE job RENAME COLUMN told_elapsed_us TO committed_ms",
};
enum { NEWEST = (int)(sizeof undo / sizeof undo[0]) + 1 };

int store_number(const char *file, const char *sql)
{
    sqlite3 *db;
    sqlite3_stmt *stmt;
    ck_assert_int_eq(sqlite3_open_v2(file, &db, SQLITE_OPEN_READWRITE, "unix"), SQLITE_OK);
    ck_assert_int_eq(sqlite3_prepare_v2(db, sql, -1, &stmt, NULL), SQLITE_OK);
    ck_assert_int_eq(sqlite3_step(stmt), SQLITE_ROW);
    int number = sqlite3_column_int(stmt, 0);
    sqlite3_finalize(stmt);
    sqlite3_close(db);
    return number;
}

int store_schema_version(const char *file)
{
    return store_number(file, "PRAGMA user_version");
}

void store_downgrade(const char *file, int version)
{
    char mark[64];
    char *error = NULL;
    sqlite3 *db;
    ck_assert_int_eq(store_schema_version(file), NEWEST);
    ck_assert_int_eq(sqlite3_open_v2(file, &db, SQLITE_OPEN_READWRITE, "unix"), SQLITE_OK);
    for (int i = NEWEST; i > version; i--) {
        sqlite3_exec(db, undo[i - 2], NULL, NULL, &error);
        ck_assert_msg(!error, "schema %d: %s", i, error);
    }
    snprintf(mark, sizeof mark, "PRAGMA user_version = %d", version);
    ck_assert_int_eq(sqlite3_exec(db, mark, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(db);
}
