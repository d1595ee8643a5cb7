/* SPDX-License-Identifier: MIT */
/* Objects (internal/objects.h), and scene documents, which are objects too. */
#include "store/internal/objects.h"

#include <endian.h>
#include <stdio.h>
#include <string.h>

/* The multiplier of Fibonacci hashing (Knuth, TAOCP 3, 6.4). */
static uint64_t mix(uint64_t sum, uint64_t word)
{
    sum = (sum ^ word) * UINT64_C(0x9E3779B97F4A7C15);
    return sum ^ sum >> 32;
}

/* Mixes in a word of eight bytes at a time, little-endian on any machine. Each step is invertible.
 * So any change within one word is found, and any change of the length; any other change is found
 * with probability 1 - 2^-64. It does not protect against deliberate changes. */
static int64_t checksum_of(const void *data, size_t bytes)
{
    const unsigned char *at = data;
    uint64_t sum = mix(0, bytes), word;
    for (; bytes >= 8; bytes -= 8, at += 8) {
        memcpy(&word, at, 8);
        sum = mix(sum, le64toh(word));
    }
    word = 0;
    memcpy(&word, at, bytes);
    return (int64_t)(bytes > 0 ? mix(sum, le64toh(word)) : sum);
}

static bool gone_meanwhile(struct pen_status *st)
{
    return pen_fail(st, PEN_UNAVAILABLE, "a value that was being written was removed meanwhile");
}

/* Pixels belong to a batch, all other objects to a view. */
#define IN_USE                                                                                     \
    "WHERE job = $1 AND view = $2 AND layer = $3 AND format = $4 AND state = 1 AND "               \
    "(layer <> '' OR batch = $5)"

static bool add_object(struct pen_store *store, struct pen_object *object, int64_t state,
                       struct pen_status *st)
{
    return pen_db_value(store->db, st, &object->number,
                        "INSERT INTO object (job, view, batch, attempt, layer, format, state, "
                        "bytes, checksum, touched_ms) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, "
                        "(SELECT now_ms())) RETURNING number",
                        "iiiittiii", object->job, (int64_t)object->view, object->batch,
                        object->attempt, object->layer, object->format, state,
                        (int64_t)object->bytes, checksum_of(object->data, object->bytes));
}

static bool add_part(struct pen_store *store, const struct pen_object *object, size_t at,
                     struct pen_status *st)
{
    const size_t left = object->bytes - at;
    return pen_db_run(store->db, st, NULL, "INSERT INTO part (object, n, data) VALUES ($1, $2, $3)",
                      "iib", object->number, (int64_t)(at / PEN_PART_BYTES),
                      (const void *)((const char *)object->data + at),
                      left < PEN_PART_BYTES ? left : (size_t)PEN_PART_BYTES);
}

/* Only reads. A value whose claim is lost after this check is never used, and is collected
 * later. */
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

bool pen_object_load(struct pen_store *store, struct pen_object *object,
                     const struct pen_claim *claim, struct pen_status *st)
{
    object->number = 0;
    if (!object->data || object->bytes <= PEN_PART_BYTES)
        return true;
    for (size_t at = 0; at < object->bytes; at += PEN_PART_BYTES) {
        if (!pen_db_begin(store->db, PEN_DB_PART, st) ||
            !pen_db_end(store->db,
                        check_claim(store, claim, st) &&
                            (at > 0 ? touch(store, object->number, st)
                                    : add_object(store, object, 0, st)) &&
                            add_part(store, object, at, st),
                        st))
            return false;
    }
    return true;
}

bool pen_object_use(struct pen_store *store, struct pen_object *object, struct pen_status *st)
{
    int64_t changed;
    if (!object->data)
        return true;
    /* no document replaces another */
    if (object->job > 0 && !pen_db_run(store->db, st, NULL, "UPDATE object SET state = 2 " IN_USE,
                                       "iitti", object->job, (int64_t)object->view, object->layer,
                                       object->format, object->batch))
        return false;
    if (object->number == 0)
        return add_object(store, object, 1, st) && add_part(store, object, 0, st);
    return pen_db_run(store->db, st, &changed,
                      "UPDATE object SET state = 1, job = $2 WHERE number = $1 AND state = 0", "ii",
                      object->number, object->job) &&
           (changed > 0 || gone_meanwhile(st));
}

bool pen_kept_drop(struct pen_store *store, int64_t job, int64_t view, struct pen_status *st)
{
    return pen_db_run(store->db, st, NULL,
                      "UPDATE object SET state = 2 WHERE job = $1 AND state = 1 AND "
                      "(view = $2 OR $2 = -2) AND substr(layer, 1, 5) = 'kept:'",
                      "ii", job, view);
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
    if (room && out->bytes - before == bytes && checksum_of(out->data + before, bytes) == checksum)
        return true;
    out->bytes = before;
    return room ? pen_fail(st, PEN_STORAGE, "the stored value %lld is damaged: %s",
                           (long long)number, name)
                : pen_fail(st, PEN_NO_MEMORY, "no memory for a value of %zu bytes", bytes);
}

bool pen_object_read(struct pen_store *store, const char *job, struct pen_object *object,
                     struct pen_buf *out, struct pen_status *st)
{
    return pen_db_begin(store->db, PEN_DB_READ, st) &&
           pen_db_end(
               store->db,
               pen_job_number(store, job, &object->job, NULL, st) &&
                   pen_db_value(store->db, st, &object->number, "SELECT number FROM object " IN_USE,
                                "iitti", object->job, (int64_t)object->view, object->layer,
                                object->format, object->batch) &&
                   (object->number == 0 || pen_object_read_row(store, object->number, out, st)),
               st);
}

bool pen_scene_find(struct pen_store *store, const unsigned char sha256[32], int64_t *number,
                    struct pen_status *st)
{
    return pen_db_value(store->db, st, number,
                        "UPDATE scene SET used_ms = (SELECT now_ms()) WHERE sha256 = $1 "
                        "RETURNING number",
                        "b", (const void *)sha256, (size_t)32);
}

/* If another submit has just added the same document, this copy is dropped. */
bool pen_scene_add(struct pen_store *store, const unsigned char sha256[32],
                   struct pen_object *document, int64_t *number, struct pen_status *st)
{
    int64_t stored;
    if (!pen_object_use(store, document, st) ||
        !pen_row_numbers(
            pen_db_rows(store->db, st,
                        "INSERT INTO scene (sha256, object, used_ms) "
                        "VALUES ($1, $2, (SELECT now_ms())) ON CONFLICT (sha256) DO UPDATE SET "
                        "used_ms = (SELECT now_ms()) RETURNING number, object",
                        "bi", (const void *)sha256, (size_t)32, document->number),
            number, &stored, NULL))
        return false;
    return stored == document->number ||
           pen_db_run(store->db, st, NULL, "UPDATE object SET state = 2 WHERE number = $1", "i",
                      document->number);
}
