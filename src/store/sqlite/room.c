/* SPDX-License-Identifier: MIT */
/* The space that the store and its disk have, and the reserve: a file beside the store, ending in
 * -reserve, whose only use is to be cut when the disk is full. Then there is space for what frees
 * more: cancelling and removing jobs. It is made whole again before new jobs are taken. Its size
 * lets a log of the length that checkpoint.c allows be copied into the store.
 *
 * Other programs take at once what becomes free on a full disk. So what is cut is given right away
 * to the one of the store's own files that lacks space: the database file, its log or the log's
 * index. What another program takes in between is lost: with the file that is the time of a sync
 * of the log, with the index the time until the write lock is free. What the log gets beyond its
 * usual length (checkpoint.c) is free again once the log begins anew. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "base/log.h"
#include "store/sqlite/sqlite.h"

enum {
    RESERVE_PART = 64,    /* of the disk, within these bounds */
    PARTS = 8,            /* of the reserve, where it is not known how much is lacking */
    SMALL_BYTES = 1 << 20 /* a blob of so many bytes is tried, however full the disk */
};
static const int64_t reserve_min_bytes = INT64_C(256) << 10, reserve_max_bytes = INT64_C(32) << 20;

static bool disk_room(const struct pen_sqlite_store *store, struct pen_room *room)
{
    struct statvfs info;
    if (statvfs(store->path, &info) != 0)
        return false;
    room->disk_bytes = (int64_t)info.f_blocks * (int64_t)info.f_frsize;
    room->disk_free_bytes = (int64_t)info.f_bavail * (int64_t)info.f_frsize;
    return true;
}

int64_t pen_sqlite_free_bytes(const struct pen_sqlite_store *store)
{
    struct pen_room room = {0};
    const bool known = disk_room(store, &room) && room.disk_bytes > 0;
    return known ? room.disk_free_bytes : INT64_MAX / 2;
}

static int64_t reserve_of(const struct pen_room *room)
{
    const int64_t part = room->disk_bytes / RESERVE_PART;
    if (room->disk_bytes == 0) /* not known: it counts as large */
        return reserve_max_bytes;
    if (part < reserve_min_bytes)
        return reserve_min_bytes;
    return part < reserve_max_bytes ? part : reserve_max_bytes;
}

bool pen_sqlite_room(struct pen_driver *driver, struct pen_room *room, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct pen_sqlite_query all = pen_sqlite_query(store, SQL_PAGES),
                            empty = pen_sqlite_query(store, SQL_FREE_PAGES);
    int64_t pages, unused;
    *room = (struct pen_room){0};
    if (!pen_sqlite_value(&all, &pages, st) || !pen_sqlite_value(&empty, &unused, st))
        return false;
    room->used_bytes = (pages - unused) * PEN_SQLITE_PAGE_BYTES;
    room->free_bytes = unused * PEN_SQLITE_PAGE_BYTES;
    if (disk_room(store, room)) /* if that is not known, the disk does not count */
        room->log_bytes = reserve_of(room);
    return true;
}

int64_t pen_sqlite_reserve_bytes(const struct pen_sqlite_store *store)
{
    struct pen_room room = {0};
    disk_room(store, &room);
    return reserve_of(&room);
}

/* A value is written to the log and copied from there, so there must be space for both: else it
 * could fill the disk with a log that can never be copied. */
bool pen_sqlite_blob_fits(struct pen_sqlite_store *store, size_t bytes, size_t log_bytes,
                          struct pen_status *st)
{
    struct pen_room room = {0};
    if (bytes <= SMALL_BYTES || !disk_room(store, &room) || room.disk_bytes == 0)
        return true;
    const int64_t wanted = (int64_t)bytes + (int64_t)log_bytes - reserve_of(&room);
    if (wanted <= room.disk_free_bytes)
        return true;
    store->base.wanted_bytes = wanted;
    return pen_fail(st, PEN_STORAGE_FULL,
                    "the store %s has no space left for %lld KiB: they need %lld KiB free on its "
                    "disk, which has %lld",
                    store->path, (long long)(bytes >> 10), (long long)(wanted >> 10),
                    (long long)(room.disk_free_bytes >> 10));
}

/* Opens the reserve, alone until it is closed; *bytes is its length. Returns -1 with errno. */
static int open_reserve(const struct pen_sqlite_store *store, int flags, int64_t *bytes)
{
    char path[PEN_SQLITE_PATH_BYTES];
    struct stat info;
    pen_sqlite_path(store, "-reserve", path);
    int fd = open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW | flags, 0600);
    if (fd < 0)
        return -1;
    while (flock(fd, LOCK_EX) != 0 && errno == EINTR)
        continue;
    if (fstat(fd, &info) != 0) {
        close(fd);
        return -1;
    }
    *bytes = (int64_t)info.st_size;
    return fd;
}

bool pen_sqlite_reserve_allocate(struct pen_sqlite_store *store, int64_t more,
                                 struct pen_status *st)
{
    const int64_t wanted = pen_sqlite_reserve_bytes(store);
    int64_t bytes = 0;
    int fd = open_reserve(store, O_CREAT, &bytes);
    int error = fd < 0 ? errno : 0;
    const int64_t whole = bytes > wanted ? bytes : wanted;
    if (fd >= 0 && bytes < whole + more) {
        error = posix_fallocate(fd, 0, (off_t)(whole + more));
        if (ftruncate(fd, (off_t)(error ? bytes : whole)) != 0 && !error)
            error = errno;
    }
    if (fd >= 0)
        close(fd);
    if (!error)
        return true;
    if (pen_errno_is_full(error))
        return pen_fail(st, PEN_STORAGE_FULL,
                        "the store %s has no space left: it needs %lld KiB more, for its reserve "
                        "and new work",
                        store->path, (long long)((whole + more - bytes + 1023) >> 10));
    return pen_fail(st, PEN_STORAGE, "the reserve of the store %s, of %lld KiB, cannot be made: %s",
                    store->path, (long long)(whole >> 10), strerror(error));
}

bool pen_sqlite_reserve_make(struct pen_driver *driver, struct pen_status *st)
{
    return pen_sqlite_reserve_allocate(pen_sqlite_of(driver), 0, st);
}

/* Cuts so many bytes from the reserve, or what there is. Returns how many. */
static int64_t cut_reserve(const struct pen_sqlite_store *store, int64_t bytes)
{
    int64_t length = 0;
    int fd = open_reserve(store, 0, &length);
    int64_t cut = bytes < length ? bytes : length;
    if (fd < 0 || ftruncate(fd, (off_t)(length - cut)) != 0)
        cut = 0;
    if (fd >= 0)
        close(fd);
    return cut;
}

/* In whole pages, so that a cut frees as many as the log then needs. */
static int64_t reserve_part(const struct pen_sqlite_store *store)
{
    return pen_sqlite_reserve_bytes(store) / PARTS / PEN_SQLITE_PAGE_BYTES * PEN_SQLITE_PAGE_BYTES;
}

/* How many bytes the file lacks for the pages that the log holds for it. */
static int64_t file_lacks(struct pen_sqlite_store *store)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_PAGES);
    struct pen_status ignored;
    int64_t pages, bytes;
    if (!pen_sqlite_value(&query, &pages, &ignored) || !pen_sqlite_file_bytes(store, "", &bytes))
        return 0;
    const int64_t lacks = pages * PEN_SQLITE_PAGE_BYTES - bytes;
    return lacks > 0 ? lacks : 0;
}

/* Only SQLite may open its file (closing it elsewhere would drop this process's locks), so it
 * copies the log. With a chunk size it makes the file as long as it will be before it copies any
 * page. */
static void lengthen_file(struct pen_sqlite_store *store)
{
    int chunk = PEN_SQLITE_PAGE_BYTES, none = 0;
    struct pen_status ignored;
    sqlite3_file_control(store->db, "main", SQLITE_FCNTL_CHUNK_SIZE, &chunk);
    pen_sqlite_checkpoint(&store->base, &ignored);
    sqlite3_file_control(store->db, "main", SQLITE_FCNTL_CHUNK_SIZE, &none);
}

/* What is allocated behind the log's end changes nothing in it: SQLite reads it up to the first
 * frame that does not belong to it. Where the file system cannot allocate, the space is only free.
 */
static void lengthen_log(struct pen_sqlite_store *store, int64_t bytes)
{
    char path[PEN_SQLITE_PATH_BYTES];
    struct stat info;
    pen_sqlite_path(store, "-wal", path);
    int fd = open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0)
        return;
    if (fstat(fd, &info) != 0 || fallocate(fd, 0, info.st_size, (off_t)bytes) != 0)
        pen_log(PEN_LOG_DEBUG, "the log %s cannot be lengthened: %s", path, strerror(errno));
    close(fd);
}

/* As every transaction does when it begins. */
static void lengthen_index(struct pen_sqlite_store *store)
{
    struct pen_status ignored;
    if (pen_sqlite_begin_write(&store->base, &ignored))
        pen_sqlite_rollback(&store->base);
}

/* What could not be synced must not be synced again (store/internal/health.h), even if the disk is
 * full, too. So after such a failure the reserve is of no use, and its users do not try again. */
static bool may_sync(const struct pen_sqlite_store *store)
{
    return !(store->base.faults >> PEN_FAULT_IO & 1);
}

bool pen_sqlite_reserve_for_index(struct pen_sqlite_store *store)
{
    const int64_t lacks = pen_sqlite_index_lacks(store);
    return may_sync(store) && lacks > 0 && cut_reserve(store, lacks) > 0;
}

bool pen_sqlite_reserve_for_file(struct pen_sqlite_store *store)
{
    const int64_t lacks = file_lacks(store);
    if (!may_sync(store) || cut_reserve(store, lacks > 0 ? lacks : reserve_part(store)) == 0)
        return false;
    if (lacks > 0)
        lengthen_file(store);
    return may_sync(store);
}

/* If the log can be copied, or as far as its readers let it, it is not the file that lacks space
 * but the log's index or else the log. */
bool pen_sqlite_reserve_move(struct pen_driver *driver)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct pen_status st;
    if (!may_sync(store))
        return false;
    if (!pen_sqlite_checkpoint(driver, &st))
        return st.code == PEN_STORAGE_FULL && pen_sqlite_reserve_for_file(store);
    if (pen_sqlite_reserve_for_index(store)) {
        lengthen_index(store);
        return true;
    }
    const int64_t cut = cut_reserve(store, reserve_part(store));
    if (cut > 0)
        lengthen_log(store, cut);
    return cut > 0;
}

bool pen_sqlite_reserve_is_out(struct pen_driver *driver)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    int64_t bytes = 0;
    if (!pen_sqlite_log_fits(store))
        return true;
    int fd = open_reserve(store, 0, &bytes);
    if (fd < 0)
        return false;
    close(fd);
    return bytes < pen_sqlite_reserve_bytes(store);
}

bool pen_sqlite_meta_get(struct pen_driver *driver, const char *name, int64_t *value,
                         struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_META_GET);
    pen_sqlite_text(&query, name);
    return pen_sqlite_value(&query, value, st);
}

bool pen_sqlite_meta_put(struct pen_driver *driver, const char *name, int64_t value,
                         struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_META_PUT);
    pen_sqlite_text(&query, name);
    pen_sqlite_int(&query, value);
    return pen_sqlite_run(&query, st);
}
