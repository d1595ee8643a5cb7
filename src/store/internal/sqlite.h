/* SPDX-License-Identifier: MIT */
/* Declarations that the files db_sqlite*.c share. */
#ifndef PEN_STORE_INTERNAL_SQLITE_H
#define PEN_STORE_INTERNAL_SQLITE_H

#include <sqlite3.h>

#include "store/internal/engine.h"
#include "store/internal/engines.h"

enum {
    STATEMENTS = 512, /* slots of a table by address; about 150 are used */
    PEN_SQLITE_PATH_BYTES = 4096,
    PEN_SQLITE_BUSY_MS = 10000,
    PEN_SQLITE_PAGE = 8192,     /* page size of new files */
    PEN_RESERVE = 16 << 20,     /* size of the reserve file */
    PEN_RESERVE_FREE = 64 << 20 /* free bytes beside it that are needed to make it */
};

struct pen_sqlite_rows {
    struct pen_rows base;
    const char *sql; /* NULL: the slot is free */
    sqlite3_stmt *stmt;
};

struct pen_sqlite {
    struct pen_db base;
    sqlite3 *sqlite;
    sqlite3_stmt *rollback; /* prepared early, because later it must not need memory */
    char path[PEN_SQLITE_PATH_BYTES], reserve[PEN_SQLITE_PATH_BYTES];
    struct pen_sqlite_rows statements[STATEMENTS];
    bool syncs;          /* synchronous=FULL */
    int64_t busy_ns;     /* when a wait for another transaction began */
    int64_t patience_ms; /* longest such wait */
};

extern const struct pen_engine pen_sqlite_engine;

/* Fills the status from SQLite's code, and notes it as the connection's trouble. Returns false. */
bool pen_sqlite_fail(struct pen_sqlite *db, int rc, struct pen_status *st);
bool pen_sqlite_exec(struct pen_sqlite *db, const char *sql, struct pen_status *st);

/* Opens an existing store. Without `writes`, it is opened only to read. */
struct pen_sqlite *pen_sqlite_open_file(const char *path, bool writes, struct pen_status *st);

/* Makes a name in the path's folder durable.
 * Fails: errno. */
bool pen_sqlite_sync_folder(const char *path);

/* Looks for damage, for at most limit_ms (0: no limit). Returns SQLite's code: SQLITE_OK,
 * SQLITE_INTERRUPT (the time is up), or an error, with the damage in `text`. */
int pen_sqlite_check(sqlite3 *sqlite, int limit_ms, char text[256]);

/* As pen_db_check. */
bool pen_sqlite_check_store(struct pen_db *db, int limit_ms, bool *finished, struct pen_status *st);

/* Makes the reserve file if it is missing. Without it, a cancel on a full disk fails. */
void pen_sqlite_make_reserve(struct pen_sqlite *db);

#endif
