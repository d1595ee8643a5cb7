/* SPDX-License-Identifier: MIT */
/* What was committed: pixels, statistics, batches, pictures. Lists are read inside one snapshot,
 * so a caller sees one moment of the job. */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/log.h"
#include "store/sqlite/sqlite.h"

struct listing {
    const char *id;
    int view;
    pen_pixels_fn *pixels;
    pen_stats_fn *stats;
    pen_batch_fn *batches;
    pen_commit_fn *commits;
    int64_t after;
    void *user;
};

static bool make_room(struct pen_sqlite_store *store, int64_t pixels, struct pen_status *st)
{
    if (pixels < 0 || (uint64_t)pixels > SIZE_MAX / 3 / sizeof *store->rgb)
        return pen_fail(st, PEN_STORAGE, "a stored batch of %lld pixels", (long long)pixels);
    if ((size_t)pixels <= store->rgb_pixels)
        return true;
    free(store->rgb);
    store->rgb_pixels = 0;
    store->rgb = malloc((size_t)pixels * 3 * sizeof *store->rgb);
    if (!store->rgb)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for %lld pixels", (long long)pixels);
    store->rgb_pixels = (size_t)pixels;
    return true;
}

static bool hand_pixels(struct pen_sqlite_store *store, const struct pen_sqlite_query *row,
                        const struct listing *listing, bool *more, struct pen_status *st)
{
    struct pen_bytes packed = pen_sqlite_column_blob(row, 3);
    int64_t pixels = pen_sqlite_column_int(row, 2);
    if (!make_room(store, pixels, st) ||
        !pen_pixels_decode(store->packer, &packed, store->rgb, pixels, st))
        return false;
    *more = listing->pixels(listing->user, (int)pen_sqlite_column_int(row, 0),
                            (int)pen_sqlite_column_int(row, 1), store->rgb, pixels);
    return true;
}

static bool read_pixels(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const struct listing *listing = arg;
    int64_t number;
    if (!pen_sqlite_job_number(store, listing->id, &number, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_PIXELS_LIST);
    pen_sqlite_int(&query, number);
    pen_sqlite_int(&query, listing->view);
    bool ok = true, row = true, more = true;
    while (ok && row && more) {
        ok = pen_sqlite_next(&query, &row, st);
        if (ok && row)
            ok = hand_pixels(store, &query, listing, &more, st);
    }
    pen_sqlite_end(&query);
    return ok;
}

bool pen_sqlite_pixels(struct pen_store *base, const char *id, int view, pen_pixels_fn *each,
                       void *user, struct pen_status *st)
{
    struct listing listing = {.id = id, .view = view, .pixels = each, .user = user};
    return pen_sqlite_snapshot(pen_sqlite_of(base), read_pixels, &listing, st);
}

static bool read_stats(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const struct listing *listing = arg;
    int64_t number;
    if (!pen_sqlite_job_number(store, listing->id, &number, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_STATS_LIST);
    pen_sqlite_int(&query, number);
    bool ok = true, row = true, more = true;
    while (ok && row && more) {
        ok = pen_sqlite_next(&query, &row, st);
        if (ok && row) {
            struct pen_batch_stats batch = {
                .view = (int)pen_sqlite_column_int(&query, 0),
                .kind = (enum pen_batch_kind)pen_sqlite_column_int(&query, 1),
                .done_ms = pen_sqlite_column_int(&query, 2),
                .stats = pen_sqlite_column_text(&query, 3)};
            more = listing->stats(listing->user, &batch);
        }
    }
    pen_sqlite_end(&query);
    return ok;
}

bool pen_sqlite_stats(struct pen_store *base, const char *id, pen_stats_fn *each, void *user,
                      struct pen_status *st)
{
    struct listing listing = {.id = id, .stats = each, .user = user};
    return pen_sqlite_snapshot(pen_sqlite_of(base), read_stats, &listing, st);
}

static struct pen_batch_record batch_record(const struct pen_sqlite_query *row)
{
    return (struct pen_batch_record){
        .batch = pen_sqlite_column_int(row, 0),
        .attempt = pen_sqlite_column_int(row, 1),
        .kind = (enum pen_batch_kind)pen_sqlite_column_int(row, 2),
        .state = (enum pen_batch_state)pen_sqlite_column_int(row, 3),
        .view = (int)pen_sqlite_column_int(row, 4),
        .first_tile = (int)pen_sqlite_column_int(row, 5),
        .tile_count = (int)pen_sqlite_column_int(row, 6),
        .pixels = pen_sqlite_column_int(row, 7),
        .worker = pen_sqlite_column_text(row, 8),
        .quarantined = pen_sqlite_column_int(row, 9) != 0,
    };
}

static bool read_batches(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const struct listing *listing = arg;
    int64_t number;
    if (!pen_sqlite_job_number(store, listing->id, &number, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_BATCH_LIST);
    pen_sqlite_int(&query, number);
    bool ok = true, row = true, more = true;
    while (ok && row && more) {
        ok = pen_sqlite_next(&query, &row, st);
        if (ok && row) {
            struct pen_batch_record batch = batch_record(&query);
            more = listing->batches(listing->user, &batch);
        }
    }
    pen_sqlite_end(&query);
    return ok;
}

bool pen_sqlite_batches(struct pen_store *base, const char *id, pen_batch_fn *each, void *user,
                        struct pen_status *st)
{
    struct listing listing = {.id = id, .batches = each, .user = user};
    return pen_sqlite_snapshot(pen_sqlite_of(base), read_batches, &listing, st);
}

static bool read_commits(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const struct listing *listing = arg;
    int64_t number;
    if (!pen_sqlite_job_number(store, listing->id, &number, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_COMMIT_LIST);
    pen_sqlite_int(&query, number);
    pen_sqlite_int(&query, listing->after);
    bool ok = true, row = true, more = true;
    while (ok && row && more) {
        ok = pen_sqlite_next(&query, &row, st);
        if (ok && row) {
            struct pen_commit_record commit = {.revision = pen_sqlite_column_int(&query, 0),
                                               .view = (int)pen_sqlite_column_int(&query, 1),
                                               .first_tile = (int)pen_sqlite_column_int(&query, 2),
                                               .tile_count = (int)pen_sqlite_column_int(&query, 3)};
            more = listing->commits(listing->user, &commit);
        }
    }
    pen_sqlite_end(&query);
    return ok;
}

bool pen_sqlite_commits(struct pen_store *base, const char *id, int64_t after, pen_commit_fn *each,
                        void *user, struct pen_status *st)
{
    struct listing listing = {.id = id, .after = after, .commits = each, .user = user};
    return pen_sqlite_snapshot(pen_sqlite_of(base), read_commits, &listing, st);
}

/* One picture: what it is of, and where it goes to or comes from. */
struct picture {
    const char *id, *layer, *format;
    int view;
    struct pen_buf *out;
    const void *data;
    size_t bytes;
};

static void bind_picture(struct pen_sqlite_query *query, int64_t number,
                         const struct picture *picture)
{
    pen_sqlite_int(query, number);
    pen_sqlite_int(query, picture->view);
    pen_sqlite_text(query, picture->layer);
    pen_sqlite_text(query, picture->format);
}

static bool hand_picture(const struct pen_sqlite_query *row, const struct picture *picture,
                         struct pen_status *st)
{
    struct pen_bytes data = pen_sqlite_column_blob(row, 0);
    bool has_sum = sqlite3_column_type(row->stmt, 1) != SQLITE_NULL;
    if (has_sum && pen_sqlite_column_int(row, 1) != pen_checksum(data.data, data.bytes)) {
        pen_fail(st, PEN_STORAGE,
                 "the stored %s %s of job %s is damaged: its bytes are not those that were stored",
                 picture->layer, picture->format, picture->id);
        pen_log(PEN_LOG_ERROR, "%s", st->msg);
        return false;
    }
    return pen_buf_add(picture->out, data.data, data.bytes) ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for a picture");
}

static bool read_picture(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const struct picture *picture = arg;
    int64_t number;
    if (!pen_sqlite_job_number(store, picture->id, &number, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_ARTEFACT_GET);
    bind_picture(&query, number, picture);
    bool row;
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (!row)
        return pen_fail(st, PEN_NOT_FOUND, "job %s has no stored %s %s", picture->id,
                        picture->layer, picture->format);
    bool ok = hand_picture(&query, picture, st);
    pen_sqlite_end(&query);
    return ok;
}

bool pen_sqlite_artefact(struct pen_store *base, const char *id, int view, const char *layer,
                         const char *format, struct pen_buf *out, struct pen_status *st)
{
    struct picture picture = {.id = id, .view = view, .layer = layer, .format = format, .out = out};
    return pen_sqlite_snapshot(pen_sqlite_of(base), read_picture, &picture, st);
}

static bool write_picture(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const struct picture *picture = arg;
    int64_t number;
    if (!pen_sqlite_job_number(store, picture->id, &number, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_ARTEFACT_PUT);
    bind_picture(&query, number, picture);
    pen_sqlite_blob(&query, picture->data, picture->bytes);
    pen_sqlite_int(&query, pen_checksum(picture->data, picture->bytes));
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_artefact_put(struct pen_store *base, const char *id, int view, const char *layer,
                             const char *format, const void *data, size_t bytes,
                             struct pen_status *st)
{
    struct picture picture = {
        .id = id, .view = view, .layer = layer, .format = format, .data = data, .bytes = bytes};
    return pen_sqlite_transaction(pen_sqlite_of(base), write_picture, &picture, st);
}
