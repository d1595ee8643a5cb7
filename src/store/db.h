/* SPDX-License-Identifier: MIT */
/* A connection to a database, as the rules of this module need it: transactions, statements, a
 * clock, signals, space. An engine implements it (internal/engine.h). Only the engines,
 * db_sqlite*.c and db_postgres*.c, know SQLite and PostgreSQL.
 *
 * Statements are literals, in the SQL that SQLite 3.40 and PostgreSQL 15 share; SQL.md lists what
 * this excludes. Words in braces are replaced when a statement is prepared.
 *
 * A call that fails fills the status. Within a transaction, every later call then fails at once
 * with the same status. So a chain of calls needs one check: pen_db_end rolls back and returns
 * false. pen_db_trouble then tells what happened.
 *
 * Threads: one thread at a time uses a connection; any thread may call pen_db_wait and
 * pen_db_wake. */
#ifndef PEN_STORE_DB_H
#define PEN_STORE_DB_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "store/store.h"

struct pen_db;

/* Opens a database. With `make`, a missing database and its tables are made. The schema's version
 * must be this build's.
 * Owns: close with pen_db_close.
 * Fails: as pen_store_open. */
struct pen_db *pen_db_open(const char *url, bool make, struct pen_status *st);
void pen_db_close(struct pen_db *db);

enum pen_db_access {
    PEN_DB_READ,  /* one snapshot for all statements */
    PEN_DB_WRITE, /* durable once it has ended well; SQLite: only one writer at a time */
    PEN_DB_PART   /* a write whose sync is left to a later write */
};

/* Begins a transaction.
 * Fails: PEN_UNAVAILABLE (busy for too long), PEN_STORAGE, PEN_STORAGE_FULL. */
bool pen_db_begin(struct pen_db *db, enum pen_db_access access, struct pen_status *st);

/* Ends the transaction. It commits if `ok` is true and no call in it has failed; else it rolls
 * back. Returns true if it has committed. */
bool pen_db_end(struct pen_db *db, bool ok, struct pen_status *st);

/* The effect of the last failed call of this connection. `code` is that of its status; PEN_OK if
 * the last transaction had no failure. */
struct pen_db_trouble {
    enum pen_code code;
    enum pen_failure failure;
};
struct pen_db_trouble pen_db_trouble(const struct pen_db *db);

/* As pen_store_is_broken. */
bool pen_db_is_broken(const struct pen_db *db, struct pen_status *why);

/* A running statement. It ends at its last row, at pen_db_done, or with its transaction. The text
 * is a literal: each connection prepares it once and finds it by its address. */
struct pen_rows;

/* Runs a statement with parameters. Each letter of `types` is a parameter:
 *   i int64_t   t const char *, NULL: null   b const void *, size_t, NULL: null
 * pen_db_run runs a statement without rows; *changed (may be NULL) is the number of changed
 * rows. */
struct pen_rows *pen_db_rows(struct pen_db *db, struct pen_status *st, const char *sql,
                             const char *types, ...);
bool pen_db_run(struct pen_db *db, struct pen_status *st, int64_t *changed, const char *sql,
                const char *types, ...);

/* Reads the first column of the first row. It is 0 if there is no row, or for a null. */
bool pen_db_value(struct pen_db *db, struct pen_status *st, int64_t *value, const char *sql,
                  const char *types, ...);

/* Steps to the next row. Returns false at the end and after a failure; pen_db_done tells which. */
bool pen_db_next(struct pen_rows *rows);

/* Ends the statement. Returns false if it has failed. `rows` NULL is a statement that has
 * failed. */
bool pen_db_done(struct pen_rows *rows);

/* Columns of the row, from 0. They are valid until the next row. A null is 0 or NULL. */
int64_t pen_db_int(struct pen_rows *rows, int column);
const char *pen_db_text(struct pen_rows *rows, int column);
const void *pen_db_bytes(struct pen_rows *rows, int column, size_t *bytes);

/* The store's clock; statements call it now_ms().
 * Units: ms since 1970. */
bool pen_db_now(struct pen_db *db, int64_t *now_ms, struct pen_status *st);
void pen_db_set_clock(struct pen_db *db, int64_t (*now_ms)(void *user), void *user);

/* As pen_store_wait and pen_store_wake. */
void pen_db_wait(struct pen_db *db, uint32_t *seen, int timeout_ms);
void pen_db_wake(struct pen_db *db);

/* Reads two sizes. *used (may be NULL) is what the database uses. *left is what it may still take
 * from the disk; INT64_MAX if the store does not know it.
 * Units: bytes. */
bool pen_db_space(struct pen_db *db, int64_t *used, int64_t *left, struct pen_status *st);

/* Removes the reserve file after a write found the disk full, so that a cancel or a delete has
 * space. Returns false if there is none. pen_db_maintain makes it again once there is space. */
bool pen_db_give_reserve(struct pen_db *db);

/* Does a part of the engine's housekeeping: gives at most `bytes` of free space back to the file
 * system, makes the reserve again, and empties a long log. *more says whether there is more to
 * do. */
bool pen_db_maintain(struct pen_db *db, int64_t bytes, bool *more, struct pen_status *st);

/* Looks for damage, for at most limit_ms (0: no limit). *finished says whether everything was
 * checked.
 * Fails: PEN_STORAGE with the damage found. */
bool pen_db_check(struct pen_db *db, int limit_ms, bool *finished, struct pen_status *st);

/* Copies a database in use to a file, as of one moment.
 * Fails: as pen_store_backup. */
bool pen_db_backup(const char *url, const char *file, bool replace, struct pen_backup *out,
                   struct pen_status *st);

#endif
