/* SPDX-License-Identifier: MIT */
/* Stored times that lie in the future, since the clock was set back. */
#include "store/sqlite/sqlite.h"

bool pen_sqlite_times_ahead(struct pen_driver *driver, int64_t now_ms, bool *any,
                            struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_TIMES_AHEAD);
    pen_sqlite_int(&query, now_ms);
    if (!pen_sqlite_next(&query, any, st))
        return false;
    if (*any)
        pen_sqlite_end(&query);
    return true;
}

bool pen_sqlite_times_mend(struct pen_driver *driver, int64_t now_ms, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    return pen_sqlite_run_with(store, SQL_PEERS_MEND, now_ms, st) &&
           pen_sqlite_run_with(store, SQL_WORKERS_MEND, now_ms, st) &&
           pen_sqlite_run_with(store, SQL_LEASES_MEND, now_ms, st);
}
