/* SPDX-License-Identifier: MIT */
/* Opens, makes and checks SQLite databases (db.h). */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/buf.h"
#include "base/clock.h"
#include "base/embed.h"
#include "store/internal/schema.h"
#include "store/internal/sqlite.h"

enum {
    APPLICATION = 0x50454e55, /* "PENU" */
    BUSY_MS = 10000,
    BUSY_SLEEP_US = 1000, /* less than most transactions take */
    CHECK_STEPS = 1000    /* virtual machine steps between two looks at the clock */
};

static const struct {
    const char *word, *text;
} words[] = {{"{identity}", "INTEGER PRIMARY KEY AUTOINCREMENT"},
             {"{bytes}", "BLOB"},
             {"{table options}", ""}};

/* Waits for another writer in short sleeps, so that it is soon followed. */
static int wait_busy(void *user, int count)
{
    struct pen_db *db = user;
    const struct timespec pause = {.tv_nsec = BUSY_SLEEP_US * 1000};
    if (count == 0)
        db->busy_ns = pen_clock_ns();
    if (pen_clock_ns() - db->busy_ns > (int64_t)BUSY_MS * 1000000)
        return 0;
    nanosleep(&pause, NULL);
    return 1;
}

static void sql_now(sqlite3_context *context, int count, sqlite3_value **values)
{
    struct pen_status st;
    int64_t now_ms = 0;
    (void)count;
    (void)values;
    pen_db_now(sqlite3_user_data(context), &now_ms, &st);
    sqlite3_result_int64(context, now_ms);
}

static bool add_schema(struct pen_db *db, struct pen_status *st)
{
    struct pen_buf text = {0};
    const char *at = (const char *)pen_store_schema[0].data;
    while (*at) {
        size_t i = 0, n = sizeof words / sizeof *words;
        while (i < n && strncmp(at, words[i].word, strlen(words[i].word)) != 0)
            i++;
        if (i < n)
            pen_buf_puts(&text, words[i].text);
        else
            pen_buf_add(&text, at, 1);
        at += i < n ? strlen(words[i].word) : 1;
    }
    pen_buf_printf(&text, "PRAGMA application_id=%d; PRAGMA user_version=%d;", APPLICATION,
                   PEN_SCHEMA_VERSION);
    const bool ok = text.failed ? pen_fail(st, PEN_NO_MEMORY, "no memory for the store's tables")
                                : pen_sqlite_exec(db, (const char *)text.data, st);
    pen_buf_release(&text);
    return ok;
}

/* The version of the schema; 0: the file is empty. */
static bool read_version(struct pen_db *db, int64_t *version, struct pen_status *st)
{
    int64_t application, tables;
    if (!pen_sqlite_value(db, "PRAGMA application_id", &application, st) ||
        !pen_sqlite_value(db, "PRAGMA user_version", version, st) ||
        !pen_sqlite_value(db, "SELECT count(*) FROM sqlite_master", &tables, st))
        return false;
    if (application == 0 && tables == 0)
        return true;
    if (application != APPLICATION)
        return pen_fail(st, PEN_STORAGE, "%s is not a Penumbra store", db->path);
    return *version == PEN_SCHEMA_VERSION ||
           pen_fail(st, PEN_STORAGE,
                    "%s is a store of version %lld; this build reads version %d alone", db->path,
                    (long long)*version, PEN_SCHEMA_VERSION);
}

/* Another process may make the tables at the same time. */
static bool make_tables(struct pen_db *db, struct pen_status *st)
{
    int64_t version;
    return pen_sqlite_exec(db,
                           "PRAGMA page_size=8192; PRAGMA auto_vacuum=INCREMENTAL; "
                           "PRAGMA journal_mode=WAL",
                           st) &&
           pen_db_begin(db, PEN_DB_WRITE, st) &&
           pen_db_end(db, read_version(db, &version, st) && (version != 0 || add_schema(db, st)),
                      st);
}

static bool make_folders(const char *path, struct pen_status *st)
{
    char folder[PEN_SQLITE_PATH_BYTES];
    strcpy(folder, path);
    for (char *at = strchr(folder + 1, '/'); at; at = strchr(at + 1, '/')) {
        *at = '\0';
        if (mkdir(folder, 0700) != 0 && errno != EEXIST)
            return pen_fail(st, PEN_STORAGE, "%s cannot be made: %s", folder, strerror(errno));
        *at = '/';
    }
    return true;
}

/* What is not there is made, with this user's permissions alone. */
static bool find_file(const char *path, bool make, struct pen_status *st)
{
    if (make && !make_folders(path, st))
        return false;
    const int fd = open(path, O_RDWR | O_CLOEXEC | (make ? O_CREAT : 0), 0600);
    if (fd < 0)
        return errno == ENOENT ? pen_fail(st, PEN_NOT_FOUND, "%s: there is no store", path)
                               : pen_fail(st, errno == ENOSPC ? PEN_STORAGE_FULL : PEN_STORAGE,
                                          "%s cannot be opened: %s", path, strerror(errno));
    close(fd);
    return true;
}

static bool open_file(struct pen_db *db, bool make, struct pen_status *st)
{
    int64_t version;
    const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
    int rc = sqlite3_open_v2(db->path, &db->sqlite, flags, NULL);
    if (rc == SQLITE_OK)
        rc = sqlite3_busy_handler(db->sqlite, wait_busy, db);
    if (rc == SQLITE_OK)
        rc = sqlite3_create_function_v2(db->sqlite, "now_ms", 0, SQLITE_UTF8 | SQLITE_INNOCUOUS, db,
                                        sql_now, NULL, NULL, NULL);
    if (rc != SQLITE_OK)
        return pen_sqlite_fail(db, rc, st);
    if (!read_version(db, &version, st))
        return false;
    if (version == 0 && !make)
        return pen_fail(st, PEN_STORAGE, "%s is not a Penumbra store", db->path);
    db->syncs = true;
    return (version != 0 || make_tables(db, st)) &&
           pen_sqlite_exec(db,
                           "PRAGMA synchronous=FULL; PRAGMA journal_size_limit=67108864; "
                           "PRAGMA temp_store=MEMORY; PRAGMA cache_size=-8192",
                           st);
}

struct pen_db *pen_db_open(const char *url, bool make, struct pen_status *st)
{
    if (strncmp(url, "postgres://", 11) == 0 || strncmp(url, "postgresql://", 13) == 0) {
        pen_fail(st, PEN_UNSUPPORTED, "a store in PostgreSQL is not supported yet");
        return NULL;
    }
    if (!*url || strlen(url) > PEN_SQLITE_PATH_BYTES - 16) {
        pen_fail(st, PEN_USAGE, "the path of the store is %s", *url ? "too long" : "empty");
        return NULL;
    }
    if (!find_file(url, make, st))
        return NULL;
    struct pen_db *db = calloc(1, sizeof *db);
    if (!db) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for a store");
        return NULL;
    }
    snprintf(db->path, sizeof db->path, "%s", url);
    snprintf(db->reserve, sizeof db->reserve, "%.*s-reserve", PEN_SQLITE_PATH_BYTES - 16, url);
    if (!open_file(db, make, st)) {
        pen_db_close(db);
        return NULL;
    }
    return db;
}

void pen_db_close(struct pen_db *db)
{
    if (!db)
        return;
    for (int i = 0; i < STATEMENTS; i++)
        sqlite3_finalize(db->statements[i].stmt);
    sqlite3_close(db->sqlite);
    free(db);
}

void pen_sqlite_make_reserve(struct pen_db *db)
{
    struct stat info;
    if (stat(db->reserve, &info) == 0 && info.st_size == PEN_RESERVE)
        return;
    const int fd = open(db->reserve, O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (fd < 0)
        return;
    if (posix_fallocate(fd, 0, PEN_RESERVE) != 0)
        unlink(db->reserve);
    close(fd);
}

static int past_limit(void *user)
{
    const int64_t *until_ns = user;
    return pen_clock_ns() >= *until_ns;
}

bool pen_db_check(struct pen_db *db, int limit_ms, bool *finished, struct pen_status *st)
{
    int64_t until_ns = pen_clock_ns() + (int64_t)limit_ms * 1000000;
    sqlite3_stmt *stmt = NULL;
    int rc = sqlite3_prepare_v2(db->sqlite, "PRAGMA quick_check(1)", -1, &stmt, NULL);
    if (limit_ms > 0)
        sqlite3_progress_handler(db->sqlite, CHECK_STEPS, past_limit, &until_ns);
    if (rc == SQLITE_OK)
        rc = sqlite3_step(stmt);
    sqlite3_progress_handler(db->sqlite, 0, NULL, NULL);
    *finished = rc != SQLITE_INTERRUPT;
    bool ok = rc == SQLITE_ROW || !*finished || pen_sqlite_fail(db, rc, st);
    if (rc == SQLITE_ROW && strcmp((const char *)sqlite3_column_text(stmt, 0), "ok") != 0) {
        ok = pen_fail(st, PEN_STORAGE, "%s is damaged: %s; restore a backup", db->path,
                      (const char *)sqlite3_column_text(stmt, 0));
        db->trouble = (struct pen_db_trouble){PEN_STORAGE, PEN_FAILURE_REFUSED};
        db->broken = *st;
    }
    sqlite3_finalize(stmt);
    return ok;
}
