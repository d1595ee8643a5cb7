/* SPDX-License-Identifier: MIT */
/* The space that the store and its disk have, and the reserve: a file beside the store, ending in
 * -reserve, whose only use is to be cut when the disk is full. Then there is space for what frees
 * more: cancelling and removing jobs. It is made whole again before new jobs are taken. Its size
 * lets a log of the length that checkpoint.c allows be copied into the store. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "store/sqlite/sqlite.h"

enum {
    RESERVE_PART = 64, /* of the disk, within these bounds */
    RELEASES = 8,
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

/* Opens the reserve; *bytes is its length. Returns -1 with errno. */
static int open_reserve(const struct pen_sqlite_store *store, int flags, int64_t *bytes)
{
    char path[PEN_SQLITE_PATH_BYTES];
    struct stat info;
    pen_sqlite_path(store, "-reserve", path);
    int fd = open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW | flags, 0600);
    if (fd < 0)
        return -1;
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

bool pen_sqlite_reserve_release(struct pen_driver *driver)
{
    int64_t bytes = 0;
    int fd = open_reserve(pen_sqlite_of(driver), 0, &bytes);
    int64_t left = bytes - pen_sqlite_reserve_bytes(pen_sqlite_of(driver)) / RELEASES;
    bool released = fd >= 0 && bytes > 0 && ftruncate(fd, left > 0 ? (off_t)left : 0) == 0;
    if (fd >= 0)
        close(fd);
    return released;
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
