/* SPDX-License-Identifier: MIT */
/* Opening and closing. A file is touched only once it is known to be ours: its first bytes are
 * looked at before the first statement, which could already write. Handles of several processes
 * may open at the same time; making and migrating is done under a lock on the file of the wake-up
 * hints. The database file is read through SQLite's own descriptor: closing another one would
 * drop the POSIX locks that other handles of this process hold on the file. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "pen/base/clock.h"
#include "sqlite.h"
#include "wake.h"

enum { PATIENCE_MS = 5000, DOCUMENT_LEVEL = 1 /* of zstd: they are written once */ };

static void pen_sq_close(struct pen_store *base)
{
    struct pen_sq_store *store = pen_sq_of(base);
    for (int i = 0; i < SQ_COUNT; i++)
        sqlite3_finalize(store->stmt[i]);
    sqlite3_close(store->db);
    pen_packer_free(store->packer);
    pen_pixels_free(store->pixels);
    free(store->rgb);
    free(store->path);
    free(store);
}

static bool pen_sq_check(struct pen_store *base, struct pen_status *st)
{
    struct pen_sq_store *store = pen_sq_of(base);
    sqlite3_stmt *stmt = NULL;
    int rc = sqlite3_prepare_v2(store->db, "PRAGMA quick_check(1)", -1, &stmt, NULL);
    if (rc == SQLITE_OK)
        rc = sqlite3_step(stmt);
    bool ok = rc == SQLITE_ROW || pen_sq_error(store, rc, st);
    const char *verdict = ok ? (const char *)sqlite3_column_text(stmt, 0) : NULL;
    if (ok && (!verdict || strcmp(verdict, "ok") != 0))
        ok = pen_fail(st, PEN_STORAGE,
                      "the store %s is damaged (%s); nothing was changed: stop Penumbra and "
                      "restore a backup, or move the file away to begin anew",
                      store->path, verdict ? verdict : "no verdict");
    sqlite3_finalize(stmt);
    return ok;
}

static bool write_probe(struct pen_sq_store *store, void *arg, struct pen_status *st)
{
    (void)arg;
    struct pen_sq_query query = pen_sq_query(store, SQ_PROBE);
    pen_sq_int(&query, pen_clock_wall_ms());
    return pen_sq_run(&query, st);
}

static bool pen_sq_probe(struct pen_store *base, struct pen_status *st)
{
    return pen_sq_transaction(pen_sq_of(base), write_probe, NULL, st);
}

static const struct pen_store_ops ops = {
    .close = pen_sq_close,
    .check = pen_sq_check,
    .probe = pen_sq_probe,
    .submit = pen_sq_submit,
    .job = pen_sq_job,
    .jobs = pen_sq_jobs,
    .scene = pen_sq_scene,
    .cancel = pen_sq_cancel,
    .remove = pen_sq_remove,
    .claim = pen_sq_claim,
    .commit = pen_sq_commit,
    .progress = pen_sq_progress,
    .release = pen_sq_release,
    .fail = pen_sq_fail,
    .heartbeat = pen_sq_heartbeat,
    .sweep = pen_sq_sweep,
    .worker_ended = pen_sq_worker_ended,
    .pixels = pen_sq_pixels,
    .stats = pen_sq_stats,
    .batches = pen_sq_batches,
    .commits = pen_sq_commits,
    .worker_seen = pen_sq_worker_seen,
    .worker_gone = pen_sq_worker_gone,
    .workers = pen_sq_workers,
    .artefact = pen_sq_artefact,
    .artefact_put = pen_sq_artefact_put,
    .settle = pen_sq_settle,
    .tidy = pen_sq_tidy,
    .audit = pen_sq_audit,
};

/* Makes the folders above `path`, private to the user. */
static bool make_folders(char *path, struct pen_status *st)
{
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        bool ok = mkdir(path, 0700) == 0 || errno == EEXIST;
        int error = errno;
        if (!ok)
            pen_fail(st, error == ENOSPC ? PEN_STORAGE_FULL : PEN_STORAGE,
                     "cannot make the folder %s: %s", path, strerror(error));
        *slash = '/';
        if (!ok)
            return false;
    }
    return true;
}

static uint32_t big_endian(const unsigned char bytes[4])
{
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* Refuses a file that is not a store of ours, from the header of SQLite's file format (magic at
 * 0, application id at 68). A rollback journal beside it means that its creation was cut short:
 * then SQLite must first undo what is half written. */
static bool check_header(struct pen_sq_store *store, struct pen_status *st)
{
    unsigned char header[100];
    char journal[4096];
    sqlite3_file *file = NULL;
    sqlite3_int64 bytes = 0;
    int rc = sqlite3_file_control(store->db, "main", SQLITE_FCNTL_FILE_POINTER, &file);
    if (rc == SQLITE_OK)
        rc = file->pMethods->xFileSize(file, &bytes);
    snprintf(journal, sizeof journal, "%s-journal", store->path);
    if (rc == SQLITE_OK && (bytes == 0 || access(journal, F_OK) == 0))
        return true;
    if (rc == SQLITE_OK && bytes >= (sqlite3_int64)sizeof header)
        rc = file->pMethods->xRead(file, header, (int)sizeof header, 0);
    if (rc != SQLITE_OK)
        return pen_sq_error(store, rc, st);
    if (bytes < (sqlite3_int64)sizeof header || memcmp(header, "SQLite format 3", 16) != 0)
        return pen_fail(st, PEN_STORAGE,
                        "%s is not a Penumbra store, or its beginning is damaged; nothing was "
                        "changed: give another path, restore a backup, or move the file away",
                        store->path);
    if (big_endian(header + 68) != SQ_APPLICATION_ID)
        return pen_fail(st, PEN_STORAGE,
                        "%s is a database of another program; give another path for the store",
                        store->path);
    return true;
}

static bool cannot_open(const char *path, int error, struct pen_status *st)
{
    return pen_fail(st, error == ENOSPC ? PEN_STORAGE_FULL : PEN_STORAGE,
                    "cannot open the store %s: %s", path, strerror(error));
}

/* Makes the file, readable by its owner alone, if it is not there. */
static bool make_file(const char *path, struct pen_status *st)
{
    int fd = open(path, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0 && errno != EEXIST)
        return cannot_open(path, errno, st);
    if (fd >= 0)
        close(fd);
    return true;
}

/* Waits for another's write in short, slightly growing steps; SQLite's own handler sleeps up to
 * 100 ms at a time, many times what a commit takes. */
static int on_busy(void *arg, int count)
{
    const struct pen_sq_store *store = arg;
    int64_t step_ns = 100000 + 50000 * (int64_t)(count < 40 ? count : 40);
    int64_t waited_ms = (int64_t)count * step_ns / 2000000;
    if (waited_ms >= store->patience_ms)
        return 0;
    struct timespec pause = {.tv_nsec = (long)step_ns};
    nanosleep(&pause, NULL);
    return 1;
}

static int on_wal(void *arg, sqlite3 *db, const char *name, int pages)
{
    (void)db;
    (void)name;
    ((struct pen_sq_store *)arg)->wal_pages = pages;
    return SQLITE_OK;
}

static bool configure(struct pen_sq_store *store, struct pen_status *st)
{
    sqlite3_extended_result_codes(store->db, 1);
    sqlite3_db_config(store->db, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    sqlite3_db_config(store->db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_busy_handler(store->db, on_busy, store);
    return pen_sq_exec(store,
                       "PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON;"
                       "PRAGMA temp_store = MEMORY; PRAGMA cell_size_check = ON;"
                       "PRAGMA journal_size_limit = 8388608",
                       st);
}

static bool open_database(struct pen_sq_store *store, struct pen_status *st)
{
    int rc =
        sqlite3_open_v2(store->path, &store->db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, NULL);
    if (!store->db)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the store");
    if (rc != SQLITE_OK)
        return pen_sq_error(store, rc, st);
    if (!check_header(store, st) || !configure(store, st) || !pen_sq_migrate(store, st) ||
        !pen_sq_guard_states(store, st) || !pen_sq_prepare(store, st))
        return false;
    sqlite3_wal_hook(store->db, on_wal, store);
    return true;
}

/* The steps that must not be taken by two at once. */
static bool open_locked(struct pen_sq_store *store, const char *lock_path, struct pen_status *st)
{
    if (!make_folders(store->path, st))
        return false;
    int lock = open(lock_path, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
    bool made = lock >= 0;
    if (!made)
        lock = open(lock_path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (lock < 0)
        return cannot_open(lock_path, errno, st);
    while (flock(lock, LOCK_EX) != 0 && errno == EINTR)
        continue;
    bool ok = make_file(store->path, st) && open_database(store, st);
    if (!ok && made) /* a file that is no store is left as it was found, without company */
        unlink(lock_path);
    close(lock);
    if (!ok)
        return false;
    store->base.wake = pen_wake_open(lock_path);
    return store->base.wake || pen_fail(st, PEN_NO_MEMORY, "no memory for the store");
}

struct pen_store *pen_sqlite_open(const char *path, struct pen_status *st)
{
    char lock_path[4096];
    if ((size_t)snprintf(lock_path, sizeof lock_path, "%s-wake", path) >= sizeof lock_path) {
        pen_fail(st, PEN_USAGE, "the path of the store is too long");
        return NULL;
    }
    struct pen_sq_store *store = calloc(1, sizeof *store);
    if (store) {
        store->base.ops = &ops;
        store->patience_ms = PATIENCE_MS;
        store->path = strdup(path);
        store->packer = pen_packer_new(DOCUMENT_LEVEL);
    }
    if (!store || !store->path || !store->packer)
        pen_fail(st, PEN_NO_MEMORY, "no memory for the store");
    else if (open_locked(store, lock_path, st))
        return &store->base;
    if (store)
        pen_sq_close(&store->base);
    return NULL;
}
