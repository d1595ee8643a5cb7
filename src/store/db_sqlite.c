/* SPDX-License-Identifier: MIT */
/* A connection to SQLite (db.h). The database has a write-ahead log. Its application id says that
 * it is a store of Penumbra, and its user version is the schema's version. db_sqlite_open.c opens
 * it. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "base/clock.h"
#include "store/internal/signals.h"
#include "store/internal/sqlite.h"

enum {
    TEXT_BYTES = 8192,
    LOG_BYTES = 32 << 20, /* a longer log is emptied, even if it must wait for readers */
    PATIENCE_MS = 50,
    INDEX_BYTES = 32 << 10 /* the step by which SQLite lengthens the log's index */
};

static struct pen_sqlite *of(struct pen_db *db)
{
    return (struct pen_sqlite *)db;
}

/* SQLite does not report why it cannot lengthen the log's index. */
static bool is_disk_full(const struct pen_sqlite *db)
{
    struct statvfs info;
    return statvfs(db->path, &info) == 0 &&
           (int64_t)info.f_bavail * (int64_t)info.f_frsize < INDEX_BYTES;
}

bool pen_sqlite_fail(struct pen_sqlite *db, int rc, struct pen_status *st)
{
    const char *why = sqlite3_errmsg(db->sqlite);
    enum pen_code code;
    if (rc == SQLITE_IOERR_SHMSIZE && is_disk_full(db))
        rc = SQLITE_FULL;
    switch (rc & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        code = PEN_UNAVAILABLE;
        break;
    case SQLITE_FULL:
        code = PEN_STORAGE_FULL;
        break;
    case SQLITE_NOMEM:
        code = PEN_NO_MEMORY;
        break;
    case SQLITE_IOERR:
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_CANTOPEN:
    case SQLITE_READONLY:
    case SQLITE_PERM:
        code = PEN_STORAGE;
        /* The next process recovers from the log. */
        sqlite3_db_config(db->sqlite, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, NULL);
        break;
    default:
        code = PEN_INTERNAL;
    }
    db->base.trouble = (struct pen_db_trouble){
        .code = code,
        .failure =
            code == PEN_STORAGE || code == PEN_INTERNAL ? PEN_FAILURE_REFUSED : PEN_FAILURE_RETRY};
    pen_fail(st, code, "%s%s: %s (SQLite error %d)", db->path,
             (rc & 0xff) == SQLITE_CORRUPT  ? " is damaged"
             : (rc & 0xff) == SQLITE_NOTADB ? " is not a Penumbra store, or is damaged"
                                            : "",
             why, rc);
    if (code == PEN_STORAGE && db->base.broken.code == PEN_OK)
        db->base.broken = *st;
    return pen_db_failed(&db->base, st);
}

bool pen_sqlite_exec(struct pen_sqlite *db, const char *sql, struct pen_status *st)
{
    const int rc = sqlite3_exec(db->sqlite, sql, NULL, NULL, NULL);
    return rc == SQLITE_OK || pen_sqlite_fail(db, rc, st);
}

/* Unless SQLite has done it. */
static void roll_back(struct pen_sqlite *db)
{
    if (sqlite3_get_autocommit(db->sqlite))
        return;
    sqlite3_step(db->rollback);
    sqlite3_reset(db->rollback);
}

static bool begin(struct pen_db *base, enum pen_db_access access, struct pen_status *st)
{
    struct pen_sqlite *db = of(base);
    if (access != PEN_DB_READ && db->syncs != (access == PEN_DB_WRITE)) {
        db->syncs = access == PEN_DB_WRITE;
        if (!pen_sqlite_exec(
                db, db->syncs ? "PRAGMA synchronous=FULL" : "PRAGMA synchronous=NORMAL", st))
            return false;
    }
    return pen_sqlite_exec(db, access == PEN_DB_READ ? "BEGIN" : "BEGIN IMMEDIATE", st);
}

static void reset_all(struct pen_sqlite *db)
{
    for (sqlite3_stmt *stmt = sqlite3_next_stmt(db->sqlite, NULL); stmt;
         stmt = sqlite3_next_stmt(db->sqlite, stmt)) {
        if (sqlite3_stmt_busy(stmt))
            sqlite3_reset(stmt);
    }
}

/* After an I/O error in a commit, it is not known whether the log has the transaction. */
static bool commit(struct pen_sqlite *db, struct pen_status *st)
{
    if (pen_sqlite_exec(db, "COMMIT", st))
        return true;
    if (db->base.trouble.code == PEN_STORAGE)
        db->base.trouble.failure = PEN_FAILURE_UNKNOWN;
    return false;
}

static bool end(struct pen_db *base, bool ok, struct pen_status *st)
{
    struct pen_sqlite *db = of(base);
    reset_all(db);
    ok = ok && commit(db, st);
    if (!ok)
        roll_back(db);
    return ok;
}

/* The text without the word for row locks, which SQLite does not need. */
static const char *plain(const char *sql, char text[TEXT_BYTES])
{
    static const char word[] = "{skip_locked}";
    const char *at = strstr(sql, word);
    size_t used = 0;
    if (!at)
        return sql;
    for (; at && used + strlen(sql) < TEXT_BYTES; at = strstr(sql, word)) {
        memcpy(text + used, sql, (size_t)(at - sql));
        used += (size_t)(at - sql);
        sql = at + sizeof word - 1;
    }
    strcpy(text + used, sql);
    return text;
}

/* The statement of a literal, prepared once. */
static struct pen_sqlite_rows *prepared(struct pen_sqlite *db, const char *sql,
                                        struct pen_status *st)
{
    const size_t first = ((uintptr_t)sql >> 4) % STATEMENTS;
    char text[TEXT_BYTES];
    for (size_t i = 0; i < STATEMENTS; i++) {
        struct pen_sqlite_rows *rows = &db->statements[(first + i) % STATEMENTS];
        if (rows->sql == sql)
            return rows;
        if (rows->sql)
            continue;
        const int rc = sqlite3_prepare_v3(db->sqlite, plain(sql, text), -1,
                                          SQLITE_PREPARE_PERSISTENT, &rows->stmt, NULL);
        if (rc != SQLITE_OK) {
            pen_sqlite_fail(db, rc, st);
            return NULL;
        }
        rows->sql = sql;
        return rows;
    }
    pen_fail(st, PEN_INTERNAL, "more than %d statements", STATEMENTS);
    return NULL;
}

/* Parameters are bound by name, because SQLite numbers them by their first appearance. */
static int bind(sqlite3_stmt *stmt, const char *types, va_list args)
{
    static const char *const names[] = {"$1", "$2",  "$3",  "$4",  "$5",  "$6",  "$7",  "$8",
                                        "$9", "$10", "$11", "$12", "$13", "$14", "$15", "$16"};
    int rc = SQLITE_OK;
    for (int i = 0; types[i] && rc == SQLITE_OK; i++) {
        const int at = sqlite3_bind_parameter_index(stmt, names[i]);
        const char type = types[i];
        if (type == 'i') {
            rc = sqlite3_bind_int64(stmt, at, va_arg(args, int64_t));
        } else if (type == 't') {
            rc = sqlite3_bind_text(stmt, at, va_arg(args, const char *), -1, SQLITE_STATIC);
        } else {
            const void *data = va_arg(args, const void *);
            const size_t bytes = va_arg(args, size_t);
            rc = sqlite3_bind_blob64(stmt, at, data, bytes, SQLITE_STATIC);
        }
    }
    return rc;
}

static struct pen_rows *start(struct pen_db *base, struct pen_status *st, bool waits,
                              const char *sql, const char *types, va_list args)
{
    struct pen_sqlite *db = of(base);
    struct pen_sqlite_rows *rows = prepared(db, sql, st);
    (void)waits;
    if (!rows)
        return NULL;
    sqlite3_reset(rows->stmt);
    sqlite3_clear_bindings(rows->stmt);
    rows->base = (struct pen_rows){.db = base, .st = st, .ok = true};
    const int rc = bind(rows->stmt, types, args);
    if (rc != SQLITE_OK) {
        pen_sqlite_fail(db, rc, st);
        return NULL;
    }
    return &rows->base;
}

static sqlite3_stmt *statement(const struct pen_rows *rows)
{
    return ((const struct pen_sqlite_rows *)rows)->stmt;
}

static bool next(struct pen_rows *rows)
{
    const int rc = sqlite3_step(statement(rows));
    if (rc != SQLITE_ROW && rc != SQLITE_DONE)
        rows->ok = pen_sqlite_fail(of(rows->db), rc, rows->st);
    return rc == SQLITE_ROW;
}

static bool done(struct pen_rows *rows)
{
    sqlite3_reset(statement(rows));
    return rows->ok;
}

static int64_t changed(struct pen_rows *rows)
{
    return sqlite3_changes64(of(rows->db)->sqlite);
}

static int64_t integer(struct pen_rows *rows, int column)
{
    return sqlite3_column_int64(statement(rows), column);
}

static const char *text(struct pen_rows *rows, int column)
{
    return (const char *)sqlite3_column_text(statement(rows), column);
}

static const void *bytes(struct pen_rows *rows, int column, size_t *size)
{
    const void *data = sqlite3_column_blob(statement(rows), column);
    *size = (size_t)sqlite3_column_bytes(statement(rows), column);
    return data;
}

static bool now(struct pen_db *db, int64_t *now_ms, struct pen_status *st)
{
    (void)st;
    *now_ms = db->now_ms ? db->now_ms(db->now_user) : pen_clock_wall_ms();
    return true;
}

static void wait_change(struct pen_db *db, uint32_t *seen, int timeout_ms)
{
    (void)db;
    pen_signals_wait(seen, timeout_ms);
}

static void wake(struct pen_db *db)
{
    (void)db;
    pen_signals_raise();
}

/* Reads the pages of the file, the free pages among them, and the free bytes of the disk. */
static bool read_space(struct pen_sqlite *db, int64_t *pages, int64_t *unused, int64_t *left,
                       struct pen_status *st)
{
    struct statvfs info;
    if (!pen_db_value(&db->base, st, pages, "PRAGMA page_count", "") ||
        !pen_db_value(&db->base, st, unused, "PRAGMA freelist_count", ""))
        return false;
    if (statvfs(db->path, &info) != 0)
        return pen_fail(st, PEN_STORAGE, "%s: its file system cannot be read", db->path);
    *left = (int64_t)info.f_bavail * (int64_t)info.f_frsize;
    return true;
}

static bool space(struct pen_db *db, int64_t *used, int64_t *left, struct pen_status *st)
{
    int64_t pages, unused;
    if (!read_space(of(db), &pages, &unused, left, st))
        return false;
    if (used)
        *used = (pages - unused) * PEN_SQLITE_PAGE;
    return true;
}

static bool give_reserve(struct pen_db *db)
{
    return unlink(of(db)->reserve) == 0;
}

/* Copies the log into the database and empties the log. This also gives free pages at the file's
 * end back. The copy blocks nobody. Emptying waits for readers, at most PATIENCE_MS, and writers
 * wait meanwhile. */
static bool empty_log(struct pen_sqlite *db, struct pen_status *st)
{
    int rc = sqlite3_wal_checkpoint_v2(db->sqlite, NULL, SQLITE_CHECKPOINT_PASSIVE, NULL, NULL);
    db->patience_ms = PATIENCE_MS;
    if (rc == SQLITE_OK)
        rc = sqlite3_wal_checkpoint_v2(db->sqlite, NULL, SQLITE_CHECKPOINT_TRUNCATE, NULL, NULL);
    db->patience_ms = PEN_SQLITE_BUSY_MS;
    return rc == SQLITE_OK || rc == SQLITE_BUSY || pen_sqlite_fail(db, rc, st);
}

static bool is_log_long(const struct pen_sqlite *db)
{
    char path[PEN_SQLITE_PATH_BYTES + 8];
    struct stat info;
    snprintf(path, sizeof path, "%s-wal", db->path);
    return stat(path, &info) == 0 && info.st_size > LOG_BYTES;
}

static bool maintain(struct pen_db *base, int64_t room, bool *more, struct pen_status *st)
{
    struct pen_sqlite *db = of(base);
    const int64_t most = room / PEN_SQLITE_PAGE;
    int64_t pages, unused, left = 0;
    char sql[64];
    if (!read_space(db, &pages, &unused, &left, st))
        return false;
    if (left >= PEN_RESERVE_FREE + PEN_RESERVE)
        pen_sqlite_make_reserve(db);
    sqlite3_snprintf(sizeof sql, sql, "PRAGMA incremental_vacuum(%lld)", (long long)most);
    if (unused > 0 && (!pen_db_begin(base, PEN_DB_WRITE, st) ||
                       !pen_db_end(base, pen_sqlite_exec(db, sql, st), st)))
        return false;
    *more = unused > most;
    return (unused == 0 || *more) && !is_log_long(db) ? true : empty_log(db, st);
}

static void close_file(struct pen_db *base)
{
    struct pen_sqlite *db = of(base);
    for (int i = 0; i < STATEMENTS; i++)
        sqlite3_finalize(db->statements[i].stmt);
    sqlite3_finalize(db->rollback);
    sqlite3_close(db->sqlite);
    free(db);
}

const struct pen_engine pen_sqlite_engine = {.close = close_file,
                                             .begin = begin,
                                             .end = end,
                                             .start = start,
                                             .next = next,
                                             .done = done,
                                             .changed = changed,
                                             .integer = integer,
                                             .text = text,
                                             .bytes = bytes,
                                             .now = now,
                                             .wait = wait_change,
                                             .wake = wake,
                                             .space = space,
                                             .give_reserve = give_reserve,
                                             .maintain = maintain,
                                             .check = pen_sqlite_check_store};
