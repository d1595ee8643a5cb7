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

static bool write_probe(struct pen_driver *driver, enum pen_sqlite_sql sql, struct pen_status *st)
{
    if (!pen_sqlite_begin_write(driver, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), sql);
    pen_sqlite_int(&query, pen_clock_wall_ms());
    if (pen_sqlite_run(&query, st) && pen_sqlite_commit(driver, st))
        return true;
    pen_sqlite_rollback(driver);
    return false;
}

bool pen_sqlite_probe(struct pen_driver *driver, struct pen_status *st)
{
    return write_probe(driver, SQL_PROBE, st);
}

/* Writes a large row and then a small one in its place. Overwriting an existing log would prove
 * nothing about space on the disk, so the log is truncated first. A reserve that was given up is
 * set aside again. */
bool pen_sqlite_space(struct pen_driver *driver, struct pen_status *st)
{
    pen_sqlite_truncate_log(pen_sqlite_of(driver));
    return write_probe(driver, SQL_PROBE_LARGE, st) && write_probe(driver, SQL_PROBE, st) &&
           (!pen_sqlite_reserve_is_out(driver) || pen_sqlite_reserve_make(driver, st));
}

/* The length of the log from which housekeeping copies it, before a submit has to. */
enum { LOG_PAGES = 500 };

bool pen_sqlite_keep_log_short(struct pen_driver *driver, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    if (store->wal_pages < LOG_PAGES)
        return true;
    store->wal_pages = 0;
    return pen_sqlite_checkpoint(driver, st);
}

/* Of one call of reclaim, so that writers get their turn. */
enum { RECLAIM_PAGES = 256, RECLAIM_MS = 10 };

/* Moves pages from the end of the file into free pages. SQLite looks for the place of a page in the
 * list of free pages, which is long after the removal of gigabytes: the first pages take some
 * milliseconds each. */
static bool move_pages(struct pen_sqlite_store *store, int64_t pages, struct pen_status *st)
{
    const int64_t until_ns = pen_clock_ns() + RECLAIM_MS * INT64_C(1000000);
    for (int i = 0; i < pages && i < RECLAIM_PAGES && pen_clock_ns() < until_ns; i++) {
        struct pen_sqlite_query vacuum = pen_sqlite_query(store, SQL_VACUUM);
        if (!pen_sqlite_run(&vacuum, st))
            return false;
    }
    return true;
}

/* The file shrinks when the log is copied into it. */
bool pen_sqlite_reclaim(struct pen_driver *driver, bool *more, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct pen_sqlite_query unused = pen_sqlite_query(store, SQL_FREE_PAGES);
    int64_t pages;
    if (!pen_sqlite_value(&unused, &pages, st))
        return false;
    *more = pages > 0;
    if (!*more)
        return pen_sqlite_checkpoint(driver, st);
    if (!pen_sqlite_begin_write(driver, st))
        return false;
    if (move_pages(store, pages, st) && pen_sqlite_commit(driver, st))
        return true;
    pen_sqlite_rollback(driver);
    return false;
}
