/* SPDX-License-Identifier: MIT */
/* What a store knows about itself, and whether the files beside it belong to it.
 *
 * Rows of the table meta
 *   identity   32 hexadecimal digits, random, made with the store. A backup gets one of its own.
 *   log        1: the file is complete only together with its log, the file ending in -wal. That is
 *              so from the first opening on. 0: it is complete by itself, as a new store, a backup,
 *              and a store after pen_store_settle are.
 *
 * The file ending in -wake keeps the identity, too. So these cases are told apart before anything
 * is written:
 *  - No store, and no trace of one: a new store may be made.
 *  - No store, but its identity or its log is there: the store was moved away or removed.
 *  - A store whose row `log` is 1, without its log: the changes since the last checkpoint are gone.
 *    A handle never removes the log (SQLITE_FCNTL_PERSIST_WAL), so someone else did.
 *  - A store with another identity than the -wake file has, and a log with content: the log belongs
 *    to the store that was here before. SQLite would apply it to this one.
 *
 * Handles share what the log has through the file ending in -shm. One that was opened with another
 * such file than the others would write over their part of the log. So while the store is in use,
 * that file must be the one which the -wake file has noted.
 *
 * Not noticed: a log that was emptied, which looks like one after a checkpoint; a log that was cut,
 * which looks like one whose last writes a crash has undone, so that the jobs in them are lost; a
 * store that was replaced by an older copy of itself with its log. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "base/clock.h"
#include "base/log.h"
#include "store/sqlite/sqlite.h"
#include "store/sqlite/wake.h"

/* How long a process that has ended may take until its handles are gone. */
static const int64_t leaving_ns = 2 * INT64_C(1000000000);

/* What the file says without its log. */
struct facts {
    char identity[PEN_STORE_IDENTITY_BYTES]; /* "": none, as before schema 12 */
    bool needs_log;
};

/* The URI of the file, for reading it without its log and without making one. */
static char *plain_uri(const char *path)
{
    struct pen_buf uri = {0};
    pen_buf_puts(&uri, "file:");
    for (; *path; path++)
        pen_buf_printf(&uri, strchr("%?#", *path) ? "%%%02x" : "%c", (unsigned char)*path);
    pen_buf_puts(&uri, "?immutable=1");
    if (!uri.failed)
        return (char *)uri.data;
    pen_buf_release(&uri);
    return NULL;
}

/* Reads the file as it is without its log. A file that cannot be read so says nothing; opening it
 * properly tells why. */
static void read_facts(const struct pen_sqlite_store *store, struct facts *facts)
{
    sqlite3 *db = NULL;
    sqlite3_stmt *stmt = NULL;
    char *uri = plain_uri(store->path);
    *facts = (struct facts){0};
    if (uri &&
        sqlite3_open_v2(uri, &db, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX,
                        NULL) == SQLITE_OK &&
        sqlite3_prepare_v2(db, "SELECT name, value FROM meta", -1, &stmt, NULL) == SQLITE_OK) {
        while (sqlite3_step(stmt) == SQLITE_ROW) {
            const char *name = (const char *)sqlite3_column_text(stmt, 0);
            if (name && strcmp(name, "log") == 0)
                facts->needs_log = sqlite3_column_int(stmt, 1) != 0;
            else if (name && strcmp(name, "identity") == 0)
                snprintf(facts->identity, sizeof facts->identity, "%s",
                         (const char *)sqlite3_column_text(stmt, 1));
        }
    }
    sqlite3_finalize(stmt);
    sqlite3_close(db);
    free(uri);
}

bool pen_sqlite_may_make(const struct pen_sqlite_store *store, struct pen_status *st)
{
    if (store->wanted && !*store->wanted)
        return pen_fail(st, PEN_NOT_FOUND,
                        "there is no store %s, and only a penumbrad without --role makes one",
                        store->path);
    if (store->wanted)
        return pen_fail(st, PEN_STORAGE,
                        "the store %s is gone, and no new one is made in its place while Penumbra "
                        "runs: put it back, or stop Penumbra",
                        store->path);
    bool known = store->wake && pen_wake_identity(store->wake)[0];
    int64_t log;
    pen_sqlite_file_bytes(store, "-wal", &log);
    if (!known && log == 0)
        return true;
    return pen_fail(st, PEN_STORAGE,
                    "the store %s is missing, but its file ending in %s is there: put the store "
                    "back, or restore a backup. To begin anew, remove the files whose names begin "
                    "with the store's",
                    store->path, known ? "-wake" : "-wal");
}

/* Whether the handle will share its -shm file with the others that use the store, if there are any.
 */
static bool shares_shm(const struct pen_sqlite_store *store)
{
    char path[PEN_SQLITE_PATH_BYTES];
    struct stat info;
    if (!store->wake || !pen_wake_has_others(store->wake))
        return true;
    pen_sqlite_path(store, "-shm", path);
    return stat(path, &info) == 0 && pen_wake_is_shm(store->wake, &info);
}

/* Waits for handles that use another -shm file to be gone. That of a process that was killed stays
 * for a moment after the process is listed as a zombie: until its last thread has given back its
 * memory. */
static bool check_shm(const struct pen_sqlite_store *store, struct pen_status *st)
{
    const struct timespec pause = {.tv_nsec = 5000000};
    const int64_t until = pen_clock_ns() + leaving_ns;
    while (!shares_shm(store)) {
        if (pen_clock_ns() >= until)
            return pen_sqlite_lost_name(store, "-shm", st);
        nanosleep(&pause, NULL);
    }
    return true;
}

bool pen_sqlite_check_company(struct pen_sqlite_store *store, struct pen_status *st)
{
    struct facts facts;
    int64_t log;
    if (!check_shm(store, st))
        return false;
    const bool has_log = pen_sqlite_file_bytes(store, "-wal", &log);
    read_facts(store, &facts);
    if (facts.needs_log && !has_log)
        return pen_fail(st, PEN_STORAGE,
                        "%s-wal, the log of the store's last changes, is missing: put it back, or "
                        "restore a backup. To go on without these changes, make an empty file of "
                        "that name",
                        store->path);
    const char *known = store->wake ? pen_wake_identity(store->wake) : "";
    if (facts.identity[0] && known[0] && log > 0 && strcmp(facts.identity, known) != 0)
        return pen_fail(st, PEN_STORAGE,
                        "%s-wal seems to be the log of another store than %s, which was put in its "
                        "place: put the other one back, or remove the files ending in -wal, -shm "
                        "and -wake; if the log does belong to this store, remove the one ending in "
                        "-wake only",
                        store->path, store->path);
    store->says_log = facts.needs_log;
    return true;
}

static bool get_meta(struct pen_sqlite_store *store, const char *name, char *text, size_t bytes,
                     struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_META_GET);
    bool row;
    pen_sqlite_text(&query, name);
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    const char *value = row ? pen_sqlite_column_text(&query, 0) : NULL;
    snprintf(text, bytes, "%s", value ? value : "");
    pen_sqlite_end(&query);
    return value || pen_sqlite_damaged(store, st, "the store %s is damaged (it has no %s)",
                                       store->path, name);
}

/* Sets whether the file needs its log, and takes care that the file itself says so. */
static bool set_needs_log(struct pen_sqlite_store *store, bool needs, struct pen_status *st)
{
    if (!pen_sqlite_begin_write(&store->base, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_META_PUT);
    pen_sqlite_text(&query, "log");
    pen_sqlite_int(&query, needs);
    if (!pen_sqlite_run(&query, st) || !pen_sqlite_commit(&store->base, st)) {
        pen_sqlite_rollback(&store->base);
        return false;
    }
    return pen_sqlite_checkpoint(&store->base, st);
}

/* Takes care that the file says that it needs its log. It may not do so although the row is set: a
 * process may have been killed before the row was copied from the log. The disk may be full, and so
 * the reserve is used, without which no job could be removed. */
static bool say_log(struct pen_sqlite_store *store, bool is_set, struct pen_status *st)
{
    if (is_set && store->says_log)
        return true;
    for (;;) {
        if (is_set ? pen_sqlite_checkpoint(&store->base, st) : set_needs_log(store, true, st))
            return true;
        if (st->code != PEN_STORAGE_FULL || !pen_sqlite_reserve_move(&store->base))
            return false;
        pen_log(PEN_LOG_WARN, "the disk of the store %s is full: its reserve is used to open it",
                store->path);
    }
}

bool pen_sqlite_join_company(struct pen_sqlite_store *store, struct pen_status *st)
{
    char log[8], *known = pen_wake_identity(store->wake);
    if (!get_meta(store, "identity", store->identity, sizeof store->identity, st) ||
        !get_meta(store, "log", log, sizeof log, st))
        return false;
    if (store->wanted && *store->wanted && strcmp(store->wanted, store->identity) != 0)
        return pen_fail(st, PEN_STORAGE,
                        "another store was put in the place of %s while it was in use: put the "
                        "first one back, or stop Penumbra",
                        store->path);
    if (known[0] && strcmp(known, store->identity) != 0)
        pen_log(PEN_LOG_WARN, "the store %s is another one than before", store->path);
    pen_wake_set_identity(store->wake, store->identity);
    return say_log(store, log[0] != '0', st);
}

/* A handle that writes after the store was settled would leave a log of which the file says
 * nothing. So there must be none; one that is opened afterwards says it again. */
bool pen_sqlite_settle(struct pen_driver *driver, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    int lock = -1;
    bool ok = true;
    const bool locked = pen_wake_try_lock(store->wake, &lock);
    if (locked && pen_wake_be_alone(store->wake)) {
        ok = set_needs_log(store, false, st);
        if (ok)
            pen_sqlite_truncate_log(store);
        pen_wake_end_alone(store->wake);
    } else
        pen_log(PEN_LOG_INFO,
                "another program may use the store %s, which therefore needs its log, %s-wal",
                store->path, store->path);
    if (locked)
        pen_wake_unlock(lock);
    return ok;
}

const char *pen_sqlite_identity(struct pen_driver *driver)
{
    return pen_sqlite_of(driver)->identity;
}

bool pen_sqlite_make_independent(sqlite3 *db)
{
    sqlite3_stmt *stmt = NULL;
    bool any = sqlite3_prepare_v2(db, "SELECT 1 FROM meta", -1, &stmt, NULL) == SQLITE_OK;
    sqlite3_finalize(stmt);
    return !any || sqlite3_exec(db,
                                "UPDATE meta SET value = 0 WHERE name = 'log';"
                                "UPDATE meta SET value = lower(hex(randomblob(16)))"
                                " WHERE name = 'identity'",
                                NULL, NULL, NULL) == SQLITE_OK;
}

const char *const pen_sqlite_beside[PEN_SQLITE_BESIDE] = {
    [PEN_SQLITE_LOG] = "-wal", [PEN_SQLITE_SHM] = "-shm"};

void pen_sqlite_note_beside(struct pen_sqlite_store *store)
{
    char path[PEN_SQLITE_PATH_BYTES];
    for (int i = 0; i < PEN_SQLITE_BESIDE; i++) {
        pen_sqlite_path(store, pen_sqlite_beside[i], path);
        store->has_beside[i] = stat(path, &store->beside[i]) == 0;
    }
    if (store->has_beside[PEN_SQLITE_SHM])
        pen_wake_note_shm(store->wake, &store->beside[PEN_SQLITE_SHM]);
}

const char *pen_sqlite_lost_beside(const struct pen_sqlite_store *store)
{
    char path[PEN_SQLITE_PATH_BYTES];
    struct stat now;
    for (int i = 0; i < PEN_SQLITE_BESIDE; i++) {
        pen_sqlite_path(store, pen_sqlite_beside[i], path);
        if (store->has_beside[i] &&
            !(stat(path, &now) == 0 && pen_sqlite_same_file(&now, &store->beside[i])))
            return pen_sqlite_beside[i];
    }
    return NULL;
}
