/* SPDX-License-Identifier: MIT */
/* Opens, makes and checks SQLite databases (db.h). */
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
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
    BUSY_SLEEP_US = 1000      /* shorter than most transactions */
};

static const struct pen_word words[] = {{"{identity}", "INTEGER PRIMARY KEY AUTOINCREMENT"},
                                        {"{bytes}", "BLOB"},
                                        {"{table options}", "WITHOUT ROWID"},
                                        {NULL, NULL}};

/* Waits for another writer in short sleeps, so that this process soon gets its turn. */
static int wait_busy(void *user, int count)
{
    struct pen_sqlite *db = user;
    const struct timespec pause = {.tv_nsec = BUSY_SLEEP_US * 1000};
    if (count == 0)
        db->busy_ns = pen_clock_ns();
    if (pen_clock_ns() - db->busy_ns > db->patience_ms * 1000000)
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

static bool add_schema(struct pen_sqlite *db, struct pen_status *st)
{
    struct pen_buf text = {0};
    pen_schema_write(words, &text);
    pen_buf_printf(&text, "PRAGMA application_id=%d; PRAGMA user_version=%d;", APPLICATION,
                   PEN_SCHEMA_VERSION);
    const bool ok = text.failed ? pen_fail(st, PEN_NO_MEMORY, "no memory for the store's tables")
                                : pen_sqlite_exec(db, (const char *)text.data, st);
    pen_buf_release(&text);
    return ok;
}

static bool check_version(struct pen_sqlite *db, struct pen_status *st)
{
    int64_t application, version;
    if (!pen_db_value(&db->base, st, &application, "PRAGMA application_id", "") ||
        !pen_db_value(&db->base, st, &version, "PRAGMA user_version", ""))
        return false;
    if (application != APPLICATION)
        return pen_fail(st, PEN_STORAGE, "%s is not a Penumbra store", db->path);
    return version == PEN_SCHEMA_VERSION ||
           pen_fail(st, PEN_STORAGE,
                    "%s is a store of version %lld; this build reads version %d alone", db->path,
                    (long long)version, PEN_SCHEMA_VERSION);
}

/* The log is turned on last, so that until then the file alone is the store. */
static bool make_tables(struct pen_sqlite *db, struct pen_status *st)
{
    char sql[128];
    sqlite3_snprintf(sizeof sql, sql, "PRAGMA page_size=%d; PRAGMA auto_vacuum=INCREMENTAL",
                     PEN_SQLITE_PAGE);
    return pen_sqlite_exec(db, sql, st) && pen_db_begin(&db->base, PEN_DB_WRITE, st) &&
           pen_db_end(&db->base, add_schema(db, st), st) &&
           pen_sqlite_exec(db, "PRAGMA journal_mode=WAL", st);
}

static bool open_file(struct pen_sqlite *db, int flags, struct pen_status *st)
{
    int rc = sqlite3_open_v2(db->path, &db->sqlite,
                             flags | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE, NULL);
    if (rc == SQLITE_OK)
        rc = sqlite3_busy_handler(db->sqlite, wait_busy, db);
    if (rc == SQLITE_OK)
        rc = sqlite3_create_function_v2(db->sqlite, "now_ms", 0, SQLITE_UTF8 | SQLITE_INNOCUOUS, db,
                                        sql_now, NULL, NULL, NULL);
    if (rc == SQLITE_OK)
        rc = sqlite3_prepare_v3(db->sqlite, "ROLLBACK", -1, SQLITE_PREPARE_PERSISTENT,
                                &db->rollback, NULL);
    if (rc != SQLITE_OK)
        return pen_sqlite_fail(db, rc, st);
    db->syncs = true;
    return pen_sqlite_exec(db,
                           "PRAGMA synchronous=FULL; PRAGMA journal_size_limit=67108864; "
                           "PRAGMA temp_store=MEMORY; PRAGMA cache_size=-8192",
                           st);
}

static void name_reserve(const char *path, char reserve[PEN_SQLITE_PATH_BYTES])
{
    snprintf(reserve, PEN_SQLITE_PATH_BYTES, "%.*s-reserve", PEN_SQLITE_PATH_BYTES - 16, path);
}

static struct pen_sqlite *open_path(const char *path, int flags, struct pen_status *st)
{
    struct pen_sqlite *db = calloc(1, sizeof *db);
    if (!db) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for a store");
        return NULL;
    }
    snprintf(db->path, sizeof db->path, "%s", path);
    name_reserve(path, db->reserve);
    db->base.engine = &pen_sqlite_engine;
    db->patience_ms = PEN_SQLITE_BUSY_MS;
    if (open_file(db, flags, st))
        return db;
    pen_db_close(&db->base);
    return NULL;
}

static bool cannot_make(const char *path, struct pen_status *st)
{
    return pen_fail(st, errno == ENOSPC || errno == EDQUOT ? PEN_STORAGE_FULL : PEN_STORAGE,
                    "%s cannot be made: %s", path, strerror(errno));
}

static bool make_folders(const char *path, struct pen_status *st)
{
    char folder[PEN_SQLITE_PATH_BYTES];
    strcpy(folder, path);
    for (char *at = strchr(folder + 1, '/'); at; at = strchr(at + 1, '/')) {
        *at = '\0';
        if (mkdir(folder, 0700) != 0 && errno != EEXIST)
            return cannot_make(folder, st);
        *at = '/';
    }
    return true;
}

/* Makes a whole store under another name, then renames it. If another process is faster, its store
 * stays. */
static bool make_store(const char *path, struct pen_status *st)
{
    char part[PEN_SQLITE_PATH_BYTES + 8];
    snprintf(part, PEN_SQLITE_PATH_BYTES, "%.*s.new-XXXXXX", PEN_SQLITE_PATH_BYTES - 16, path);
    if (!make_folders(path, st))
        return false;
    const int fd = mkostemp(part, O_CLOEXEC); /* mode 0600 */
    if (fd < 0)
        return cannot_make(path, st);
    close(fd);
    struct pen_sqlite *db = open_path(part, SQLITE_OPEN_READWRITE, st);
    bool ok = db && make_tables(db, st);
    if (db)
        pen_db_close(&db->base);
    if (ok && link(part, path) != 0 && errno != EEXIST)
        ok = cannot_make(path, st);
    unlink(part);
    unlink(strcat(part, "-journal")); /* of a disk that failed */
    return ok && (pen_sqlite_sync_folder(path) || cannot_make(path, st));
}

bool pen_sqlite_sync_folder(const char *path)
{
    char folder[PEN_SQLITE_PATH_BYTES];
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1,
             slash ? path : ".");
    const int fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const bool ok = fd >= 0 && fsync(fd) == 0;
    const int error = errno;
    if (fd >= 0)
        close(fd);
    errno = error;
    return ok;
}

static struct pen_sqlite *open_checked(const char *path, bool writes, struct pen_status *st)
{
    struct pen_sqlite *db =
        open_path(path, writes ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY, st);
    if (!db || check_version(db, st))
        return db;
    pen_db_close(&db->base);
    return NULL;
}

/* Only SQLite opens a store, because closing a descriptor of the file drops the locks of this
 * process. On a full disk, the reserve is removed, so that SQLite can make the log's index. */
struct pen_sqlite *pen_sqlite_open_file(const char *path, bool writes, struct pen_status *st)
{
    char reserve[PEN_SQLITE_PATH_BYTES];
    struct stat info;
    if (access(path, writes ? R_OK | W_OK : R_OK) != 0) {
        if (errno == ENOENT)
            pen_fail(st, PEN_NOT_FOUND, "%s: there is no store", path);
        else
            pen_fail(st, PEN_STORAGE, "%s cannot be opened: %s", path, strerror(errno));
        return NULL;
    }
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode)) {
        pen_fail(st, PEN_STORAGE, "%s is not a file", path);
        return NULL;
    }
    struct pen_sqlite *db = open_checked(path, writes, st);
    name_reserve(path, reserve);
    return !db && writes && st->code == PEN_STORAGE_FULL && unlink(reserve) == 0
               ? open_checked(path, writes, st)
               : db;
}

struct pen_db *pen_sqlite_open(const char *path, bool make, struct pen_status *st)
{
    struct pen_sqlite *db = NULL;
    if (!*path || strlen(path) > PEN_SQLITE_PATH_BYTES - 16)
        pen_fail(st, PEN_USAGE, "the path of the store is %s", *path ? "too long" : "empty");
    else if (!make || access(path, F_OK) == 0 || errno != ENOENT || make_store(path, st))
        db = pen_sqlite_open_file(path, true, st);
    return db ? &db->base : NULL;
}

void pen_sqlite_make_reserve(struct pen_sqlite *db)
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

/* The check of a large table is a single step for SQLite, so another thread interrupts it. */
struct limit {
    sqlite3 *sqlite;
    struct timespec until;
    sem_t ended;
};

static void *interrupt_late(void *user)
{
    struct limit *limit = user;
    int rc;
    do
        rc = sem_clockwait(&limit->ended, CLOCK_MONOTONIC, &limit->until);
    while (rc != 0 && errno == EINTR);
    if (rc != 0)
        sqlite3_interrupt(limit->sqlite);
    return NULL;
}

static int quick_check(sqlite3 *sqlite, char text[256])
{
    sqlite3_stmt *stmt = NULL;
    int rc = sqlite3_prepare_v2(sqlite, "PRAGMA quick_check(1)", -1, &stmt, NULL);
    if (rc == SQLITE_OK)
        rc = sqlite3_step(stmt);
    snprintf(text, 256, "%s",
             rc == SQLITE_ROW ? (const char *)sqlite3_column_text(stmt, 0)
                              : sqlite3_errmsg(sqlite));
    sqlite3_finalize(stmt);
    if (rc != SQLITE_ROW)
        return rc;
    return strcmp(text, "ok") == 0 ? SQLITE_OK : SQLITE_CORRUPT;
}

int pen_sqlite_check(sqlite3 *sqlite, int limit_ms, char text[256])
{
    struct limit limit = {.sqlite = sqlite, .until = pen_clock_after_ms(limit_ms)};
    pthread_t thread;
    if (limit_ms == 0)
        return quick_check(sqlite, text);
    sem_init(&limit.ended, 0, 0);
    if (pthread_create(&thread, NULL, interrupt_late, &limit) != 0)
        return SQLITE_NOMEM;
    const int rc = quick_check(sqlite, text);
    sem_post(&limit.ended);
    pthread_join(thread, NULL);
    sem_destroy(&limit.ended);
    return rc;
}

bool pen_sqlite_check_store(struct pen_db *base, int limit_ms, bool *finished,
                            struct pen_status *st)
{
    struct pen_sqlite *db = (struct pen_sqlite *)base;
    char text[256];
    const int rc = pen_sqlite_check(db->sqlite, limit_ms, text);
    *finished = rc != SQLITE_INTERRUPT;
    if (rc == SQLITE_OK || rc == SQLITE_INTERRUPT)
        return true;
    pen_sqlite_fail(db, rc, st);
    if (rc == SQLITE_CORRUPT) {
        pen_fail(st, PEN_STORAGE, "%s is damaged: %s", db->path, text);
        db->base.broken = *st;
    }
    return false;
}
