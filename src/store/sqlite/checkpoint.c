/* SPDX-License-Identifier: MIT */
/* The length of the write-ahead log: when it is copied into the database file (a checkpoint), and
 * when it is written from its beginning again. SQLite's own rule, a passive checkpoint every so
 * many pages, lets the log grow as long as readers overlap. So there are three lengths:
 *
 *   log_pages / 4    housekeeping copies the log, so that commits need not
 *   log_pages        commits copy it, as far as its readers allow
 *   log_pages * 3    commits also wait for readers, so that the next commit begins the log anew;
 *                    the longer the log, the longer they wait
 *
 * What the disk's being full demands:
 *  - There must be space to copy the log into the file, or nothing could be removed any more. So
 *    log_pages is small on a small disk, a quarter of the reserve. If readers keep more from being
 *    copied than the reserve and the disk have space for, the disk counts as full: submits are
 *    refused and results wait.
 *  - A log that is begun anew keeps its length, up to 8 MB or the size of the reserve, until the
 *    last handle is closed. What frees space writes there and needs none. A truncated log would
 *    leave its space to other programs. */
#include <stdio.h>

#include "store/sqlite/sqlite.h"

enum {
    LOG_PAGES = 2000, /* 8 MiB; on a disk of less than 2 GiB fewer */
    RESERVE_PART = 4,
    HOUSEKEEPING_PART = 4,
    RESTART_TIMES = 3,
    WAIT_MS = 20,       /* for readers; writers wait, too */
    WAIT_MOST_MS = 200, /* in a commit, however long the log */
    WAIT_FULL_MS = 2000 /* when the disk is full; a writer waits 5 seconds */
};

bool pen_sqlite_limit_log(struct pen_sqlite_store *store, struct pen_status *st)
{
    const int64_t reserve = pen_sqlite_reserve_bytes(store),
                  pages = reserve / RESERVE_PART / PEN_SQLITE_PAGE_BYTES,
                  kept = reserve < (int64_t)LOG_PAGES * PEN_SQLITE_PAGE_BYTES
                             ? reserve
                             : (int64_t)LOG_PAGES * PEN_SQLITE_PAGE_BYTES;
    char pragma[64];
    store->vain_pages = -1;
    store->uncopied_pages = 0;
    store->log_pages = pages < LOG_PAGES ? (int)pages : LOG_PAGES;
    snprintf(pragma, sizeof pragma, "PRAGMA journal_size_limit = %lld", (long long)kept);
    return pen_sqlite_exec(store, pragma, st);
}

static bool is_small(const struct pen_sqlite_store *store)
{
    return store->log_pages < LOG_PAGES;
}

/* Makes a checkpoint, which waits so long for locks; *copied is the number of pages of the log that
 * are in the file then, -1 if that is not known. Returns SQLite's code. */
static int checkpoint(struct pen_sqlite_store *store, int mode, int64_t wait_ms, int *copied)
{
    const int64_t patience = store->patience_ms;
    int log = -1;
    *copied = -1;
    store->patience_ms = wait_ms;
    const int rc = sqlite3_wal_checkpoint_v2(store->db, "main", mode, &log, copied);
    store->patience_ms = patience;
    store->wal_pages = 0;
    if (log >= 0 && *copied >= 0)
        store->uncopied_pages = log - *copied;
    return rc;
}

/* The same for callers whose failure it is not if it does not complete: a later one does. A fault
 * that it meets is noted. Returns whether it has completed. */
static bool try_checkpoint(struct pen_sqlite_store *store, int mode, int64_t wait_ms, int *copied)
{
    struct pen_status ignored;
    const int rc = checkpoint(store, mode, wait_ms, copied);
    if (rc != SQLITE_OK)
        pen_sqlite_error(store, rc, &ignored);
    return rc == SQLITE_OK;
}

bool pen_sqlite_checkpoint(struct pen_driver *driver, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    int copied;
    const int rc = checkpoint(store, SQLITE_CHECKPOINT_PASSIVE, 0, &copied);
    return rc == SQLITE_OK || (rc & 0xff) == SQLITE_BUSY || pen_sqlite_error(store, rc, st);
}

void pen_sqlite_truncate_log(struct pen_sqlite_store *store)
{
    int copied;
    try_checkpoint(store, SQLITE_CHECKPOINT_TRUNCATE, WAIT_MS, &copied);
}

void pen_sqlite_restart_log(struct pen_driver *driver, bool first)
{
    int copied;
    try_checkpoint(pen_sqlite_of(driver), SQLITE_CHECKPOINT_RESTART,
                   first ? WAIT_FULL_MS : WAIT_MOST_MS, &copied);
}

bool pen_sqlite_log_fits(const struct pen_sqlite_store *store)
{
    const int64_t bytes = (int64_t)store->uncopied_pages * PEN_SQLITE_PAGE_BYTES;
    return store->uncopied_pages <= RESERVE_PART * store->log_pages ||
           bytes <= pen_sqlite_free_bytes(store);
}

/* Copies the log, and waits for readers, the longer the longer the log is. On a large disk a long
 * reader, such as a backup, is waited for in vain once: while it reads, nothing more is copied than
 * at that time. On a small disk each commit waits, or the log would outgrow the reserve. */
static void copy_and_restart(struct pen_sqlite_store *store, int64_t wait_ms)
{
    int copied;
    if (!is_small(store) && store->vain_pages >= 0) {
        try_checkpoint(store, SQLITE_CHECKPOINT_PASSIVE, 0, &copied);
        if (copied == store->vain_pages)
            return;
    }
    const bool restarted = try_checkpoint(store, SQLITE_CHECKPOINT_RESTART,
                                          wait_ms < WAIT_MOST_MS ? wait_ms : WAIT_MOST_MS, &copied);
    store->vain_pages = restarted ? -1 : copied;
}

/* On a small disk no copying is left to another handle, which may come too late. */
void pen_sqlite_keep_log_limits(struct pen_sqlite_store *store)
{
    struct pen_status ignored;
    const bool delegates = store->base.delegates_checkpoints && !is_small(store);
    const int pages = store->wal_pages, restart = RESTART_TIMES * store->log_pages;
    int copied;
    store->base.checkpoint_due = pages >= store->log_pages;
    if (pages >= restart)
        copy_and_restart(store, (int64_t)WAIT_MS * pages / restart);
    else if (store->base.checkpoint_due && !delegates)
        try_checkpoint(store, SQLITE_CHECKPOINT_PASSIVE, 0, &copied);
    else
        return;
    if (!pen_sqlite_log_fits(store))
        pen_sqlite_io_error(store, SQLITE_FULL, 0, &ignored);
}

bool pen_sqlite_keep_log_short(struct pen_driver *driver, struct pen_status *st)
{
    const struct pen_sqlite_store *store = pen_sqlite_of(driver);
    return store->wal_pages < store->log_pages / HOUSEKEEPING_PART ||
           pen_sqlite_checkpoint(driver, st);
}
