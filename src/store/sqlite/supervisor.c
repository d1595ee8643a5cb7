/* SPDX-License-Identifier: MIT */
/* The lock of the store's only supervisor: an open file description lock (fcntl(2), F_OFD_SETLK) on
 * one byte of the store's own file. So it is found by whatever name the file is opened, and is gone
 * only with the store, unlike a lock on a file beside it, which may be removed.
 *
 * The byte is the last one of the page that SQLite keeps free for its own locks, which are the
 * first 512 bytes of it (SQLite, "Database File Format", 1.4). Closing a descriptor of the file
 * drops all POSIX locks of SQLite in this process (https://www.sqlite.org/howtocorrupt.html, 2.2).
 * Therefore this one stays open until the handle has closed its database, also where the lock is
 * not had. */
#include <errno.h>
#include <fcntl.h>
#include <string.h>

#include "store/sqlite/sqlite.h"

enum { SQLITE_LOCKS_AT = 0x40000000, LOCK_AT = SQLITE_LOCKS_AT + 4095 };

bool pen_sqlite_supervise(struct pen_driver *driver, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET, .l_start = LOCK_AT, .l_len = 1};
    struct stat info;
    if (store->supervisor_fd < 0)
        store->supervisor_fd = open(store->path, O_RDWR | O_CLOEXEC);
    if (store->supervisor_fd < 0 || fstat(store->supervisor_fd, &info) != 0)
        return pen_fail(st, PEN_STORAGE, "cannot open the store %s: %s", store->path,
                        strerror(errno));
    if (!pen_sqlite_same_file(&info, &store->opened))
        return pen_fail(st, PEN_STORAGE, "another file was put in the place of the store %s",
                        store->path);
    if (fcntl(store->supervisor_fd, F_OFD_SETLK, &lock) == 0)
        return true;
    if (errno == EAGAIN || errno == EACCES)
        return pen_fail(st, PEN_CONFLICT, "another process supervises the store %s", store->path);
    return pen_fail(st, PEN_STORAGE, "cannot lock the store %s: %s", store->path, strerror(errno));
}
