/* SPDX-License-Identifier: MIT */
/* Looks for damage in a store. SQLite's own check reads every page of every table and index, and
 * compares each index with its table. It silently takes a log that was overwritten for an empty
 * one, so the log is checked first (wal.c). */
#include <stdio.h>
#include <string.h>

#include "store/sqlite/sqlite.h"

enum { NAME_BYTES = 64 };

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

bool pen_sqlite_check_pages(struct pen_sqlite_store *store, struct pen_status *st)
{
    sqlite3_stmt *stmt = NULL;
    int rc = sqlite3_prepare_v2(store->db, "PRAGMA integrity_check(1)", -1, &stmt, NULL);
    if (rc == SQLITE_OK)
        rc = sqlite3_step(stmt);
    bool ok = rc == SQLITE_ROW || pen_sqlite_error(store, rc, st);
    const char *verdict = ok ? (const char *)sqlite3_column_text(stmt, 0) : NULL;
    if (ok && (!verdict || strcmp(verdict, "ok") != 0))
        ok = pen_sqlite_is_refused_read(store, SQLITE_CORRUPT)
                 ? pen_sqlite_error(store, SQLITE_CORRUPT, st)
                 : report(store, verdict ? verdict : "no verdict", st);
    sqlite3_finalize(stmt);
    return ok;
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
