/* SPDX-License-Identifier: MIT */
/* The driver's operations on the handle as a whole: clock, signals, trial writes, free space. */
#include "base/clock.h"
#include "store/sqlite/sqlite.h"
#include "store/sqlite/wake.h"

bool pen_sqlite_now(struct pen_driver *driver, int64_t *now_ms, struct pen_status *st)
{
    (void)st;
    *now_ms = driver->clock ? driver->clock(driver->clock_user) : pen_clock_wall_ms();
    return true;
}

void pen_sqlite_wait(struct pen_driver *driver, enum pen_signal signal, uint32_t *seen,
                     int timeout_ms)
{
    pen_wake_wait(pen_sqlite_of(driver)->wake, signal, seen, timeout_ms);
}

void pen_sqlite_wake(struct pen_driver *driver, enum pen_signal signal)
{
    pen_wake_all(pen_sqlite_of(driver)->wake, signal);
}

_Atomic uint32_t *pen_sqlite_health_words(struct pen_driver *driver)
{
    return pen_wake_words(pen_sqlite_of(driver)->wake);
}

_Atomic uint64_t *pen_sqlite_tallies(struct pen_driver *driver)
{
    return pen_wake_tallies(pen_sqlite_of(driver)->wake);
}

bool pen_sqlite_repair_lock(struct pen_driver *driver, int *lock)
{
    return pen_wake_try_lock(pen_sqlite_of(driver)->wake, lock);
}

void pen_sqlite_repair_unlock(struct pen_driver *driver, int lock)
{
    (void)driver;
    pen_wake_unlock(lock);
}

bool pen_sqlite_probe(struct pen_driver *driver, struct pen_status *st)
{
    if (!pen_sqlite_begin_write(driver, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_PROBE);
    pen_sqlite_int(&query, pen_clock_wall_ms());
    if (pen_sqlite_run(&query, st) && pen_sqlite_commit(driver, st))
        return true;
    pen_sqlite_rollback(driver);
    return false;
}

/* What must be free beside the reserve before new jobs are taken. */
enum { SPACE_BYTES = 1 << 20 };

/* If copying the log fails for lack of space, the reserve is used for it. A trial write begins
 * the log anew, which makes a long one short. It proves nothing about space, since it overwrites
 * what is there, so that is tried afterwards, when the reserve is made whole. */
bool pen_sqlite_space(struct pen_driver *driver, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    while (!pen_sqlite_checkpoint(driver, st)) {
        if (st->code != PEN_STORAGE_FULL || !pen_sqlite_reserve_for_file(store))
            return false;
    }
    if (!pen_sqlite_log_fits(store))
        return pen_sqlite_io_error(store, SQLITE_FULL, 0, st);
    if (!pen_sqlite_probe(driver, st))
        return false;
    return pen_sqlite_reserve_allocate(store, SPACE_BYTES, st) ||
           (st->code != PEN_STORAGE_FULL && pen_sqlite_free_bytes(store) >= SPACE_BYTES);
}

/* Of one call of reclaim, so that writers get their turn. */
enum { RECLAIM_PAGES = 256, RECLAIM_MS = 10, PAGES_CHANGED = 6 /* at most, to move one */ };

/* How many pages can be moved, if the log grows only into what is free of the disk. */
static int64_t pages_that_fit(const struct pen_sqlite_store *store)
{
    int64_t log_bytes;
    pen_sqlite_file_bytes(store, "-wal", &log_bytes);
    return (log_bytes + pen_sqlite_free_bytes(store)) / (PAGES_CHANGED * PEN_SQLITE_PAGE_BYTES);
}

/* How many pages one call may move. The log is not made longer than it is kept, and on a full disk
 * not longer than it is: for that its pages must have been copied. Only a log that has no room at
 * all takes a part of the reserve, which it keeps up to its usual length. */
static bool reclaim_most(struct pen_sqlite_store *store, int64_t *most, struct pen_status *st)
{
    int64_t fit = pages_that_fit(store);
    *most = store->log_pages < RECLAIM_PAGES ? store->log_pages : RECLAIM_PAGES;
    if (pen_sqlite_index_is_refused(store))
        pen_sqlite_reserve_move(&store->base);
    if (fit >= *most)
        return true;
    if (fit < 2 && pen_sqlite_reserve_move(&store->base))
        fit = pages_that_fit(store);
    *most = fit > 1 ? fit : 1;
    return pen_sqlite_checkpoint(&store->base, st);
}

/* Moves pages from the end of the file into free pages. SQLite looks for the place of a page in the
 * list of free pages: with gigabytes in that list, a page takes some milliseconds. */
static bool move_pages(struct pen_sqlite_store *store, int64_t pages, struct pen_status *st)
{
    const int64_t until_ns = pen_clock_ns() + RECLAIM_MS * INT64_C(1000000);
    for (int64_t i = 0; i < pages && pen_clock_ns() < until_ns; i++) {
        struct pen_sqlite_query vacuum = pen_sqlite_query(store, SQL_VACUUM);
        if (!pen_sqlite_run(&vacuum, st))
            return false;
    }
    return true;
}

static bool count_free_pages(struct pen_sqlite_store *store, int64_t *pages, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_FREE_PAGES);
    return pen_sqlite_value(&query, pages, st);
}

/* The file shrinks when the log is copied into it. */
bool pen_sqlite_reclaim(struct pen_driver *driver, bool *more, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    int64_t pages, most, left;
    *more = false;
    if (!count_free_pages(store, &pages, st))
        return false;
    if (pages == 0)
        return pen_sqlite_checkpoint(driver, st);
    if (!reclaim_most(store, &most, st) || !pen_sqlite_begin_write(driver, st))
        return false;
    if (count_free_pages(store, &pages, st) && move_pages(store, pages < most ? pages : most, st) &&
        count_free_pages(store, &left, st) && pen_sqlite_commit(driver, st)) {
        *more = left < pages;
        return true;
    }
    pen_sqlite_rollback(driver);
    return false;
}
