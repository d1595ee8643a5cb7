/* SPDX-License-Identifier: MIT */
/* Statements, transactions and errors of the SQLite driver. */
#include "store/sqlite/sqlite.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

struct pen_sqlite_query pen_sqlite_query(struct pen_sqlite_store *store, enum pen_sqlite_sql sql)
{
    struct pen_sqlite_query query = {.store = store, .stmt = store->stmt[sql]};
    if (!query.stmt) {
        query.rc = sqlite3_prepare_v3(store->db, pen_sqlite_sql_text(sql), -1,
                                      SQLITE_PREPARE_PERSISTENT, &query.stmt, NULL);
        store->stmt[sql] = query.stmt;
    }
    return query;
}

void pen_sqlite_int(struct pen_sqlite_query *query, int64_t value)
{
    if (query->rc == SQLITE_OK)
        query->rc = sqlite3_bind_int64(query->stmt, ++query->bound, value);
}

void pen_sqlite_text(struct pen_sqlite_query *query, const char *text)
{
    if (query->rc == SQLITE_OK)
        query->rc = sqlite3_bind_text(query->stmt, ++query->bound, text, -1, SQLITE_STATIC);
}

void pen_sqlite_blob(struct pen_sqlite_query *query, const void *data, size_t bytes)
{
    if (query->rc == SQLITE_OK)
        query->rc = sqlite3_bind_blob64(query->stmt, ++query->bound, bytes ? data : "", bytes,
                                        SQLITE_STATIC);
}

void pen_sqlite_end(struct pen_sqlite_query *query)
{
    if (query->stmt) {
        sqlite3_reset(query->stmt);
        sqlite3_clear_bindings(query->stmt);
    }
}

bool pen_sqlite_next(struct pen_sqlite_query *query, bool *row, struct pen_status *st)
{
    int rc = query->rc;
    if (rc == SQLITE_OK)
        rc = sqlite3_step(query->stmt);
    *row = rc == SQLITE_ROW;
    if (*row)
        return true;
    bool ok = rc == SQLITE_DONE || pen_sqlite_error(query->store, rc, st);
    pen_sqlite_end(query);
    return ok;
}

bool pen_sqlite_next_row(struct pen_sqlite_query *query, bool *ok, struct pen_status *st)
{
    bool row;
    *ok = pen_sqlite_next(query, &row, st);
    return row;
}

bool pen_sqlite_run(struct pen_sqlite_query *query, struct pen_status *st)
{
    bool row = true;
    while (row) {
        if (!pen_sqlite_next(query, &row, st))
            return false;
    }
    return true;
}

bool pen_sqlite_run_changed(struct pen_sqlite_query *query, bool *changed, struct pen_status *st)
{
    if (!pen_sqlite_run(query, st))
        return false;
    *changed = sqlite3_changes(query->store->db) > 0;
    return true;
}

bool pen_sqlite_run_limited(struct pen_sqlite_query *query, int limit, bool *more,
                            struct pen_status *st)
{
    pen_sqlite_int(query, limit);
    if (!pen_sqlite_run(query, st))
        return false;
    *more = sqlite3_changes(query->store->db) >= limit;
    return true;
}

bool pen_sqlite_run_with(struct pen_sqlite_store *store, enum pen_sqlite_sql sql, int64_t number,
                         struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, sql);
    pen_sqlite_int(&query, number);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_value(struct pen_sqlite_query *query, int64_t *value, struct pen_status *st)
{
    bool row;
    if (!pen_sqlite_next(query, &row, st))
        return false;
    *value = row ? pen_sqlite_column_int(query, 0) : 0;
    pen_sqlite_end(query);
    return true;
}

int64_t pen_sqlite_column_int(const struct pen_sqlite_query *query, int column)
{
    return sqlite3_column_int64(query->stmt, column);
}

const char *pen_sqlite_column_text(const struct pen_sqlite_query *query, int column)
{
    return (const char *)sqlite3_column_text(query->stmt, column);
}

struct pen_bytes pen_sqlite_column_blob(const struct pen_sqlite_query *query, int column)
{
    const void *data = sqlite3_column_blob(query->stmt, column);
    return (struct pen_bytes){data, data ? (size_t)sqlite3_column_bytes(query->stmt, column) : 0};
}

char *pen_sqlite_column_dup(const struct pen_sqlite_query *query, int column, bool *ok)
{
    if (sqlite3_column_type(query->stmt, column) == SQLITE_NULL)
        return NULL;
    const char *text = pen_sqlite_column_text(query, column);
    char *copy = text ? strdup(text) : NULL;
    if (!copy)
        *ok = false;
    return copy;
}

const char *pen_sqlite_column_keep(const struct pen_sqlite_query *query, int column,
                                   struct pen_arena *arena, bool *ok)
{
    if (sqlite3_column_type(query->stmt, column) == SQLITE_NULL)
        return NULL;
    const char *text = pen_sqlite_column_text(query, column);
    const char *copy = text ? pen_arena_strdup(arena, text) : NULL;
    if (!copy)
        *ok = false;
    return copy;
}

static void note_fault(struct pen_sqlite_store *store, enum pen_fault fault, int error)
{
    store->base.faults |= 1u << fault;
    store->base.fault_errno = error;
    if (fault != PEN_FAULT_FULL)
        store->sound = false;
}

bool pen_sqlite_damaged(struct pen_sqlite_store *store, struct pen_status *st, const char *format,
                        ...)
{
    char what[PEN_MSG_BYTES];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    note_fault(store, PEN_FAULT_DAMAGE, 0);
    return pen_fail(st, PEN_STORAGE,
                    "%s; nothing was changed: stop Penumbra and restore a backup, or move the file "
                    "away to begin anew",
                    what);
}

static const char *what_failed(int rc)
{
    switch (rc) {
    case SQLITE_IOERR_READ:
    case SQLITE_IOERR_CORRUPTFS:
    case SQLITE_IOERR_SHORT_READ:
        return "be read";
    case SQLITE_IOERR_WRITE:
    case SQLITE_IOERR_TRUNCATE:
        return "be written";
    case SQLITE_IOERR_FSYNC:
    case SQLITE_IOERR_DIR_FSYNC:
    case SQLITE_IOERR_CLOSE:
        return "be synced to the disk";
    case SQLITE_IOERR_SHMOPEN:
    case SQLITE_IOERR_SHMSIZE:
    case SQLITE_IOERR_SHMMAP:
        return "make its shared memory, the file ending in -shm";
    default:
        break;
    }
    return (rc & 0xff) == SQLITE_CANTOPEN ? "be opened" : "be used";
}

/* Tells whether the process lacks memory or descriptors, which is no fault of the store. */
static bool is_process_limit(int rc, int error)
{
    return rc == SQLITE_NOMEM || rc == SQLITE_IOERR_NOMEM ||
           (rc != SQLITE_FULL && (error == ENOMEM || error == EMFILE || error == ENFILE));
}

static bool fail_limit(const struct pen_sqlite_store *store, int error, struct pen_status *st)
{
    return error == EMFILE || error == ENFILE
               ? pen_fail(st, PEN_UNAVAILABLE, "the store %s cannot be opened: %s", store->path,
                          strerror(error))
               : pen_fail(st, PEN_NO_MEMORY, "no memory for the store");
}

bool pen_sqlite_io_error(struct pen_sqlite_store *store, int rc, int error, struct pen_status *st)
{
    if (is_process_limit(rc, error))
        return fail_limit(store, error, st);
    bool full = (rc & 0xff) == SQLITE_FULL || pen_errno_is_full(error);
    bool sync = rc == SQLITE_IOERR_FSYNC || rc == SQLITE_IOERR_DIR_FSYNC;
    note_fault(store, full && !sync ? PEN_FAULT_FULL : PEN_FAULT_IO, error);
    if (full && !sync)
        return pen_fail(st, PEN_STORAGE_FULL, "the store %s has no space left", store->path);
    return pen_fail(st, full ? PEN_STORAGE_FULL : PEN_STORAGE, "the store %s could not %s: %s",
                    store->path, what_failed(rc), error ? strerror(error) : sqlite3_errstr(rc));
}

/* The store's files: the log, and the store itself. */
enum { FILES = 2 };

/* The errno of a file's last failure, however long ago; 0: none. */
static int errno_of_file(struct pen_sqlite_store *store, int i)
{
    static const int files[FILES] = {SQLITE_FCNTL_JOURNAL_POINTER, SQLITE_FCNTL_FILE_POINTER};
    sqlite3_file *file = NULL;
    int error = 0;
    if (sqlite3_file_control(store->db, "main", files[i], &file) == SQLITE_OK && file &&
        file->pMethods)
        file->pMethods->xFileControl(file, SQLITE_FCNTL_LAST_ERRNO, &error);
    return error;
}

/* SQLite passes on the errno of most failures. Only the files know that of a failed commit. */
static int errno_of(struct pen_sqlite_store *store)
{
    int error = sqlite3_system_errno(store->db);
    for (int i = 0; i < FILES && !error; i++)
        error = errno_of_file(store, i);
    return error;
}

bool pen_sqlite_is_refused_read(struct pen_sqlite_store *store, int rc)
{
    /* Either file may have refused it; the other one may still have the errno of an older failure.
     */
    for (int i = 0; i < FILES && (rc & 0xff) == SQLITE_CORRUPT; i++) {
        int error = errno_of_file(store, i);
        if (error == EIO || error == ENXIO)
            return true;
    }
    return false;
}

bool pen_sqlite_error(struct pen_sqlite_store *store, int rc, struct pen_status *st)
{
    if (pen_sqlite_is_refused_read(store, rc))
        return pen_sqlite_io_error(store, SQLITE_IOERR_READ, EIO, st);
    int kind = rc & 0xff;
    bool system = kind == SQLITE_IOERR || kind == SQLITE_CANTOPEN;
    int error = system ? errno_of(store) : 0;
    /* SQLite does not keep the errno of this failure. In a commit the log was written before, so
     * that its outcome is not known, and it must not count as refused for lack of space. */
    if (rc == SQLITE_IOERR_SHMSIZE && error == 0 && !store->commits &&
        pen_sqlite_index_is_refused(store))
        error = ENOSPC;
    switch (kind) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_PROTOCOL:
        return pen_fail(st, PEN_UNAVAILABLE, "the store %s is busy", store->path);
    case SQLITE_TOOBIG:
        return pen_fail(st, PEN_TOO_LARGE, "too large to be stored in one piece");
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
        return pen_sqlite_damaged(store, st, "the store %s is damaged (%s)", store->path,
                                  sqlite3_errmsg(store->db));
    case SQLITE_FULL:
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
    case SQLITE_NOMEM:
        return pen_sqlite_io_error(store, rc, error, st);
    case SQLITE_READONLY:
    case SQLITE_PERM:
        return pen_sqlite_io_error(store, rc, 0, st);
    default:
        return pen_fail(st, PEN_INTERNAL, "the store %s failed: %s", store->path,
                        sqlite3_errmsg(store->db));
    }
}

bool pen_sqlite_pragma(struct pen_sqlite_store *store, const char *sql, int64_t *value,
                       struct pen_status *st)
{
    sqlite3_stmt *stmt = NULL;
    int rc = sqlite3_prepare_v2(store->db, sql, -1, &stmt, NULL);
    if (rc == SQLITE_OK)
        rc = sqlite3_step(stmt);
    if (rc == SQLITE_ROW)
        *value = sqlite3_column_int64(stmt, 0);
    bool ok = rc == SQLITE_ROW || pen_sqlite_error(store, rc, st);
    sqlite3_finalize(stmt);
    return ok;
}

bool pen_sqlite_exec(struct pen_sqlite_store *store, const char *sql, struct pen_status *st)
{
    int rc = sqlite3_exec(store->db, sql, NULL, NULL, NULL);
    return rc == SQLITE_OK || pen_sqlite_error(store, rc, st);
}

bool pen_sqlite_prepare(struct pen_sqlite_store *store, struct pen_status *st)
{
    static const enum pen_sqlite_sql always[] = {SQL_BEGIN_READ, SQL_BEGIN_WRITE, SQL_COMMIT,
                                                 SQL_ROLLBACK};
    for (size_t i = 0; i < sizeof always / sizeof always[0]; i++) {
        struct pen_sqlite_query query = pen_sqlite_query(store, always[i]);
        if (query.rc != SQLITE_OK)
            return pen_sqlite_error(store, query.rc, st);
    }
    return true;
}

static bool run_plain(struct pen_sqlite_store *store, enum pen_sqlite_sql sql,
                      struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, sql);
    return pen_sqlite_run(&query, st);
}

/* Some failures have ended the transaction already. One that cannot be rolled back, for lack of
 * memory, ends when the handle is reopened. */
static void roll_back(struct pen_sqlite_store *store)
{
    struct pen_status ignored;
    if (!sqlite3_get_autocommit(store->db))
        run_plain(store, SQL_ROLLBACK, &ignored);
    if (!sqlite3_get_autocommit(store->db))
        store->base.closed = true;
}

/* Fails inside another transaction, and leaves that one open. */
static bool begin(struct pen_sqlite_store *store, enum pen_sqlite_sql sql, struct pen_status *st)
{
    bool outermost = sqlite3_get_autocommit(store->db);
    if (run_plain(store, sql, st))
        return true;
    if (outermost)
        roll_back(store);
    return false;
}

bool pen_sqlite_lost_name(const struct pen_sqlite_store *store, const char *ending,
                          struct pen_status *st)
{
    return pen_fail(st, PEN_STORAGE,
                    "the file %s%s was moved or removed while it was in use; put it back, or stop "
                    "Penumbra",
                    store->path, ending);
}

/* Checks that the store and the files beside it still have their names. Without one a file ends
 * with the process, and so does everything written to it; other processes would make another -shm.
 * What a log without a name has is copied into the store. */
static bool has_name(struct pen_sqlite_store *store, struct pen_status *st)
{
    int moved = 0;
    sqlite3_file_control(store->db, "main", SQLITE_FCNTL_HAS_MOVED, &moved);
    const char *lost = moved ? "" : pen_sqlite_lost_beside(store);
    if (!lost)
        return true;
    if (strcmp(lost, pen_sqlite_beside[PEN_SQLITE_LOG]) == 0)
        sqlite3_wal_checkpoint_v2(store->db, "main", SQLITE_CHECKPOINT_PASSIVE, NULL, NULL);
    note_fault(store, PEN_FAULT_IO, ENOENT);
    return pen_sqlite_lost_name(store, lost, st);
}

bool pen_sqlite_begin_read(struct pen_driver *driver, struct pen_status *st)
{
    return begin(pen_sqlite_of(driver), SQL_BEGIN_READ, st);
}

bool pen_sqlite_begin_write(struct pen_driver *driver, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    driver->outcome_unknown = false;
    if (!has_name(store, st) || !begin(store, SQL_BEGIN_WRITE, st))
        return false;
    if (pen_sqlite_index_keep_ahead(store, st))
        return true;
    roll_back(store);
    return false;
}

/* If the log could not be written or synced, a later recovery may find the transaction in it. */
bool pen_sqlite_commit(struct pen_driver *driver, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    unsigned faults = driver->faults;
    driver->faults = 0;
    store->commits = true;
    bool ok = run_plain(store, SQL_COMMIT, st);
    store->commits = false;
    driver->outcome_unknown = !ok && (driver->faults >> PEN_FAULT_IO & 1);
    driver->faults |= faults;
    if (!ok)
        return false;
    driver->transactions++;
    pen_sqlite_keep_log_limits(store);
    return true;
}

void pen_sqlite_rollback(struct pen_driver *driver)
{
    roll_back(pen_sqlite_of(driver));
}
