/* SPDX-License-Identifier: MIT */
/* Looks for damage in a store, in the whole of it or in a part that takes about START_MS at most,
 * however large it is. SQLite's own check reads every page of every table and index, and
 * compares each index with its table. It silently takes a log that was overwritten for an empty
 * one, so the log is checked first (wal.c). */
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "store/sqlite/sqlite.h"

enum { NAME_BYTES = 64, START_MS = 300, STEPS = 10000 };
static const int64_t small_bytes = INT64_C(64) << 20; /* a store up to this is checked whole */

/* Finds the table or index of a tree; "" if there is none. */
static void name_tree(struct pen_sqlite_store *store, int root, char name[NAME_BYTES])
{
    sqlite3_stmt *stmt = NULL;
    name[0] = '\0';
    if (sqlite3_prepare_v2(store->db,
                           "SELECT type || ' ' || name FROM sqlite_schema WHERE rootpage = ?", -1,
                           &stmt, NULL) == SQLITE_OK &&
        sqlite3_bind_int(stmt, 1, root) == SQLITE_OK && sqlite3_step(stmt) == SQLITE_ROW)
        snprintf(name, NAME_BYTES, "%s", (const char *)sqlite3_column_text(stmt, 0));
    sqlite3_finalize(stmt);
}

/* Fails with SQLite's verdict, whose first line may only name the database. */
static bool report(struct pen_sqlite_store *store, const char *verdict, struct pen_status *st)
{
    char what[200], name[NAME_BYTES] = "";
    int root;
    const char *line = strncmp(verdict, "***", 3) == 0 ? strchr(verdict, '\n') : NULL;
    snprintf(what, sizeof what, "%s", line ? line + 1 : verdict);
    what[strcspn(what, "\n")] = '\0';
    if (sscanf(what, "%*[^T]Tree %d", &root) == 1 || sscanf(what, "Tree %d", &root) == 1)
        name_tree(store, root, name);
    return pen_sqlite_damaged(store, st, "the store %s is damaged (%s%s%s)", store->path, name,
                              name[0] ? ": " : "", what);
}

/* Runs SQLite's check. One that was interrupted has found nothing so far. */
static bool run_check(struct pen_sqlite_store *store, const char *sql, struct pen_status *st)
{
    sqlite3_stmt *stmt = NULL;
    int rc = sqlite3_prepare_v2(store->db, sql, -1, &stmt, NULL);
    if (rc == SQLITE_OK)
        rc = sqlite3_step(stmt);
    if (rc == SQLITE_INTERRUPT) {
        sqlite3_finalize(stmt);
        return true;
    }
    bool ok = rc == SQLITE_ROW || pen_sqlite_error(store, rc, st);
    const char *verdict = ok ? (const char *)sqlite3_column_text(stmt, 0) : NULL;
    if (ok && (!verdict || strcmp(verdict, "ok") != 0))
        ok = pen_sqlite_is_refused_read(store, SQLITE_CORRUPT)
                 ? pen_sqlite_error(store, SQLITE_CORRUPT, st)
                 : report(store, verdict ? verdict : "no verdict", st);
    sqlite3_finalize(stmt);
    return ok;
}

bool pen_sqlite_check_pages(struct pen_sqlite_store *store, struct pen_status *st)
{
    return run_check(store, "PRAGMA integrity_check(1)", st);
}

bool pen_sqlite_check_file(struct pen_sqlite_store *store, struct pen_status *st)
{
    return pen_sqlite_check_log(store, st) && pen_sqlite_check_pages(store, st);
}

/* Compiles every statement: one that fails shows that the schema is not that of its version. */
static bool check_schema(struct pen_sqlite_store *store, struct pen_status *st)
{
    for (int sql = 0; sql < SQL_COUNT; sql++) {
        struct pen_sqlite_query query = pen_sqlite_query(store, (enum pen_sqlite_sql)sql);
        if (query.rc == SQLITE_ERROR)
            return pen_sqlite_damaged(
                store, st,
                "the store %s is damaged (its schema is not of the version that "
                "it says: %s)",
                store->path, sqlite3_errmsg(store->db));
        if (query.rc != SQLITE_OK)
            return pen_sqlite_error(store, query.rc, st);
    }
    return true;
}

bool pen_sqlite_check(struct pen_driver *driver, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    return pen_sqlite_check_file(store, st) && check_schema(store, st);
}

/* SQLite calls this every STEPS steps of a statement; a value other than 0 interrupts it. */
static int is_late(void *until_ns)
{
    return pen_clock_ns() >= *(const int64_t *)until_ns;
}

/* The tables on which everything else depends, as far as the time allows. Values of many pages,
 * which are most of a large store, have checksums: they are checked when they are read, and in the
 * background (scrub.c). */
static bool check_tables(struct pen_sqlite_store *store, struct pen_status *st)
{
    static const char *const checks[] = {
        "PRAGMA integrity_check(meta)", "PRAGMA integrity_check(worker)",
        "PRAGMA integrity_check(job)", "PRAGMA integrity_check(view)",
        "PRAGMA integrity_check(batch)"};
    int64_t until_ns = pen_clock_ns() + (int64_t)START_MS * 1000000;
    bool ok = true;
    sqlite3_progress_handler(store->db, STEPS, is_late, &until_ns);
    for (size_t i = 0; ok && i < sizeof checks / sizeof checks[0]; i++)
        ok = run_check(store, checks[i], st);
    sqlite3_progress_handler(store->db, 0, NULL, NULL);
    return ok;
}

/* Copies the log into the file. *all: nothing of it is left, which readers of an older state and
 * other writers may prevent. */
static bool copy_log(struct pen_sqlite_store *store, bool *all, struct pen_status *st)
{
    int log = 0, copied = 0;
    int rc = sqlite3_wal_checkpoint_v2(store->db, "main", SQLITE_CHECKPOINT_PASSIVE, &log, &copied);
    *all = rc == SQLITE_OK && log == copied;
    return rc == SQLITE_OK || (rc & 0xff) == SQLITE_BUSY || pen_sqlite_error(store, rc, st);
}

/* A file that was cut off is shorter than its header says. Pages that are in the log alone may lie
 * behind its end, so the log is copied first. While others keep it from being copied, or write
 * meanwhile, which changes the version, the length tells nothing. */
static bool check_length(struct pen_sqlite_store *store, struct pen_status *st)
{
    int64_t before, after, pages, bytes;
    bool copied;
    if (!pen_sqlite_pragma(store, "PRAGMA data_version", &before, st) ||
        !copy_log(store, &copied, st))
        return false;
    pen_sqlite_file_bytes(store, "", &bytes);
    if (!pen_sqlite_pragma(store, "PRAGMA page_count", &pages, st) ||
        !pen_sqlite_pragma(store, "PRAGMA data_version", &after, st))
        return false;
    return !copied || after != before || bytes >= pages * PEN_SQLITE_PAGE_BYTES ||
           pen_sqlite_damaged(
               store, st, "the store %s is damaged (it has %lld bytes and should have %lld)",
               store->path, (long long)bytes, (long long)(pages * PEN_SQLITE_PAGE_BYTES));
}

bool pen_sqlite_check_start(struct pen_driver *driver, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    int64_t bytes;
    pen_sqlite_file_bytes(store, "", &bytes);
    if (bytes <= small_bytes)
        return pen_sqlite_check(driver, st);
    return pen_sqlite_check_log(store, st) && check_schema(store, st) && check_tables(store, st) &&
           check_length(store, st);
}
