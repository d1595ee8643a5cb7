/* SPDX-License-Identifier: MIT */
/* Reads committed results: pixels, statistics, commits, artefacts, scenes. A committed row never
 * changes, so reads at different moments are consistent. */
#include <stdlib.h>

#include "store/internal/objects.h"

/* A stored batch of pixels. */
struct piece {
    int64_t object, first_tile, tile_count, pixels; /* object 0: there are no more */
    struct pen_buf encoded;
};

static bool next_piece(struct pen_store *store, int64_t job, int view, struct piece *piece,
                       struct pen_status *st)
{
    piece->encoded.bytes = 0;
    if (!pen_db_begin(store->db, PEN_DB_READ, st))
        return false;
    const bool ok = pen_row_numbers(
        pen_db_rows(
            store->db, st,
            "SELECT object.number, batch.first_tile, batch.tile_count, batch.pixels FROM batch "
            "JOIN object ON object.batch = batch.number AND object.layer = '' AND object.state = 1 "
            "WHERE batch.job = $1 AND batch.view = $2 AND batch.first_tile > $3 "
            "AND batch.state = 2 AND batch.kind = 0 AND object.batch > 0 "
            "ORDER BY batch.first_tile LIMIT 1",
            "iii", job, (int64_t)view, piece->first_tile),
        &piece->object, &piece->first_tile, &piece->tile_count, &piece->pixels, NULL);
    return pen_db_end(store->db,
                      ok && (piece->object == 0 ||
                             pen_object_read_row(store, piece->object, &piece->encoded, st)),
                      st);
}

bool pen_store_pixels(struct pen_store *store, const char *id, int view, pen_pixels_fn *each,
                      void *user, struct pen_status *st)
{
    struct piece piece = {.first_tile = -1};
    float *rgb = NULL;
    int64_t job, room = 0;
    bool more = true, ok = pen_job_number(store, id, &job, NULL, st);
    while (more && ok && (ok = next_piece(store, job, view, &piece, st)) && piece.object > 0) {
        if (piece.pixels > room) {
            free(rgb);
            rgb = malloc((size_t)piece.pixels * 3 * sizeof *rgb);
            room = piece.pixels;
        }
        const struct pen_bytes encoded = {piece.encoded.data, piece.encoded.bytes};
        ok = rgb ? pen_pixels_decode(store->documents, &encoded, rgb, piece.pixels, st)
                 : pen_fail(st, PEN_NO_MEMORY, "no memory for the pixels of a batch");
        more = ok && each(user, (int)piece.first_tile, (int)piece.tile_count, rgb, piece.pixels);
    }
    ok = ok && pen_job_number(store, id, &job, NULL, st); /* else a part of it may be gone */
    free(rgb);
    pen_buf_release(&piece.encoded);
    return ok;
}

bool pen_store_stats(struct pen_store *store, const char *id, pen_stats_fn *each, void *user,
                     struct pen_status *st)
{
    int64_t job;
    bool more = true;
    if (!pen_job_number(store, id, &job, NULL, st))
        return false;
    struct pen_rows *rows = pen_db_rows(
        store->db, st,
        "SELECT kind, view, commit_us, stats FROM batch WHERE job = $1 AND state = 2 AND "
        "stats IS NOT NULL ORDER BY number",
        "i", job);
    while (more && pen_db_next(rows)) {
        const struct pen_batch_stats batch = {.kind = (enum pen_batch_kind)pen_db_int(rows, 0),
                                              .view = (int)pen_db_int(rows, 1),
                                              .commit_us = pen_db_int(rows, 2),
                                              .stats = pen_db_text(rows, 3)};
        more = each(user, &batch);
    }
    return pen_db_done(rows);
}

bool pen_store_commits(struct pen_store *store, const char *id, int64_t after, pen_commit_fn *each,
                       void *user, struct pen_status *st)
{
    int64_t job;
    bool more = true;
    if (!pen_job_number(store, id, &job, NULL, st))
        return false;
    struct pen_rows *rows = pen_db_rows(
        store->db, st,
        "SELECT revision, view, first_tile, tile_count FROM batch WHERE job = $1 AND state = 2 AND "
        "kind = 0 AND revision > $2 ORDER BY revision",
        "ii", job, after);
    while (more && pen_db_next(rows)) {
        const struct pen_commit_record commit = {pen_db_int(rows, 0), (int)pen_db_int(rows, 1),
                                                 (int)pen_db_int(rows, 2),
                                                 (int)pen_db_int(rows, 3)};
        more = each(user, &commit);
    }
    return pen_db_done(rows);
}

bool pen_store_artefact(struct pen_store *store, const char *id, int view, const char *layer,
                        const char *format, struct pen_buf *out, struct pen_status *st)
{
    struct pen_object object = {.view = view, .layer = layer, .format = format};
    return pen_object_read(store, id, &object, out, st) &&
           (object.number > 0 || pen_fail(st, PEN_NOT_FOUND, "job %s has no %s as %s of view %d",
                                          id, layer, format, view));
}

bool pen_store_artefact_put(struct pen_store *store, const struct pen_claim *claim,
                            const char *layer, const char *format, const void *data, size_t bytes,
                            struct pen_status *st)
{
    struct pen_object object = {.view = claim->view,
                                .batch = claim->batch,
                                .attempt = claim->attempt,
                                .layer = layer,
                                .format = format,
                                .data = data,
                                .bytes = bytes};
    struct pen_batch batch;
    if (!pen_object_load(store, &object, claim, st) || !pen_db_begin(store->db, PEN_DB_WRITE, st))
        return false;
    const bool ok = pen_claim_hold(store, claim, "its artefact is not stored", &batch, st);
    object.job = batch.job;
    return pen_db_end(store->db, ok && pen_object_use(store, &object, st), st);
}

static bool read_scene(struct pen_store *store, const char *id, struct pen_buf *out,
                       struct pen_status *st)
{
    int64_t job, object;
    if (!pen_job_number(store, id, &job, NULL, st))
        return false;
    return pen_db_value(store->db, st, &object,
                        "SELECT scene.object FROM job JOIN scene ON scene.number = job.scene "
                        "WHERE job.number = $1",
                        "i", job) &&
           (object > 0 || pen_fail(st, PEN_STORAGE, "the scene of job %s is missing", id)) &&
           pen_object_read_row(store, object, out, st);
}

bool pen_store_scene(struct pen_store *store, const char *id, struct pen_buf *scene,
                     struct pen_status *st)
{
    struct pen_buf stored = {0};
    struct pen_bytes plain;
    bool ok = pen_db_begin(store->db, PEN_DB_READ, st) &&
              pen_db_end(store->db, read_scene(store, id, &stored, st), st);
    if (ok) {
        const struct pen_bytes packed = {stored.data, stored.bytes};
        ok = pen_decompress(store->documents, packed.data, packed.bytes, &plain, st) &&
             (pen_buf_add(scene, plain.data, plain.bytes) ||
              pen_fail(st, PEN_NO_MEMORY, "no memory for the scene of job %s", id));
    }
    pen_buf_release(&stored);
    return ok;
}
