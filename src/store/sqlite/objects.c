/* SPDX-License-Identifier: MIT */
/* Large objects: values in parts of PEN_BLOB_RANGE_BYTES, each a row. The row of an artefact or of
 * pixels that has one names it. A trigger notes when it no longer does (schema.c). */
#include <string.h>

#include "store/sqlite/sqlite.h"

/* How much of the log an object takes at a time, at most: it is copied between slices. */
enum { LOG_BYTES = 32 << 20 };

bool pen_sqlite_object_add(struct pen_driver *driver, size_t bytes, int64_t *number,
                           struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    if (!pen_sqlite_blob_fits(store, bytes, bytes < LOG_BYTES ? bytes : LOG_BYTES, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_OBJECT_ADD);
    pen_sqlite_int(&query, (int64_t)bytes);
    if (!pen_sqlite_run(&query, st))
        return false;
    *number = sqlite3_last_insert_rowid(store->db);
    return true;
}

bool pen_sqlite_object_write(struct pen_driver *driver, int64_t number, size_t offset,
                             const void *data, size_t bytes, int64_t expires_ms, bool *there,
                             struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct pen_sqlite_query touch = pen_sqlite_query(store, SQL_OBJECT_TOUCH);
    pen_sqlite_int(&touch, number);
    pen_sqlite_int(&touch, expires_ms > 0 ? expires_ms : 1);
    if (!pen_sqlite_run_changed(&touch, there, st))
        return false;
    if (!*there)
        return true;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_OBJECT_PART_ADD);
    pen_sqlite_int(&query, number);
    pen_sqlite_int(&query, (int64_t)(offset / PEN_BLOB_RANGE_BYTES));
    pen_sqlite_blob(&query, data, bytes);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_object_use(struct pen_sqlite_store *store, int64_t number, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_OBJECT_USE);
    bool there;
    pen_sqlite_int(&query, number);
    return pen_sqlite_run_changed(&query, &there, st) &&
           (there || pen_fail(st, PEN_UNAVAILABLE, "a value that was being stored took too long"));
}

bool pen_sqlite_object_release(struct pen_driver *driver, int64_t number, struct pen_status *st)
{
    return pen_sqlite_run_with(pen_sqlite_of(driver), SQL_OBJECT_RELEASE, number, st);
}

bool pen_sqlite_object_unused(struct pen_driver *driver, int64_t before_ms, int64_t after_ms,
                              int64_t *number, bool *found, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_OBJECT_UNUSED);
    pen_sqlite_int(&query, before_ms);
    pen_sqlite_int(&query, after_ms);
    if (!pen_sqlite_next(&query, found, st))
        return false;
    if (*found) {
        *number = pen_sqlite_column_int(&query, 0);
        pen_sqlite_end(&query);
    }
    return true;
}

bool pen_sqlite_object_released_bytes(struct pen_driver *driver, int64_t *bytes,
                                      struct pen_status *st)
{
    struct pen_sqlite_query query =
        pen_sqlite_query(pen_sqlite_of(driver), SQL_OBJECT_RELEASED_BYTES);
    pen_sqlite_int(&query, PEN_BLOB_RANGE_BYTES);
    return pen_sqlite_value(&query, bytes, st);
}

bool pen_sqlite_object_shrink(struct pen_driver *driver, int64_t number, int64_t bytes,
                              struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_OBJECT_PARTS_REMOVE);
    const int64_t parts = bytes / PEN_BLOB_RANGE_BYTES;
    const int limit = parts > 1 ? (int)parts : 1;
    bool more;
    pen_sqlite_int(&query, number);
    return pen_sqlite_object_release(driver, number, st) &&
           pen_sqlite_run_limited(&query, limit, &more, st) &&
           (more || pen_sqlite_run_with(store, SQL_OBJECT_REMOVE, number, st));
}

/* Copies what part `part` has of a range that begins at `offset`, which is in that part; *bytes is
 * how much that was, 0: there is no such part. */
static bool read_part(struct pen_sqlite_store *store, enum pen_sqlite_sql sql, int64_t number,
                      size_t offset, void *to, size_t *bytes, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, sql);
    const size_t within = offset % PEN_BLOB_RANGE_BYTES;
    bool row;
    pen_sqlite_int(&query, number);
    pen_sqlite_int(&query, (int64_t)(offset / PEN_BLOB_RANGE_BYTES));
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (!row) {
        *bytes = 0;
        return true;
    }
    const struct pen_bytes part = pen_sqlite_column_blob(&query, 0);
    const size_t there = part.bytes > within ? part.bytes - within : 0;
    *bytes = there < *bytes ? there : *bytes;
    const bool ok = part.data || sqlite3_column_bytes(query.stmt, 0) == 0;
    if (ok && *bytes > 0)
        memcpy(to, (const char *)part.data + within, *bytes);
    pen_sqlite_end(&query);
    return ok || pen_fail(st, PEN_NO_MEMORY, "no memory for a stored value");
}

bool pen_sqlite_object_read(struct pen_sqlite_store *store, enum pen_sqlite_sql sql, int64_t number,
                            size_t offset, void *to, size_t bytes, size_t *got,
                            struct pen_status *st)
{
    size_t n = 1;
    for (*got = 0; *got < bytes && n > 0; *got += n) {
        n = bytes - *got;
        if (!read_part(store, sql, number, offset + *got, (char *)to + *got, &n, st))
            return false;
    }
    return true;
}
