/* SPDX-License-Identifier: MIT */
/* Artefacts that can be made again: which they are, and which was used longest ago. */
#include "store/sqlite/sqlite.h"

bool pen_sqlite_cached_put(struct pen_driver *driver, int64_t artefact, int64_t bytes,
                           int64_t now_ms, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_CACHED_PUT);
    pen_sqlite_int(&query, artefact);
    pen_sqlite_int(&query, bytes);
    pen_sqlite_int(&query, now_ms);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_cached_touch(struct pen_driver *driver, int64_t artefact, int64_t now_ms,
                             struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_CACHED_TOUCH);
    pen_sqlite_int(&query, artefact);
    pen_sqlite_int(&query, now_ms);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_cached_bytes(struct pen_driver *driver, int64_t *bytes, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_CACHED_BYTES);
    return pen_sqlite_value(&query, bytes, st);
}

/* The row in `cached` goes with its artefact. */
bool pen_sqlite_cached_evict(struct pen_driver *driver, int64_t *bytes, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct pen_sqlite_query first = pen_sqlite_query(store, SQL_CACHED_FIRST);
    bool row;
    if (!pen_sqlite_next(&first, &row, st))
        return false;
    if (!row) {
        *bytes = 0;
        return true;
    }
    int64_t artefact = pen_sqlite_column_int(&first, 0);
    *bytes -= pen_sqlite_column_int(&first, 1);
    pen_sqlite_end(&first);
    struct pen_sqlite_query drop = pen_sqlite_query(store, SQL_ARTEFACT_REMOVE);
    pen_sqlite_int(&drop, artefact);
    return pen_sqlite_run(&drop, st);
}
