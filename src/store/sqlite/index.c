/* SPDX-License-Identifier: MIT */
/* The log's index: the file ending in -shm, in which processes find the pages that the log has. It
 * grows with the log by parts of 32 KiB, each for 4096 pages; of the first part 34 pages' worth is
 * a header. Source: SQLite, "WAL-mode File Format", section 2.
 *
 * SQLite makes it longer in the middle of a commit, after the log was written and synced. If the
 * disk was full then, the commit would have failed, but a later recovery could find its transaction
 * in the log. So it is made longer before, when a transaction begins, for more pages than any
 * transaction writes. If that fails nothing has happened, and the reserve can be used for it. */
#include <errno.h>

#include "store/sqlite/sqlite.h"

enum {
    PART_BYTES = 32768,
    PART_PAGES = 4096,
    HEADER_PAGES = 34,
    AHEAD_PAGES = 4096, /* a transaction writes one range of a value, and rows */
    FRAME_BYTES = PEN_SQLITE_PAGE_BYTES + 24
};
_Static_assert((size_t)AHEAD_PAGES *PEN_SQLITE_PAGE_BYTES >= 4 * (size_t)PEN_BLOB_RANGE_BYTES,
               "a transaction may write more pages than the index has places for");

static int64_t parts_for(int64_t log_bytes)
{
    const int64_t pages = HEADER_PAGES + log_bytes / FRAME_BYTES + AHEAD_PAGES;
    return (pages + PART_PAGES - 1) / PART_PAGES;
}

int64_t pen_sqlite_index_lacks(const struct pen_sqlite_store *store)
{
    int64_t log_bytes, bytes;
    pen_sqlite_file_bytes(store, "-wal", &log_bytes);
    pen_sqlite_file_bytes(store, "-shm", &bytes);
    const int64_t lacks = parts_for(log_bytes) * PART_BYTES - bytes;
    return lacks > 0 ? lacks : 0;
}

bool pen_sqlite_index_lacks_space(const struct pen_sqlite_store *store)
{
    return pen_sqlite_free_bytes(store) < PART_BYTES;
}

/* Through SQLite's own descriptor: closing another one would drop the locks that this process has
 * of the file. Only who has the write lock may do it, since SQLite writes to each new page. */
static bool lengthen(struct pen_sqlite_store *store, int64_t parts, struct pen_status *st)
{
    sqlite3_file *file = NULL;
    void volatile *mapped = NULL;
    sqlite3_file_control(store->db, "main", SQLITE_FCNTL_FILE_POINTER, &file);
    errno = 0;
    const int rc = file->pMethods->xShmMap(file, (int)parts - 1, PART_BYTES, 1, &mapped);
    if (rc != SQLITE_OK)
        return pen_sqlite_io_error(store, rc, errno, st);
    store->index_parts = parts;
    return true;
}

bool pen_sqlite_index_keep_ahead(struct pen_sqlite_store *store, struct pen_status *st)
{
    sqlite3_file *log = NULL;
    sqlite3_int64 log_bytes = 0;
    sqlite3_file_control(store->db, "main", SQLITE_FCNTL_JOURNAL_POINTER, &log);
    const int rc = log->pMethods->xFileSize(log, &log_bytes);
    if (rc != SQLITE_OK)
        return pen_sqlite_error(store, rc, st);
    const int64_t parts = parts_for(log_bytes);
    return parts <= store->index_parts || lengthen(store, parts, st);
}
