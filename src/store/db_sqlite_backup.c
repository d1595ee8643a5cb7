/* SPDX-License-Identifier: MIT */
/* Copies a database while other processes read and write it (db.h).
 *   - The copy has all pages as of one moment. All steps of SQLite's backup are in one read
 *     transaction, which writers do not restart. The database is opened only for reading.
 *   - The copy is made under another name, checked, synced and then renamed. So the name always has
 *     a complete backup, or the former file.
 *   - The unfinished copy is locked. If it is not locked, a killed process left it, and the next
 *     backup to that name overwrites it. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "store/internal/sqlite.h"

enum { PATH_BYTES = PEN_SQLITE_PATH_BYTES, STEP_PAGES = 1024 };

static const char part_end[] = ".part-new";

struct copy {
    struct pen_sqlite *from;
    int fd; /* of the unfinished copy, which it locks; -1: none */
    const atomic_bool *stop;
    char path[PATH_BYTES + 32]; /* of the unfinished copy; empty: no copy */
    const char *name;           /* the final name */
    bool replace;
};

static bool cannot_write(const char *path, int error, struct pen_status *st)
{
    return pen_fail(st, error == ENOSPC || error == EDQUOT ? PEN_STORAGE_FULL : PEN_IO,
                    "cannot write the backup %s: %s", path, strerror(error));
}

/* Returns true if the name is that of the store or of a file beside it, which may not exist. */
static bool is_of_store(const char *store, const char *name)
{
    static const char *const ends[] = {"", "-wal", "-shm", "-reserve"};
    char path[PATH_BYTES + 16];
    struct stat named, beside;
    const bool exists = stat(name, &named) == 0;
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++) {
        snprintf(path, sizeof path, "%s%s", store, ends[i]);
        if (strcmp(path, name) == 0 ||
            (exists && stat(path, &beside) == 0 && beside.st_dev == named.st_dev &&
             beside.st_ino == named.st_ino))
            return true;
    }
    return false;
}

static bool check_name(const char *store, const char *name, bool replace, struct pen_status *st)
{
    struct stat info;
    if (strlen(name) >= PATH_BYTES)
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

/* Locks an unfinished copy, unless it was renamed meanwhile. SQLite does not lock this byte.
 * Closing another descriptor of the file does not unlock it. */
static bool lock_part(int fd, const char *path)
{
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET, .l_len = 1};
    struct stat locked, named;
    return fcntl(fd, F_OFD_SETLK, &lock) == 0 && fstat(fd, &locked) == 0 &&
           lstat(path, &named) == 0 && locked.st_dev == named.st_dev &&
           locked.st_ino == named.st_ino;
}

/* Makes the file of the copy, with the store's permissions. */
static bool make_part(struct copy *copy, struct pen_status *st)
{
    snprintf(copy->path, sizeof copy->path, "%s%s", copy->name, part_end);
    copy->fd = open(copy->path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (copy->fd >= 0 && !lock_part(copy->fd, copy->path)) {
        copy->path[0] = '\0';
        return pen_fail(st, PEN_CONFLICT, "another backup to %s is being made", copy->name);
    }
    return (copy->fd >= 0 && ftruncate(copy->fd, 0) == 0) || cannot_write(copy->name, errno, st);
}

void pen_store_backup_remove_left(const char *file)
{
    char path[PATH_BYTES + sizeof part_end];
    snprintf(path, sizeof path, "%s%s", file, part_end);
    const int fd = open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0)
        return;
    if (lock_part(fd, path))
        unlink(path);
    close(fd);
}

static bool is_stopped(const struct copy *copy)
{
    return copy->stop && atomic_load(copy->stop);
}

static bool stopped(struct pen_status *st)
{
    return pen_fail(st, PEN_TIMEOUT, "stopped; no backup was made");
}

/* SQLite reports the error, but not whether the store or the copy failed. The store is only read,
 * so a failed write is one of the copy. */
static bool copy_failed(const struct copy *copy, sqlite3 *to, int rc, struct pen_status *st)
{
    const int error = sqlite3_system_errno(to);
    if (rc == SQLITE_OK)
        return stopped(st);
    if (rc == SQLITE_FULL)
        return cannot_write(copy->name, ENOSPC, st);
    if (rc == SQLITE_IOERR_WRITE || rc == SQLITE_IOERR_FSYNC || rc == SQLITE_IOERR_TRUNCATE)
        return cannot_write(copy->name, error ? error : EIO, st);
    return pen_sqlite_fail(copy->from, rc, st);
}

/* The copy needs no journal, because it is not used after a power failure. */
static bool copy_pages(const struct copy *copy, struct pen_status *st)
{
    sqlite3 *to = NULL;
    int rc = sqlite3_open_v2(
        copy->path, &to, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE, NULL);
    if (rc == SQLITE_OK)
        rc = sqlite3_exec(to, "PRAGMA journal_mode=OFF; PRAGMA synchronous=OFF", NULL, NULL, NULL);
    if (rc == SQLITE_OK) {
        sqlite3_backup *backup = sqlite3_backup_init(to, "main", copy->from->sqlite, "main");
        rc = backup ? SQLITE_OK : sqlite3_extended_errcode(to);
        while (backup && rc == SQLITE_OK && !is_stopped(copy))
            rc = sqlite3_backup_step(backup, STEP_PAGES);
        sqlite3_backup_finish(backup);
    }
    const bool done = rc == SQLITE_DONE;
    if (done)
        rc = sqlite3_exec(to, "PRAGMA journal_mode=DELETE", NULL, NULL, NULL);
    const bool ok = (done && rc == SQLITE_OK) || copy_failed(copy, to, rc, st);
    sqlite3_close(to);
    return ok;
}

static bool check_copy(const struct copy *copy, int64_t *jobs, struct pen_status *st)
{
    char text[256];
    struct pen_sqlite *db = pen_sqlite_open_file(copy->path, false, st);
    const bool ok =
        db &&
        (pen_sqlite_check(db->sqlite, 0, text) == SQLITE_OK ||
         pen_fail(st, PEN_STORAGE, "no backup was made, the store is damaged: %s", text)) &&
        pen_db_value(&db->base, st, jobs, "SELECT count(*) FROM job WHERE removed_ms = 0", "");
    if (db)
        pen_db_close(&db->base);
    return ok;
}

/* Syncs the copy and gives it its name. Without `replace` it uses link(2), which never replaces a
 * file. */
static bool name_copy(struct copy *copy, int64_t *bytes, struct pen_status *st)
{
    struct stat info;
    if (fsync(copy->fd) != 0 || fstat(copy->fd, &info) != 0)
        return cannot_write(copy->name, errno, st);
    *bytes = info.st_size;
    if (is_stopped(copy))
        return stopped(st);
    if ((copy->replace ? rename(copy->path, copy->name) : link(copy->path, copy->name)) != 0)
        return errno == EEXIST
                   ? pen_fail(st, PEN_CONFLICT,
                              "%s was made by another program meanwhile; it was left as it is",
                              copy->name)
                   : cannot_write(copy->name, errno, st);
    if (!copy->replace)
        unlink(copy->path);
    copy->path[0] = '\0';
    return pen_sqlite_sync_folder(copy->name) || cannot_write(copy->name, errno, st);
}

/* The first read fixes the moment. */
static bool read_store(const struct copy *copy, struct pen_status *st)
{
    int64_t tables;
    return pen_db_value(&copy->from->base, st, &tables, "SELECT count(*) FROM sqlite_schema", "") &&
           copy_pages(copy, st);
}

bool pen_sqlite_backup(const char *url, const char *file, bool replace, struct pen_backup *out,
                       struct pen_status *st)
{
    struct copy copy = {.fd = -1, .stop = out->stop, .name = file, .replace = replace};
    if (!check_name(url, file, replace, st))
        return false;
    copy.from = pen_sqlite_open_file(url, false, st);
    const bool ok = copy.from && make_part(&copy, st) &&
                    pen_db_begin(&copy.from->base, PEN_DB_READ, st) &&
                    pen_db_end(&copy.from->base, read_store(&copy, st), st) &&
                    check_copy(&copy, &out->jobs, st) && name_copy(&copy, &out->bytes, st);
    if (copy.from)
        pen_db_close(&copy.from->base);
    if (copy.path[0]) {
        unlink(copy.path);
        unlink(strcat(copy.path, "-journal")); /* of a disk that failed */
    }
    if (copy.fd >= 0)
        close(copy.fd);
    return ok;
}
