/* SPDX-License-Identifier: MIT */
/* Copies a store while others read and write it.
 *  - The copy has all pages as of one moment: all steps of SQLite's backup are in one read
 *    transaction of the store, which writers do not restart.
 *  - It is made under another name, checked, synced and then renamed. So the name always stands
 *    for a complete backup, or for the file that was there before.
 *  - Its process locks it. So a copy that is not locked was left by a process that was killed, and
 *    the next backup to that name removes it.
 *  - It has no log: it is one file. It has an identity of its own (meta.c).
 *  - The store itself is only read. A store of an older schema is copied as it is. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "store/sqlite/sqlite.h"

enum { PATH_BYTES = 4096, STEP_PAGES = 1024, CHECK_STEPS = 100000 };

static const char part_end[] = ".part-XXXXXX";

struct copy {
    struct pen_sqlite_store from, to;
    int lock_fd; /* of the copy, -1: none */
    const atomic_bool *stop;
    char path[PATH_BYTES + 16]; /* of the unfinished copy */
    const char *name;           /* the final name */
    bool replace;
};

static bool cannot_write(const char *path, int error, struct pen_status *st)
{
    return pen_fail(st, pen_errno_is_full(error) ? PEN_STORAGE_FULL : PEN_IO,
                    "cannot write the backup %s: %s", path, strerror(error));
}

/* Tells whether the name is that of the store or of a file beside it, which may not exist. */
static bool is_of_store(const char *store, const char *name)
{
    static const char *const ends[] = {"", "-wal", "-shm", "-wake", "-reserve", "-new"};
    char path[PATH_BYTES + 16], *resolved = pen_sqlite_resolve(name);
    struct stat named, beside;
    const bool exists = stat(name, &named) == 0;
    bool found = false;
    for (size_t i = 0; i < sizeof ends / sizeof ends[0] && !found; i++) {
        snprintf(path, sizeof path, "%s%s", store, ends[i]);
        found = (exists && stat(path, &beside) == 0 && pen_sqlite_same_file(&beside, &named)) ||
                strcmp(path, resolved ? resolved : name) == 0;
    }
    free(resolved);
    return found;
}

static bool check_name(const char *store, const char *name, bool replace, struct pen_status *st)
{
    struct stat info;
    if (strlen(name) >= PATH_BYTES || strlen(store) >= PATH_BYTES)
        return pen_fail(st, PEN_USAGE, "the path of the backup is too long");
    if (is_of_store(store, name))
        return pen_fail(st, PEN_USAGE, "%s is the store itself; a backup needs another name", name);
    if (lstat(name, &info) != 0)
        return errno == ENOENT || cannot_write(name, errno, st);
    if (S_ISDIR(info.st_mode))
        return pen_fail(st, PEN_USAGE, "%s is a folder; give the backup a name in it", name);
    return replace || pen_fail(st, PEN_CONFLICT,
                               "%s is there already; nothing was written. --replace replaces it "
                               "once the new backup is whole",
                               name);
}

/* Locks a byte that SQLite does not lock. Closing other descriptors of the file does not unlock it.
 */
static bool lock_part(int fd)
{
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET, .l_len = 1};
    return fcntl(fd, F_OFD_SETLK, &lock) == 0;
}

static void remove_files(const char *part)
{
    char journal[PATH_BYTES + 300];
    snprintf(journal, sizeof journal, "%s-journal", part);
    unlink(part);
    unlink(journal);
}

static void remove_if_left(const char *part)
{
    int fd = open(part, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0)
        return;
    if (lock_part(fd) && pen_sqlite_is_named(fd, part))
        remove_files(part);
    close(fd);
}

void pen_sqlite_backup_remove_left(const char *name)
{
    char part[PATH_BYTES + 280];
    const char *slash = strrchr(name, '/'), *last = slash ? slash + 1 : name;
    size_t length = strlen(last);
    snprintf(part, sizeof part, "%.*s", slash ? (int)(last - name) : 2, slash ? name : "./");
    DIR *folder = opendir(part);
    for (struct dirent *entry; folder && (entry = readdir(folder)) != NULL;) {
        const char *end = entry->d_name + length;
        if (strlen(entry->d_name) != length + sizeof part_end - 1 ||
            memcmp(entry->d_name, last, length) != 0 || strncmp(end, part_end, 6) != 0)
            continue;
        snprintf(part, sizeof part, "%.*s%s", (int)(last - name), name, entry->d_name);
        remove_if_left(part);
    }
    if (folder)
        closedir(folder);
}

/* Makes the file of the copy, and locks it. Another process may remove it before it is locked. */
static bool make_part(struct copy *copy, struct pen_status *st)
{
    for (int tries = 0; tries < 100; tries++) {
        snprintf(copy->path, sizeof copy->path, "%s%s", copy->name, part_end);
        copy->lock_fd = mkostemp(copy->path, O_CLOEXEC); /* 0600, as the store */
        if (copy->lock_fd < 0)
            break;
        if (lock_part(copy->lock_fd) && pen_sqlite_is_named(copy->lock_fd, copy->path))
            return true;
        unlink(copy->path);
        close(copy->lock_fd);
    }
    copy->path[0] = '\0';
    return cannot_write(copy->name, errno, st);
}

static bool open_copy(struct copy *copy, struct pen_status *st)
{
    if (!make_part(copy, st))
        return false;
    copy->to.path = copy->path;
    int rc = sqlite3_open_v2(copy->path, &copy->to.db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX,
                             NULL);
    if (!copy->to.db)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the backup");
    sqlite3_extended_result_codes(copy->to.db, 1);
    return rc == SQLITE_OK || cannot_write(copy->path, sqlite3_system_errno(copy->to.db), st);
}

/* SQLite tells what failed, but not on which side. The store is only read, so a failed write is one
 * of the copy. */
static bool copy_failed(struct copy *copy, int rc, struct pen_status *st)
{
    int error = sqlite3_system_errno(copy->to.db);
    switch (rc) {
    case SQLITE_FULL:
        return cannot_write(copy->name, ENOSPC, st);
    case SQLITE_IOERR_WRITE:
    case SQLITE_IOERR_FSYNC:
    case SQLITE_IOERR_TRUNCATE:
        return cannot_write(copy->name, error ? error : EIO, st);
    default:
        return pen_sqlite_error(&copy->from, rc, st);
    }
}

static int is_stopped(void *user)
{
    const struct copy *copy = user;
    return copy->stop && atomic_load(copy->stop);
}

static bool stopped(struct pen_status *st)
{
    return pen_fail(st, PEN_TIMEOUT, "stopped; no backup was made");
}

/* The copy needs no journal: after a power failure it is not used. */
static bool copy_pages(struct copy *copy, struct pen_status *st)
{
    if (!pen_sqlite_exec(&copy->to, "PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF", st) ||
        !pen_sqlite_exec(&copy->from, "BEGIN; SELECT count(*) FROM sqlite_schema", st))
        return false;
    sqlite3_backup *backup = sqlite3_backup_init(copy->to.db, "main", copy->from.db, "main");
    if (!backup)
        return copy_failed(copy, sqlite3_errcode(copy->to.db), st);
    int rc;
    do
        rc = sqlite3_backup_step(backup, STEP_PAGES);
    while (rc == SQLITE_OK && !is_stopped(copy));
    sqlite3_backup_finish(backup);
    if (is_stopped(copy))
        return stopped(st);
    if (rc != SQLITE_DONE)
        return copy_failed(copy, rc, st);
    rc = sqlite3_exec(copy->to.db, "PRAGMA journal_mode = DELETE", NULL, NULL, NULL);
    return rc == SQLITE_OK || copy_failed(copy, rc, st);
}

static bool count_jobs(struct copy *copy, int64_t *jobs, struct pen_status *st)
{
    sqlite3_stmt *stmt = NULL;
    int rc = sqlite3_prepare_v2(copy->to.db, "SELECT count(*) FROM job", -1, &stmt, NULL);
    if (rc == SQLITE_OK)
        rc = sqlite3_step(stmt);
    if (rc == SQLITE_ROW)
        *jobs = sqlite3_column_int64(stmt, 0);
    sqlite3_finalize(stmt);
    return rc == SQLITE_ROW || pen_sqlite_error(&copy->to, rc, st);
}

static bool check_copy(struct copy *copy, int64_t *jobs, struct pen_status *st)
{
    struct pen_status why;
    sqlite3_progress_handler(copy->to.db, CHECK_STEPS, is_stopped, copy);
    if (pen_sqlite_check_pages(&copy->to, &why) && count_jobs(copy, jobs, &why))
        return true;
    if (is_stopped(copy))
        return stopped(st);
    return pen_fail(st, why.code, "no backup was made, its check failed: %s", why.msg);
}

static bool sync_file(const char *path, int64_t *bytes, struct pen_status *st)
{
    struct stat info;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    bool ok = fd >= 0 && fsync(fd) == 0 && fstat(fd, &info) == 0;
    int error = errno;
    if (fd >= 0)
        close(fd);
    if (!ok)
        return cannot_write(path, error, st);
    *bytes = info.st_size;
    return true;
}

static bool name_copy(struct copy *copy, struct pen_status *st)
{
    bool ok = copy->replace ? rename(copy->path, copy->name) == 0
                            : pen_sqlite_name_new_file(copy->path, copy->name);
    if (ok) {
        copy->path[0] = '\0';
        return pen_sqlite_sync_folder(copy->name) || cannot_write(copy->name, errno, st);
    }
    if (errno == EEXIST)
        return pen_fail(st, PEN_CONFLICT,
                        "%s was made by another program meanwhile; it was left as it is",
                        copy->name);
    return cannot_write(copy->name, errno, st);
}

static bool make_backup(struct copy *copy, struct pen_backup *out, struct pen_status *st)
{
    if (!pen_sqlite_open_to_read(&copy->from, st) || !open_copy(copy, st) ||
        !copy_pages(copy, st) || !check_copy(copy, &out->jobs, st))
        return false;
    if (!pen_sqlite_make_independent(copy->to.db))
        return copy_failed(copy, sqlite3_extended_errcode(copy->to.db), st);
    if (sqlite3_close(copy->to.db) == SQLITE_OK)
        copy->to.db = NULL;
    if (!sync_file(copy->path, &out->bytes, st))
        return false;
    return is_stopped(copy) ? stopped(st) : name_copy(copy, st);
}

/* Removes the files of a failed backup. */
static void remove_part(struct copy *copy)
{
    if (copy->path[0])
        remove_files(copy->path);
    if (copy->lock_fd >= 0)
        close(copy->lock_fd);
}

static bool back_up(struct copy *copy, struct pen_backup *out, struct pen_status *st)
{
    if (!check_name(copy->from.path, copy->name, copy->replace, st))
        return false;
    pen_sqlite_backup_remove_left(copy->name);
    bool ok = make_backup(copy, out, st);
    sqlite3_close(copy->to.db);
    pen_sqlite_close_unwritten(&copy->from);
    remove_part(copy);
    return ok;
}

bool pen_sqlite_backup(const char *url, const char *name, bool replace, struct pen_backup *out,
                       struct pen_status *st)
{
    struct copy *copy = calloc(1, sizeof *copy);
    char *path = pen_sqlite_resolve(url);
    if (!path) /* opening it tells why */
        path = strdup(url);
    bool ok = false;
    if (copy && path) {
        copy->from.path = path;
        copy->from.patience_ms = 5000;
        copy->name = name;
        copy->lock_fd = -1;
        copy->stop = out->stop;
        copy->replace = replace;
        ok = back_up(copy, out, st);
    } else {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the backup");
    }
    free(path);
    free(copy);
    return ok;
}
