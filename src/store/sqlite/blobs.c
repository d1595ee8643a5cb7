/* SPDX-License-Identifier: MIT */
/* Blobs in ranges, by SQLite's incremental input and output; a blob of one range is written with
 * its row. Those in large objects are read from their parts (objects.c). Source:
 * https://www.sqlite.org/c3ref/blob_open.html */
#include <stdio.h>

#include "store/sqlite/sqlite.h"

static const struct {
    const char *table, *column;
    enum pen_sqlite_sql part; /* reads a part of its large object; SQL_COUNT: it never has one */
} places[] = {
    /* where the blobs of each kind are stored */
    [PEN_BLOB_SCENE] = {.table = "scene", .column = "document", .part = SQL_COUNT},
    [PEN_BLOB_PIXELS] = {.table = "pixels", .column = "data", .part = SQL_PIXELS_PART},
    [PEN_BLOB_ARTEFACT] = {.table = "artefact", .column = "data", .part = SQL_ARTEFACT_PART},
};

/* Opens a blob for one range of it. */
static bool open_blob(struct pen_sqlite_store *store, enum pen_blob_kind kind, int64_t number,
                      bool write, sqlite3_blob **blob, struct pen_status *st)
{
    int rc = sqlite3_blob_open(store->db, "main", places[kind].table, places[kind].column, number,
                               write, blob);
    if (rc == SQLITE_OK)
        return true;
    if (rc == SQLITE_ERROR)
        return pen_fail(st, PEN_NOT_FOUND, "%s %lld is not stored", places[kind].table,
                        (long long)number);
    return pen_sqlite_error(store, rc, st);
}

static bool is_within(sqlite3_blob *blob, size_t offset, size_t bytes)
{
    size_t total = (size_t)sqlite3_blob_bytes(blob);
    return bytes <= total && offset <= total - bytes;
}

bool pen_sqlite_blob_write(struct pen_driver *driver, enum pen_blob_kind kind, int64_t number,
                           size_t offset, const void *data, size_t bytes, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    sqlite3_blob *blob = NULL;
    if (!open_blob(store, kind, number, true, &blob, st))
        return false;
    int rc = is_within(blob, offset, bytes)
                 ? sqlite3_blob_write(blob, data, (int)bytes, (int)offset)
                 : SQLITE_RANGE;
    bool ok = rc == SQLITE_OK || pen_sqlite_error(store, rc, st);
    sqlite3_blob_close(blob);
    return ok;
}

/* The row is there, and what it should have is not, or not all of it. */
static bool is_shorter(enum pen_blob_kind kind, int64_t number, size_t bytes, struct pen_status *st)
{
    return pen_fail(st, PEN_STORAGE, "%s %lld is damaged: it is shorter than %zu bytes",
                    places[kind].table, (long long)number, bytes);
}

bool pen_sqlite_blob_read(struct pen_driver *driver, enum pen_blob_kind kind, int64_t number,
                          size_t offset, void *to, size_t bytes, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    sqlite3_blob *blob = NULL;
    size_t got = 0;
    bool ok;
    if (places[kind].part != SQL_COUNT &&
        !pen_sqlite_object_read(store, places[kind].part, number, offset, to, bytes, &got, st))
        return false;
    if (got > 0)
        return got == bytes || is_shorter(kind, number, offset + bytes, st);
    if (!open_blob(store, kind, number, false, &blob, st))
        return false;
    if (is_within(blob, offset, bytes)) {
        int rc = sqlite3_blob_read(blob, to, (int)bytes, (int)offset);
        ok = rc == SQLITE_OK || pen_sqlite_error(store, rc, st);
    } else {
        ok = is_shorter(kind, number, offset + bytes, st);
    }
    sqlite3_blob_close(blob);
    return ok;
}

bool pen_sqlite_blob_next(struct pen_driver *driver, enum pen_blob_kind kind, int64_t after,
                          struct pen_blob_row *row, bool *found, struct pen_status *st)
{
    static const enum pen_sqlite_sql statements[] = {[PEN_BLOB_SCENE] = SQL_NEXT_SCENE,
                                                     [PEN_BLOB_PIXELS] = SQL_NEXT_PIXELS,
                                                     [PEN_BLOB_ARTEFACT] = SQL_NEXT_ARTEFACT};
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), statements[kind]);
    pen_sqlite_int(&query, after);
    if (!pen_sqlite_next(&query, found, st))
        return false;
    if (!*found)
        return true;
    *row = (struct pen_blob_row){
        .number = pen_sqlite_column_int(&query, 0),
        .bytes = (size_t)pen_sqlite_column_int(&query, 1),
        .pixels = pen_sqlite_column_int(&query, 2),
        .checksum = pen_sqlite_column_int(&query, 3),
        .has_checksum = sqlite3_column_type(query.stmt, 3) != SQLITE_NULL,
    };
    const char *job = pen_sqlite_column_text(&query, 4);
    snprintf(row->job, sizeof row->job, "%s", job ? job : "");
    snprintf(row->name, sizeof row->name, "%s", pen_sqlite_column_text(&query, 5));
    pen_sqlite_end(&query);
    return true;
}

/* Binds a new blob. One of several ranges is bound as zeros, which the ranges then replace; nothing
 * is bound for one in a large object. */
static void bind_start(struct pen_sqlite_query *query, const struct pen_blob_start *start)
{
    if (start->object > 0)
        pen_sqlite_blob(query, "", 0);
    else if (start->bytes == start->total)
        pen_sqlite_blob(query, start->data, start->bytes);
    else if (query->rc == SQLITE_OK)
        query->rc = sqlite3_bind_zeroblob64(query->stmt, ++query->bound, start->total);
}

static void bind_object(struct pen_sqlite_query *query, const struct pen_blob_start *start)
{
    if (start->object > 0)
        pen_sqlite_int(query, start->object);
    else
        pen_sqlite_text(query, NULL);
}

static bool write_start(struct pen_driver *driver, enum pen_blob_kind kind, int64_t number,
                        const struct pen_blob_start *start, struct pen_status *st)
{
    if (start->object > 0)
        return pen_sqlite_object_use(pen_sqlite_of(driver), start->object, st);
    if (start->bytes == start->total)
        return true;
    return pen_sqlite_blob_write(driver, kind, number, 0, start->data, start->bytes, st);
}

bool pen_sqlite_scene_add(struct pen_driver *driver, const unsigned char sha256[32],
                          const struct pen_blob_start *document, int64_t *number, bool *added,
                          struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    if (!pen_sqlite_blob_fits(store, document->total, document->total, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_SCENE_ADD);
    pen_sqlite_blob(&query, sha256, 32);
    bind_start(&query, document);
    if (!pen_sqlite_run_changed(&query, added, st))
        return false;
    if (!*added)
        return true;
    *number = sqlite3_last_insert_rowid(store->db);
    return write_start(driver, PEN_BLOB_SCENE, *number, document, st);
}

bool pen_sqlite_scene_of_job(struct pen_driver *driver, const char *id, int64_t *number,
                             size_t *bytes, bool *found, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_SCENE_OF_JOB);
    pen_sqlite_text(&query, id);
    if (!pen_sqlite_next(&query, found, st))
        return false;
    if (*found) {
        *number = pen_sqlite_column_int(&query, 0);
        *bytes = (size_t)pen_sqlite_column_int(&query, 1);
        pen_sqlite_end(&query);
    }
    return true;
}

bool pen_sqlite_pixels_add(struct pen_driver *driver, int64_t batch,
                           const struct pen_blob_start *pixels, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_PIXELS_ADD);
    pen_sqlite_int(&query, batch);
    bind_start(&query, pixels);
    bind_object(&query, pixels);
    return pen_sqlite_run(&query, st) && write_start(driver, PEN_BLOB_PIXELS, batch, pixels, st);
}

bool pen_sqlite_pixels_page(struct pen_driver *driver, int64_t job, int view, int64_t after,
                            struct pen_pixels_row *rows, int capacity, int *count,
                            struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_PIXELS_PAGE);
    bool ok;
    pen_sqlite_int(&query, job);
    pen_sqlite_int(&query, view);
    pen_sqlite_int(&query, after);
    pen_sqlite_int(&query, capacity);
    *count = 0;
    while (pen_sqlite_next_row(&query, &ok, st))
        rows[(*count)++] = (struct pen_pixels_row){
            .batch = pen_sqlite_column_int(&query, 0),
            .pixels = pen_sqlite_column_int(&query, 1),
            .first_tile = (int)pen_sqlite_column_int(&query, 2),
            .tile_count = (int)pen_sqlite_column_int(&query, 3),
            .bytes = (size_t)pen_sqlite_column_int(&query, 4),
        };
    return ok;
}

static void bind_layer(struct pen_sqlite_query *query, const struct pen_artefact_key *key)
{
    pen_sqlite_int(query, key->job);
    pen_sqlite_int(query, key->view);
    pen_sqlite_text(query, key->layer);
}

static void bind_artefact(struct pen_sqlite_query *query, const struct pen_artefact_key *key)
{
    bind_layer(query, key);
    pen_sqlite_text(query, key->format);
}

bool pen_sqlite_artefact_put(struct pen_driver *driver, const struct pen_artefact_key *key,
                             int64_t checksum, const struct pen_blob_start *data, int64_t *number,
                             struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_ARTEFACT_PUT);
    bool row;
    bind_artefact(&query, key);
    bind_start(&query, data);
    pen_sqlite_int(&query, checksum);
    bind_object(&query, data);
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (!row)
        return pen_fail(st, PEN_INTERNAL, "an artefact was stored without a number");
    *number = pen_sqlite_column_int(&query, 0);
    return pen_sqlite_run(&query, st) && write_start(driver, PEN_BLOB_ARTEFACT, *number, data, st);
}

bool pen_sqlite_artefacts_drop(struct pen_driver *driver, const struct pen_artefact_key *key,
                               struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_ARTEFACTS_DROP);
    bind_layer(&query, key);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_job_artefacts_drop(struct pen_driver *driver, int64_t job, const char *layer,
                                   struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_JOB_ARTEFACTS_DROP);
    pen_sqlite_int(&query, job);
    pen_sqlite_text(&query, layer);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_artefact_find(struct pen_driver *driver, const struct pen_artefact_key *key,
                              struct pen_artefact_row *artefact, bool *found, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_ARTEFACT_FIND);
    bind_artefact(&query, key);
    if (!pen_sqlite_next(&query, found, st))
        return false;
    if (*found) {
        *artefact = (struct pen_artefact_row){
            .number = pen_sqlite_column_int(&query, 0),
            .checksum = pen_sqlite_column_int(&query, 1),
            .has_checksum = sqlite3_column_type(query.stmt, 1) != SQLITE_NULL,
            .bytes = (size_t)pen_sqlite_column_int(&query, 2),
            .cached = sqlite3_column_type(query.stmt, 3) != SQLITE_NULL,
            .used_ms = pen_sqlite_column_int(&query, 3)};
        pen_sqlite_end(&query);
    }
    return true;
}
