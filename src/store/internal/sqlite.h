/* SPDX-License-Identifier: MIT */
/* What the files db_sqlite*.c share. */
#ifndef PEN_STORE_INTERNAL_SQLITE_H
#define PEN_STORE_INTERNAL_SQLITE_H

#include <sqlite3.h>

#include "store/db.h"

enum {
    STATEMENTS = 512, /* slots of a table by address; about 150 are used */
    PEN_SQLITE_PATH_BYTES = 4096,
    PEN_SQLITE_BUSY_MS = 10000,
    PEN_SQLITE_PAGE = 8192,     /* of files that are made */
    PEN_RESERVE = 16 << 20,     /* the reserve's bytes, */
    PEN_RESERVE_FREE = 64 << 20 /* which is made where so many are free beside it */
};

struct pen_rows {
    struct pen_db *db;
    const char *sql; /* NULL: the slot is free */
    sqlite3_stmt *stmt;
    struct pen_status *st;
    bool ok;
};

struct pen_db {
    sqlite3 *sqlite;
    sqlite3_stmt *rollback; /* prepared, so that it needs no memory */
    char path[PEN_SQLITE_PATH_BYTES], reserve[PEN_SQLITE_PATH_BYTES];
    struct pen_rows statements[STATEMENTS];
    bool in; /* a transaction has begun */
    enum pen_db_access access;
    bool syncs;               /* synchronous=FULL */
    struct pen_status failed; /* of the first call that failed in the transaction */
    struct pen_db_trouble trouble;
    struct pen_status broken;      /* the first I/O error or damage; code PEN_OK: there was none */
    int64_t begun_ns, busy_ns;     /* of the transaction; of its wait for another one, */
    int64_t patience_ms;           /* and how long that may be */
    int64_t (*now_ms)(void *user); /* NULL: the wall clock */
    void *now_user;
};

/* Fills the status by SQLite's code, and notes it as the connection's trouble. Returns false. */
bool pen_sqlite_fail(struct pen_db *db, int rc, struct pen_status *st);
bool pen_sqlite_exec(struct pen_db *db, const char *sql, struct pen_status *st);

/* Opens a store, or only to read it. */
struct pen_db *pen_sqlite_open(const char *path, bool writes, struct pen_status *st);

/* Makes a name in the path's folder durable. Fails: errno. */
bool pen_sqlite_sync_folder(const char *path);

/* Looks for damage, for at most limit_ms (0: in everything). Returns SQLite's code: SQLITE_OK,
 * SQLITE_INTERRUPT (the time is up), or an error; `text` says what is damaged. */
int pen_sqlite_check(sqlite3 *sqlite, int limit_ms, char text[256]);

/* Makes the reserve file if it is not there; without it, cancels on a full disk fail. */
void pen_sqlite_make_reserve(struct pen_db *db);

#endif
