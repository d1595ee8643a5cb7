/* SPDX-License-Identifier: MIT */
/* The log's index: the file ending in -shm, in which processes find the pages that the log has. It
 * has parts of 32 KiB, each for 4096 pages; in the first part a header takes the place of 34 of
 * them. Source: SQLite, "WAL-mode File Format", section 2.
 *
 * SQLite makes the index longer in the middle of a commit, after the log was written and synced. If
 * that failed on a full disk, nobody would know the outcome: a later recovery could find the
 * transaction in the log. So it is made longer when a transaction begins:
 *  - By AHEAD_PAGES, if the disk has space for them. Transactions write less.
 *  - If it has not, for the log as long as its file is, which cannot grow by much on that disk. If
 *    there is no space for these either, the transaction fails, and nothing has happened. */
#include <errno.h>

#include "store/sqlite/sqlite.h"

enum {
    PART_BYTES = 32768,
    PART_PAGES = 4096,
    HEADER_PAGES = 34,
    AHEAD_PAGES = 2048, /* what space is returned with writes most: 256 pages moved, each by 6 */
    LEAST_PAGES = 64,
    FRAME_BYTES = PEN_SQLITE_PAGE_BYTES + 24
};

/* How many parts there must be for a log of so many bytes and so many pages more. */
static int64_t parts_for(int64_t log_bytes, int64_t more_pages)
{
    const int64_t pages = HEADER_PAGES + log_bytes / FRAME_BYTES + more_pages;
    return (pages + PART_PAGES - 1) / PART_PAGES;
}

int64_t pen_sqlite_index_lacks(const struct pen_sqlite_store *store)
{
    int64_t log_bytes, bytes;
    pen_sqlite_file_bytes(store, "-wal", &log_bytes);
    pen_sqlite_file_bytes(store, "-shm", &bytes);
    const int64_t whole = bytes / PEN_SQLITE_PAGE_BYTES * PEN_SQLITE_PAGE_BYTES,
                  lacks = parts_for(log_bytes, LEAST_PAGES) * PART_BYTES - whole;
    return lacks > 0 ? lacks : 0;
}

/* Through SQLite's own descriptor: closing another one would drop the locks that this process has
 * of the file. Only who has the write lock may do it, since SQLite writes to each new page. Returns
 * SQLite's code, and errno is that of a failure. */
static int lengthen(struct pen_sqlite_store *store, int64_t parts)
{
    sqlite3_file *file = NULL;
    void volatile *mapped = NULL;
    if (parts <= store->index_parts)
        return SQLITE_OK;
    sqlite3_file_control(store->db, "main", SQLITE_FCNTL_FILE_POINTER, &file);
    errno = 0;
    const int rc = file->pMethods->xShmMap(file, (int)parts - 1, PART_BYTES, 1, &mapped);
    if (rc == SQLITE_OK)
        store->index_parts = parts;
    return rc;
}

bool pen_sqlite_index_keep_ahead(struct pen_sqlite_store *store, struct pen_status *st)
{
    sqlite3_file *log = NULL;
    sqlite3_int64 log_bytes = 0;
    sqlite3_file_control(store->db, "main", SQLITE_FCNTL_JOURNAL_POINTER, &log);
    if (!log || !log->pMethods) /* a file system without shared memory: there is no such log */
        return true;
    int rc = log->pMethods->xFileSize(log, &log_bytes);
    if (rc != SQLITE_OK)
        return pen_sqlite_error(store, rc, st);
    rc = lengthen(store, parts_for(log_bytes, AHEAD_PAGES));
    if (rc == SQLITE_IOERR_SHMSIZE && pen_errno_is_full(errno))
        rc = lengthen(store, parts_for(log_bytes, LEAST_PAGES));
    return rc == SQLITE_OK || pen_sqlite_io_error(store, rc, errno, st);
}

bool pen_sqlite_index_is_refused(const struct pen_sqlite_store *store)
{
    return pen_sqlite_index_lacks(store) > pen_sqlite_free_bytes(store);
}
