/* SPDX-License-Identifier: MIT */
/* Opening, reopening and closing.
 *  - Nothing is written to a file before its header shows that it is a Penumbra store. The first
 *    statement could write already, so the header is read before it.
 *  - A file that was not opened without a fault is closed without a checkpoint.
 *  - Handles of several processes may open a store at the same time. Making and migrating it is
 *    done under a lock (flock) on the file ending in -wake.
 *  - The database file is read through SQLite's own descriptor. Closing another descriptor of it
 *    would drop the POSIX locks of all handles of this process
 *    (https://www.sqlite.org/howtocorrupt.html, 2.2). The only other one is that of supervisor.c.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "store/sqlite/sqlite.h"
#include "store/sqlite/wake.h"

enum { PATIENCE_MS = 5000 };

/* An empty log has nothing that a checkpoint could write to the database. */
static bool log_is_empty(const struct pen_sqlite_store *store)
{
    int64_t bytes;
    return pen_sqlite_file_bytes(store, "-wal", &bytes) && bytes == 0;
}

/* Makes no checkpoint, and so writes nothing, unless the file and the handle are sound. */
static void close_database(struct pen_sqlite_store *store)
{
    for (int i = 0; i < SQL_COUNT; i++) {
        sqlite3_finalize(store->stmt[i]);
        store->stmt[i] = NULL;
    }
    if (store->db)
        sqlite3_db_config(store->db, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE,
                          !store->sound && !log_is_empty(store), NULL);
    sqlite3_close(store->db);
    store->db = NULL;
    store->sound = false;
}

void pen_sqlite_close(struct pen_driver *driver)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    close_database(store);
    pen_wake_close(store->wake);
    if (store->lock_fd >= 0)
        close(store->lock_fd);
    if (store->supervisor_fd >= 0) /* after SQLite's, see supervisor.c */
        close(store->supervisor_fd);
    free(store->path);
    free(store);
}

static bool open_database(struct pen_sqlite_store *store, struct pen_status *st);
static bool cannot_open(const char *path, int error, struct pen_status *st);

/* Checks that the path still names the same file, and that the files beside it are there: another
 * one must not be opened with the first one's log, nor the same one with a new log. Fails:
 * PEN_STORAGE. */
static bool is_same_file(const struct pen_sqlite_store *store, struct pen_status *st)
{
    struct stat now;
    if (stat(store->path, &now) != 0)
        return cannot_open(store->path, errno, st);
    const char *lost = pen_sqlite_lost_beside(store);
    if (lost)
        return pen_sqlite_lost_name(store, lost, st);
    return pen_sqlite_same_file(&now, &store->opened) ||
           pen_fail(st, PEN_STORAGE,
                    "another file was put in the place of the store %s while it was in use: stop "
                    "Penumbra, remove the files ending in -wal and -shm, and start it again",
                    store->path);
}

/* The new connection is opened before the old one is closed. If there were none in between, the
 * next one would read the whole log again, and could find a transaction whose sync had failed after
 * other readers saw the store without it. */
bool pen_sqlite_reopen(struct pen_driver *driver, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver), old = *store;
    if (!is_same_file(store, st))
        return false;
    store->db = NULL;
    memset(store->stmt, 0, sizeof store->stmt);
    bool ok = open_database(store, st);
    old.sound = false;
    close_database(&old);
    return ok;
}

/* Makes the folders above `path`, private to the user. */
static bool make_folders(char *path, struct pen_status *st)
{
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        bool ok = mkdir(path, 0700) == 0 || errno == EEXIST;
        int error = errno;
        if (!ok)
            pen_fail(st, pen_errno_is_full(error) ? PEN_STORAGE_FULL : PEN_STORAGE,
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

/* Refuses a file that is not a Penumbra store, by the header of SQLite's file format: magic at 0,
 * application id at 68. Source: SQLite, "Database File Format", 1.3. */
static bool check_header(struct pen_sqlite_store *store, struct pen_status *st)
{
    unsigned char header[100];
    sqlite3_file *file = NULL;
    sqlite3_int64 bytes = 0;
    int rc = sqlite3_file_control(store->db, "main", SQLITE_FCNTL_FILE_POINTER, &file);
    if (rc == SQLITE_OK)
        rc = file->pMethods->xFileSize(file, &bytes);
    if (rc == SQLITE_OK && bytes >= (sqlite3_int64)sizeof header)
        rc = file->pMethods->xRead(file, header, (int)sizeof header, 0);
    if (rc != SQLITE_OK)
        return pen_sqlite_io_error(store, rc, 0, st);
    if (bytes == 0)
        return pen_sqlite_damaged(store, st, "the file %s is empty, which a store never is",
                                  store->path);
    if (bytes < (sqlite3_int64)sizeof header || memcmp(header, "SQLite format 3", 16) != 0)
        return pen_sqlite_damaged(
            store, st, "%s is not a Penumbra store, or its beginning is damaged", store->path);
    if (big_endian(header + 68) != SQL_APPLICATION_ID)
        return pen_fail(st, PEN_STORAGE,
                        "%s is a database of another program (application id 0x%08x); give "
                        "another path for the store",
                        store->path, (unsigned)big_endian(header + 68));
    return true;
}

static bool cannot_open(const char *path, int error, struct pen_status *st)
{
    return pen_fail(st, pen_errno_is_full(error) ? PEN_STORAGE_FULL : PEN_STORAGE,
                    "cannot open the store %s: %s", path, strerror(error));
}

/* Refuses paths for which SQLite's messages would be unclear or missing. */
static bool check_kind(const char *path, struct pen_status *st)
{
    struct stat info;
    if (stat(path, &info) != 0)
        return cannot_open(path, errno, st);
    if (S_ISREG(info.st_mode))
        return access(path, R_OK | W_OK) == 0 || cannot_open(path, errno, st);
    return pen_fail(st, PEN_STORAGE, "cannot open the store %s: it is a %s, not a file", path,
                    S_ISDIR(info.st_mode) ? "folder" : "device or pipe");
}

/* Checks the store's file and those beside it that exist. */
static bool check_kinds(const struct pen_sqlite_store *store, struct pen_status *st)
{
    char path[PEN_SQLITE_PATH_BYTES];
    bool ok = check_kind(store->path, st);
    for (int i = 0; ok && i < PEN_SQLITE_BESIDE; i++) {
        pen_sqlite_path(store, pen_sqlite_beside[i], path);
        ok = access(path, F_OK) != 0 || check_kind(path, st);
    }
    return ok;
}

/* Waits for another handle's write in short, slightly growing steps. SQLite's own handler sleeps up
 * to 100 ms at a time, many times as long as a commit takes. */
static int on_busy(void *arg, int count)
{
    enum { FIRST_STEP_NS = 100000, GROWTH_NS = 50000, GROWING = 40 };
    const struct pen_sqlite_store *store = arg;
    const int64_t grown = count < GROWING ? count : GROWING,
                  step_ns = FIRST_STEP_NS + GROWTH_NS * grown,
                  waited_ns = grown * (FIRST_STEP_NS + step_ns) / 2 + (count - grown) * step_ns;
    if (waited_ns >= store->patience_ms * 1000000)
        return 0;
    struct timespec pause = {.tv_nsec = (long)step_ns};
    nanosleep(&pause, NULL);
    return 1;
}

static int on_wal(void *arg, sqlite3 *db, const char *name, int pages)
{
    (void)db;
    (void)name;
    ((struct pen_sqlite_store *)arg)->wal_pages = pages;
    return SQLITE_OK;
}

/* secure_delete, which Debian's SQLite turns on, overwrites what is removed: a removal would write
 * as much to the log as it removes. */
static bool configure(struct pen_sqlite_store *store, struct pen_status *st)
{
    sqlite3_extended_result_codes(store->db, 1);
    sqlite3_db_config(store->db, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    sqlite3_db_config(store->db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_busy_handler(store->db, on_busy, store);
    return pen_sqlite_exec(store,
                           "PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON;"
                           "PRAGMA temp_store = MEMORY; PRAGMA cell_size_check = ON;"
                           "PRAGMA secure_delete = OFF",
                           st) &&
           pen_sqlite_limit_log(store, st);
}

static bool connect(struct pen_sqlite_store *store, const char *path, struct pen_status *st)
{
    store->index_parts = 0;
    int rc = sqlite3_open_v2(path, &store->db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, NULL);
    if (!store->db)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the store");
    if (rc != SQLITE_OK)
        return pen_sqlite_error(store, rc, st);
    int persist = 1;
    sqlite3_file_control(store->db, "main", SQLITE_FCNTL_PERSIST_WAL, &persist);
    sqlite3_db_config(store->db, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, NULL);
    return true;
}

/* Opens a store that exists. */
static bool open_database(struct pen_sqlite_store *store, struct pen_status *st)
{
    bool ok = check_kinds(store, st) && connect(store, store->path, st) &&
              check_header(store, st) && configure(store, st) && pen_sqlite_migrate(store, st) &&
              pen_sqlite_guard_states(store, st);
    if (ok) {
        sqlite3_wal_hook(store->db, on_wal, store);
        sqlite3_db_config(store->db, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 0, NULL);
        ok = pen_sqlite_prepare(store, st);
    }
    if (ok)
        pen_sqlite_note_beside(store);
    store->sound = ok;
    if (!ok)
        close_database(store);
    return ok;
}

/* The first handle makes the log's index anew, which on a full disk takes space from the reserve.
 */
static bool open_on_any_disk(struct pen_sqlite_store *store, struct pen_status *st)
{
    while (!open_database(store, st)) {
        if (st->code != PEN_STORAGE_FULL || !pen_sqlite_reserve_for_index(store))
            return false;
        pen_log(PEN_LOG_WARN, "the disk of the store %s is full: its reserve is used to open it",
                store->path);
    }
    return true;
}

void pen_sqlite_close_unwritten(struct pen_sqlite_store *store)
{
    store->sound = false;
    close_database(store);
    pen_wake_close(store->wake);
    store->wake = NULL;
}

/* Makes a new store under another name and renames it when it is complete, so that an empty or
 * incomplete file under the store's path is never ours. */
static bool make_store(struct pen_sqlite_store *store, const char *path, struct pen_status *st)
{
    char leftover[4128];
    snprintf(leftover, sizeof leftover, "%s-journal", path);
    unlink(path);
    unlink(leftover);
    int fd = open(path, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0)
        return cannot_open(path, errno, st);
    close(fd);
    bool ok = connect(store, path, st) && configure(store, st) && pen_sqlite_make_schema(store, st);
    close_database(store);
    if (ok && !pen_sqlite_name_new_file(path, store->path) && errno != EEXIST)
        ok = cannot_open(store->path, errno, st);
    unlink(path); /* unless it was renamed */
    if (ok && !pen_sqlite_sync_folder(store->path))
        ok = cannot_open(store->path, errno, st);
    return ok;
}

static bool make_missing(struct pen_sqlite_store *store, struct pen_status *st)
{
    char path[PEN_SQLITE_PATH_BYTES];
    struct stat info;
    if (lstat(store->path, &info) == 0)
        return true;
    if (errno != ENOENT)
        return cannot_open(store->path, errno, st);
    if (!pen_sqlite_may_make(store, st))
        return false;
    pen_sqlite_path(store, "-new", path);
    return make_store(store, path, st);
}

/* Waits for the lock on the file ending in -wake. */
static bool take_lock(const struct pen_sqlite_store *store, int lock, const char *lock_path,
                      struct pen_status *st)
{
    const struct timespec pause = {.tv_nsec = 5000000};
    int64_t until = pen_clock_ns() + store->patience_ms * 1000000;
    while (flock(lock, LOCK_EX | LOCK_NB) != 0) {
        if (errno != EWOULDBLOCK && errno != EINTR)
            return cannot_open(lock_path, errno, st);
        if (pen_clock_ns() >= until)
            return pen_sqlite_lock_is_held(lock, lock_path, st);
        nanosleep(&pause, NULL);
    }
    return true;
}

struct wake_lock {
    int fd;    /* -1: there is no such file */
    bool made; /* it was not there before */
};

/* Takes the lock on the file ending in -wake, which is made if it is missing and `make` says so. A
 * file that has lost its name by the time the lock is taken would keep nobody out: the one that has
 * the name now is taken instead. */
static bool lock_wake(const struct pen_sqlite_store *store, const char *path, bool make,
                      struct wake_lock *lock, struct pen_status *st)
{
    const int flags = O_RDWR | O_CLOEXEC | O_NOFOLLOW | (make ? O_CREAT : 0);
    for (;;) {
        lock->fd = make ? open(path, flags | O_EXCL, 0600) : -1;
        lock->made = lock->fd >= 0;
        if (!lock->made)
            lock->fd = open(path, flags, 0600);
        if (lock->fd < 0)
            return !make || cannot_open(path, errno, st);
        const bool taken = take_lock(store, lock->fd, path, st);
        if (taken && pen_sqlite_is_named(lock->fd, path))
            return true;
        close(lock->fd);
        if (!taken)
            return false;
    }
}

static bool open_existing(struct pen_sqlite_store *store, struct pen_status *st)
{
    return check_kinds(store, st) && pen_sqlite_check_company(store, st) &&
           connect(store, store->path, st) && check_header(store, st) && configure(store, st) &&
           pen_sqlite_check_log(store, st);
}

/* The -wake file is joined if it is there, and not made. */
bool pen_sqlite_open_to_read(struct pen_sqlite_store *store, struct pen_status *st)
{
    char lock_path[PEN_SQLITE_PATH_BYTES];
    struct stat info;
    if (stat(store->path, &info) != 0 && errno == ENOENT)
        return pen_fail(st, PEN_NOT_FOUND, "there is no store %s", store->path);
    pen_sqlite_path(store, "-wake", lock_path);
    struct wake_lock lock;
    if (!lock_wake(store, lock_path, false, &lock, st))
        return false;
    if (lock.fd < 0)
        return open_existing(store, st);
    store->wake = pen_wake_open(lock_path);
    bool ok = store->wake || pen_fail(st, PEN_NO_MEMORY, "no memory for the store");
    ok = ok && open_existing(store, st);
    if (ok)
        pen_sqlite_note_beside(store);
    close(lock.fd);
    return ok;
}

static bool open_in_company(struct pen_sqlite_store *store, const char *lock_path,
                            struct pen_status *st)
{
    store->wake = pen_wake_open(lock_path);
    if (!store->wake)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the store");
    if (!make_missing(store, st) || !check_kind(store->path, st) ||
        !pen_sqlite_check_company(store, st) || !open_on_any_disk(store, st))
        return false;
    if (stat(store->path, &store->opened) != 0)
        return cannot_open(store->path, errno, st);
    if (!pen_sqlite_join_company(store, st))
        return false;
    pen_sqlite_note_beside(store); /* a new store has a log by now */
    return true;
}

/* Finds where the store is, or where it is to be made, and makes its folders. */
static bool find_place(struct pen_sqlite_store *store, struct pen_status *st)
{
    if (store->wanted && access(store->path, F_OK) != 0 && errno == ENOENT)
        return pen_sqlite_may_make(store, st);
    if (!store->wanted && !make_folders(store->path, st))
        return false;
    char *resolved = pen_sqlite_resolve(store->path);
    if (!resolved)
        return cannot_open(store->path, errno, st);
    free(store->path);
    store->base.name = store->path = resolved;
    return true;
}

/* The steps of opening that only one process may do at a time. */
static bool open_locked(struct pen_sqlite_store *store, struct pen_status *st)
{
    char lock_path[PEN_SQLITE_PATH_BYTES];
    pen_sqlite_path(store, "-wake", lock_path);
    struct wake_lock lock;
    if (!lock_wake(store, lock_path, true, &lock, st))
        return false;
    const bool ok = open_in_company(store, lock_path, st);
    /* No new file stays beside a file that is not a store, unless others use it by now. */
    if (!ok && lock.made && store->wake && pen_wake_be_alone(store->wake))
        unlink(lock_path);
    close(lock.fd);
    return ok;
}

struct pen_driver *pen_sqlite_open(const char *path, const char *identity, struct pen_status *st)
{
    enum { LONGEST_BYTES = 4090 }; /* with an ending PATH_MAX */
    if (strlen(path) > LONGEST_BYTES) {
        pen_fail(st, PEN_USAGE, "the path of the store is too long");
        return NULL;
    }
    struct pen_sqlite_store *store = calloc(1, sizeof *store);
    if (!store) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the store");
        return NULL;
    }
    store->base.ops = pen_sqlite_ops();
    store->patience_ms = PATIENCE_MS;
    store->lock_fd = store->supervisor_fd = -1;
    store->wanted = identity;
    store->base.name = store->path = strdup(path);
    if (!store->path)
        pen_fail(st, PEN_NO_MEMORY, "no memory for the store");
    else if (find_place(store, st) && open_locked(store, st))
        return &store->base;
    pen_sqlite_close(&store->base);
    return NULL;
}
