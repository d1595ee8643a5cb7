/* SPDX-License-Identifier: MIT */
/* A connection to a database, as the rules of this room need it: transactions, statements, a clock,
 * signals, space. internal/engine.h is what an engine implements of it: db_sqlite*.c and
 * db_postgres*.c, the only files that know SQLite and PostgreSQL.
 *
 * Statements are literals in the SQL that SQLite 3.40 and PostgreSQL 15 both know; SQL.md lists
 * what that excludes. Words in braces are replaced when a statement is prepared.
 *
 * Failures. A call that fails has filled the status. Within a transaction every later call fails at
 * once with the same status, so a chain of calls needs one check: pen_db_end rolls back and returns
 * false. pen_db_trouble then tells what has happened.
 *
 * Threads: a connection is used by one thread at a time; pen_db_wait and pen_db_wake by any. */
#ifndef PEN_STORE_DB_H
#define PEN_STORE_DB_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "store/store.h"

struct pen_db;

/* Opens a database; with `make`, makes it and its tables if it is not there. The schema's version
 * must be this build's. Owns: pen_db_close. Fails: as pen_store_open. */
struct pen_db *pen_db_open(const char *url, bool make, struct pen_status *st);
void pen_db_close(struct pen_db *db);

enum pen_db_access {
    PEN_DB_READ,  /* one snapshot for all statements */
    PEN_DB_WRITE, /* durable once it has ended well; SQLite: no other writer beside it */
    PEN_DB_PART   /* as a write, but its sync is left to a later write's */
};

/* Begins a transaction. Fails: PEN_UNAVAILABLE (busy for too long), PEN_STORAGE, PEN_STORAGE_FULL.
 */
bool pen_db_begin(struct pen_db *db, enum pen_db_access access, struct pen_status *st);

/* Ends it: commits if `ok` and no call in it has failed, else rolls back. Returns whether it is
 * committed. */
bool pen_db_end(struct pen_db *db, bool ok, struct pen_status *st);

/* What the last failed call of the database has done: `code` is that of its status, PEN_OK if the
 * last transaction had none. */
struct pen_db_trouble {
    enum pen_code code;
    enum pen_failure failure;
};
struct pen_db_trouble pen_db_trouble(const struct pen_db *db);

/* As pen_store_is_broken. */
bool pen_db_is_broken(const struct pen_db *db, struct pen_status *why);

/* A statement that is being run. It ends at its last row, at pen_db_done, or with its transaction.
 * The text is a literal: it is prepared once for each connection and found by its address. */
struct pen_rows;

/* Runs a statement with parameters, a letter for each in `types`:
 *   i int64_t   t const char *, NULL: null   b const void *, size_t, NULL: null
 * pen_db_run runs a statement without rows; *changed (may be NULL) is the number of rows changed.
 */
struct pen_rows *pen_db_rows(struct pen_db *db, struct pen_status *st, const char *sql,
                             const char *types, ...);
bool pen_db_run(struct pen_db *db, struct pen_status *st, int64_t *changed, const char *sql,
                const char *types, ...);

/* Reads the first column of the first row; 0: there is no row, or a null. */
bool pen_db_value(struct pen_db *db, struct pen_status *st, int64_t *value, const char *sql,
                  const char *types, ...);

/* The next row. False at the end and after a failure, which pen_db_done tells apart. */
bool pen_db_next(struct pen_rows *rows);

/* Ends the statement. Returns false if it has failed. NULL is a statement that has failed. */
bool pen_db_done(struct pen_rows *rows);

/* Columns of the row, from 0; they are valid until the next row. A null is 0 or NULL. */
int64_t pen_db_int(struct pen_rows *rows, int column);
const char *pen_db_text(struct pen_rows *rows, int column);
const void *pen_db_bytes(struct pen_rows *rows, int column, size_t *bytes);

/* The store's clock, as now_ms() in statements. Units: ms since 1970. */
bool pen_db_now(struct pen_db *db, int64_t *now_ms, struct pen_status *st);
void pen_db_set_clock(struct pen_db *db, int64_t (*now_ms)(void *user), void *user);

/* As pen_store_wait and pen_store_wake. */
void pen_db_wait(struct pen_db *db, uint32_t *seen, int timeout_ms);
void pen_db_wake(struct pen_db *db);

/* Bytes that the database uses (NULL: they are not needed), and bytes that it may still take from
 * the disk (INT64_MAX: that is somebody else's care). */
bool pen_db_space(struct pen_db *db, int64_t *used, int64_t *left, struct pen_status *st);

/* After a write that found the disk full: removes the reserve, so that a cancel or a delete finds
 * room. False if there is none. It is made again by pen_db_maintain once there is space. */
bool pen_db_give_reserve(struct pen_db *db);

/* A little housekeeping of the engine: gives at most `bytes` of free space back to the file system,
 * makes the reserve again, and empties a log that has become long. *more: there is more to do. */
bool pen_db_maintain(struct pen_db *db, int64_t bytes, bool *more, struct pen_status *st);

/* Looks for damage, for at most limit_ms (0: as long as it takes). *finished: it came to the end.
 * Fails: PEN_STORAGE with what is damaged. */
bool pen_db_check(struct pen_db *db, int limit_ms, bool *finished, struct pen_status *st);

/* Copies a database in use, as of one moment, to a file. Fails: as pen_store_backup. */
bool pen_db_backup(const char *url, const char *file, bool replace, struct pen_backup *out,
                   struct pen_status *st);

#endif
