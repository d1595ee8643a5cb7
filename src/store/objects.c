/* SPDX-License-Identifier: MIT */
/* Values of any length (internal/objects.h), and scene documents, which are values too. */
#include "store/internal/objects.h"

#include <stdio.h>

static bool gone_meanwhile(struct pen_status *st)
{
    return pen_fail(st, PEN_UNAVAILABLE, "a value that was being written was removed meanwhile");
}

#define ADD_OBJECT                                                                                 \
    "INSERT INTO object (job, view, batch, attempt, layer, format, state, bytes, checksum, "       \
    "touched_ms, cached, used_ms) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, "                    \
    "(SELECT now_ms()), $10, (SELECT now_ms()))"

/* The number of a value in use is found by its owner, which costs SQLite less than RETURNING. */
static bool add_object(struct pen_store *store, const struct pen_object_owner *owner, int64_t state,
                       const void *data, size_t bytes, int64_t *number, struct pen_status *st)
{
    const int64_t checksum = pen_checksum(data, bytes), view = owner->view, cached = owner->cached;
    return state == 1 && owner->job > 0
               ? pen_db_run(store->db, st, NULL, ADD_OBJECT, "iiiittiiii", owner->job, view,
                            owner->batch, owner->attempt, owner->layer, owner->format, state,
                            (int64_t)bytes, checksum, cached) &&
                     pen_object_find(store, owner, number, st)
               : pen_db_value(store->db, st, number, ADD_OBJECT " RETURNING number", "iiiittiiii",
                              owner->job, view, owner->batch, owner->attempt, owner->layer,
                              owner->format, state, (int64_t)bytes, checksum, cached);
}

static bool add_part(struct pen_store *store, int64_t number, int64_t n, const void *data,
                     size_t bytes, struct pen_status *st)
{
    return pen_db_run(store->db, st, NULL, "INSERT INTO part (object, n, data) VALUES ($1, $2, $3)",
                      "iib", number, n, data, bytes);
}

/* Only reads: a value under a claim that was lost meanwhile is not used, and is collected. */
static bool check_claim(struct pen_store *store, const struct pen_claim *claim,
                        struct pen_status *st)
{
    int64_t held = 1;
    return (!claim ||
            pen_db_value(store->db, st, &held,
                         "SELECT 1 FROM batch WHERE number = $1 AND attempt = $2 AND state = 1",
                         "ii", claim->batch, claim->attempt)) &&
           (held || pen_fail(st, PEN_STALE, "the batch is no longer held; its value is dropped"));
}

static bool touch(struct pen_store *store, int64_t number, struct pen_status *st)
{
    int64_t changed;
    return pen_db_run(store->db, st, &changed,
                      "UPDATE object SET touched_ms = (SELECT now_ms()) "
                      "WHERE number = $1 AND state = 0",
                      "i", number) &&
           (changed > 0 || gone_meanwhile(st));
}

bool pen_object_load(struct pen_store *store, const struct pen_object_owner *owner,
                     const struct pen_claim *claim, const void *data, size_t bytes, int64_t *number,
                     struct pen_status *st)
{
    *number = 0;
    if (bytes <= PEN_PART_BYTES)
        return true;
    for (size_t at = 0; at < bytes; at += PEN_PART_BYTES) {
        const size_t size = bytes - at < PEN_PART_BYTES ? bytes - at : PEN_PART_BYTES;
        if (!pen_db_begin(store->db, PEN_DB_PART, st))
            return false;
        const bool ok = check_claim(store, claim, st) &&
                        (at > 0 ? touch(store, *number, st)
                                : add_object(store, owner, 0, data, bytes, number, st)) &&
                        add_part(store, *number, (int64_t)(at / PEN_PART_BYTES),
                                 (const char *)data + at, size, st);
        if (!pen_db_end(store->db, ok, st))
            return false;
    }
    return true;
}

/* Each batch has pixels; all else belongs to a view, and no document replaces another. */
static bool drop_used(struct pen_store *store, const struct pen_object_owner *owner,
                      struct pen_status *st)
{
    return owner->job == 0 ||
           pen_db_run(store->db, st, NULL,
                      "UPDATE object SET state = 2 WHERE job = $1 AND view = $2 AND layer = $3 AND "
                      "format = $4 AND state = 1 AND (layer <> '' OR batch = $5)",
                      "iitti", owner->job, (int64_t)owner->view, owner->layer, owner->format,
                      owner->batch);
}

static bool use(struct pen_store *store, const struct pen_object_owner *owner, int64_t *number,
                const void *data, size_t bytes, struct pen_status *st)
{
    int64_t changed;
    if (!drop_used(store, owner, st))
        return false;
    if (*number == 0)
        return add_object(store, owner, 1, data, bytes, number, st) &&
               add_part(store, *number, 0, data, bytes, st);
    return pen_db_run(store->db, st, &changed,
                      "UPDATE object SET state = 1, job = $2, used_ms = (SELECT now_ms()) "
                      "WHERE number = $1 AND state = 0",
                      "ii", *number, owner->job) &&
           (changed > 0 || gone_meanwhile(st));
}

bool pen_object_use(struct pen_store *store, const struct pen_object_owner *owner, int64_t number,
                    const void *data, size_t bytes, struct pen_status *st)
{
    return use(store, owner, &number, data, bytes, st);
}

#define OF_LAYERS                                                                                  \
    "WHERE job = $1 AND state = 1 AND (view = $2 OR $2 = -2) AND substr(layer, 1, length($3)) = "  \
    "$3"

/* There are none, most often. */
bool pen_objects_drop(struct pen_store *store, int64_t job, int view, const char *prefix,
                      struct pen_status *st)
{
    int64_t any;
    return pen_db_value(store->db, st, &any, "SELECT 1 FROM object " OF_LAYERS " LIMIT 1", "iit",
                        job, (int64_t)view, prefix) &&
           (any == 0 || pen_db_run(store->db, st, NULL, "UPDATE object SET state = 2 " OF_LAYERS,
                                   "iit", job, (int64_t)view, prefix));
}

bool pen_object_read_row(struct pen_store *store, int64_t number, struct pen_buf *out,
                         struct pen_status *st)
{
    const size_t before = out->bytes;
    char name[128] = "";
    size_t bytes = 0, size;
    int64_t checksum = 0;
    struct pen_rows *rows = pen_db_rows(
        store->db, st, "SELECT bytes, checksum, layer, format, job FROM object WHERE number = $1",
        "i", number);
    if (pen_db_next(rows)) {
        bytes = (size_t)pen_db_int(rows, 0);
        checksum = pen_db_int(rows, 1);
        snprintf(name, sizeof name, "%s %s of the job with number %lld", pen_db_text(rows, 2),
                 pen_db_text(rows, 3), (long long)pen_db_int(rows, 4));
    }
    if (!pen_db_done(rows))
        return false;
    bool room = pen_buf_reserve(out, bytes);
    rows = pen_db_rows(store->db, st, "SELECT data FROM part WHERE object = $1 ORDER BY n", "i",
                       number);
    while (room && pen_db_next(rows)) {
        const void *data = pen_db_bytes(rows, 0, &size);
        room = pen_buf_add(out, data, size);
    }
    if (!pen_db_done(rows))
        return false;
    if (room && out->bytes - before == bytes && pen_checksum(out->data + before, bytes) == checksum)
        return true;
    out->bytes = before;
    return room ? pen_fail(st, PEN_STORAGE, "the stored value %lld is damaged: %s",
                           (long long)number, name)
                : pen_fail(st, PEN_NO_MEMORY, "no memory for a value of %zu bytes", bytes);
}

bool pen_object_find(struct pen_store *store, const struct pen_object_owner *owner, int64_t *number,
                     struct pen_status *st)
{
    return pen_db_value(store->db, st, number,
                        "SELECT number FROM object WHERE job = $1 AND view = $2 AND layer = $3 AND "
                        "format = $4 AND state = 1 AND (layer <> '' OR batch = $5)",
                        "iitti", owner->job, (int64_t)owner->view, owner->layer, owner->format,
                        owner->batch);
}

bool pen_scene_find(struct pen_store *store, const unsigned char sha256[32], int64_t *number,
                    struct pen_status *st)
{
    return pen_db_run(store->db, st, NULL,
                      "UPDATE scene SET used_ms = (SELECT now_ms()) WHERE sha256 = $1", "b",
                      (const void *)sha256, (size_t)32) &&
           pen_db_value(store->db, st, number, "SELECT number FROM scene WHERE sha256 = $1", "b",
                        (const void *)sha256, (size_t)32);
}

/* Where another submit has just added the same document, this one's copy goes. */
bool pen_scene_add(struct pen_store *store, const unsigned char sha256[32], int64_t loaded,
                   const void *data, size_t bytes, int64_t *number, struct pen_status *st)
{
    const struct pen_object_owner owner = {.layer = "", .format = "scene"};
    int64_t object = loaded, stored = 0;
    if (!use(store, &owner, &object, data, bytes, st))
        return false;
    struct pen_rows *rows = pen_db_rows(
        store->db, st,
        "INSERT INTO scene (sha256, object, used_ms) VALUES ($1, $2, (SELECT now_ms())) "
        "ON CONFLICT (sha256) DO UPDATE SET used_ms = (SELECT now_ms()) RETURNING number, object",
        "bi", (const void *)sha256, (size_t)32, object);
    if (pen_db_next(rows)) {
        *number = pen_db_int(rows, 0);
        stored = pen_db_int(rows, 1);
    }
    return pen_db_done(rows) &&
           (stored == object ||
            pen_db_run(store->db, st, NULL, "UPDATE object SET state = 2 WHERE number = $1", "i",
                       object));
}
