/* SPDX-License-Identifier: MIT */
/* Reads what was committed: pixels, statistics, batches, artefacts. Rows are read in pages, and the
 * caller's function is called between pages, outside any transaction. A committed row never
 * changes, so pages of different moments fit together. If the job is deleted meanwhile, the list
 * ends. */
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "store/internal/policy.h"

enum { PAGE = 128 };

static bool reserve_pixels(struct pen_store *store, int64_t pixels, struct pen_status *st)
{
    if (pixels < 0 || (uint64_t)pixels > SIZE_MAX / 3 / sizeof *store->rgb)
        return pen_fail(st, PEN_STORAGE, "a stored batch of %lld pixels", (long long)pixels);
    if ((size_t)pixels <= store->rgb_pixels)
        return true;
    free(store->rgb);
    store->rgb_pixels = 0;
    store->rgb = pen_memory_large((size_t)pixels * 3 * sizeof *store->rgb);
    if (!store->rgb)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for %lld pixels", (long long)pixels);
    store->rgb_pixels = (size_t)pixels;
    return true;
}

static bool load_pixels(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct pen_pixels_row *row = arg;
    return pen_blob_load(store, PEN_BLOB_PIXELS, row->batch, row->bytes, st);
}

bool pen_decode_pixels(struct pen_store *store, int64_t pixels, struct pen_status *st)
{
    if (!reserve_pixels(store, pixels, st))
        return false;
    struct pen_bytes encoded = {store->blob.data, store->blob.bytes};
    return pen_pixels_decode(store->compressor, &encoded, store->rgb, pixels, st);
}

static bool decode_pixels(struct pen_store *store, struct pen_pixels_row *row,
                          struct pen_status *st)
{
    return pen_store_read(store, load_pixels, row, st) && pen_decode_pixels(store, row->pixels, st);
}

bool pen_policy_pixels(struct pen_store *store, const char *id, int view, pen_pixels_fn *each,
                       void *user, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_job_key job;
    struct pen_pixels_row rows[PAGE];
    int64_t after = 0;
    int count = PAGE;
    if (!pen_find_job(store, id, &job, st))
        return false;
    while (count == PAGE) {
        if (!driver->ops->pixels_page(driver, job.number, view, after, rows, PAGE, &count, st))
            return false;
        for (int i = 0; i < count; i++) {
            after = rows[i].batch;
            if (!decode_pixels(store, &rows[i], st))
                return false;
            if (!each(user, rows[i].first_tile, rows[i].tile_count, store->rgb, rows[i].pixels))
                return true;
        }
    }
    return true;
}

/* A list that is read in pages, with an arena for the texts of a page. */
struct listing {
    struct pen_store *store;
    struct pen_arena *arena;
    int64_t job, after;
    pen_stats_fn *stats;
    pen_batch_fn *batches;
    void *user;
};

/* Reads one page and calls the caller's function for its rows. *more: there may be another page,
 * and the caller wants it. */
typedef bool page_fn(struct listing *listing, bool *more, struct pen_status *st);

static bool stats_page(struct listing *listing, bool *more, struct pen_status *st)
{
    struct pen_driver *driver = listing->store->driver;
    struct pen_stats_row rows[PAGE];
    int count;
    if (!driver->ops->stats_page(driver, listing->job, listing->after, listing->arena, rows, PAGE,
                                 &count, st))
        return false;
    *more = count == PAGE;
    for (int i = 0; i < count; i++) {
        listing->after = rows[i].batch;
        if (!listing->stats(listing->user, &rows[i].stats)) {
            *more = false;
            return true;
        }
    }
    return true;
}

static bool batch_page(struct listing *listing, bool *more, struct pen_status *st)
{
    struct pen_driver *driver = listing->store->driver;
    struct pen_batch_record rows[PAGE];
    int count;
    if (!driver->ops->batch_page(driver, listing->job, listing->after, listing->arena, rows, PAGE,
                                 &count, st))
        return false;
    *more = count == PAGE;
    for (int i = 0; i < count; i++) {
        listing->after = rows[i].batch;
        if (!listing->batches(listing->user, &rows[i])) {
            *more = false;
            return true;
        }
    }
    return true;
}

static bool read_pages(struct listing *listing, const char *id, page_fn *page,
                       struct pen_status *st)
{
    struct pen_job_key job;
    bool more = true, ok = true;
    if (!pen_find_job(listing->store, id, &job, st))
        return false;
    listing->job = job.number;
    listing->arena = pen_arena_new(0);
    if (!listing->arena)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a list of batches");
    while (ok && more) {
        pen_arena_reset(listing->arena);
        ok = page(listing, &more, st);
    }
    pen_arena_free(listing->arena);
    return ok;
}

bool pen_policy_stats(struct pen_store *store, const char *id, pen_stats_fn *each, void *user,
                      struct pen_status *st)
{
    struct listing listing = {.store = store, .stats = each, .user = user};
    return read_pages(&listing, id, stats_page, st);
}

bool pen_policy_batches(struct pen_store *store, const char *id, pen_batch_fn *each, void *user,
                        struct pen_status *st)
{
    struct listing listing = {.store = store, .batches = each, .user = user};
    return read_pages(&listing, id, batch_page, st);
}

bool pen_policy_commits(struct pen_store *store, const char *id, int64_t after, pen_commit_fn *each,
                        void *user, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_job_key job;
    struct pen_commit_record rows[PAGE];
    int count = PAGE;
    if (!pen_find_job(store, id, &job, st))
        return false;
    while (count == PAGE) {
        if (!driver->ops->commit_page(driver, job.number, after, rows, PAGE, &count, st))
            return false;
        for (int i = 0; i < count; i++) {
            after = rows[i].revision;
            if (!each(user, &rows[i]))
                return true;
        }
    }
    return true;
}

/* One artefact: its key with the job's id, its row once found. */
struct artefact {
    const char *id, *layer, *format;
    int view;
    struct pen_artefact_row row;
};

static bool artefact_key(struct pen_store *store, const struct artefact *artefact,
                         struct pen_artefact_key *key, struct pen_status *st)
{
    struct pen_job_key job;
    if (!pen_find_job(store, artefact->id, &job, st))
        return false;
    *key = (struct pen_artefact_key){.job = job.number,
                                     .view = artefact->view,
                                     .layer = artefact->layer,
                                     .format = artefact->format};
    return true;
}

static bool read_artefact(struct pen_store *store, void *arg, struct pen_status *st)
{
    struct artefact *artefact = arg;
    struct pen_artefact_key key;
    bool found;
    if (!artefact_key(store, artefact, &key, st) ||
        !store->driver->ops->artefact_find(store->driver, &key, &artefact->row, &found, st))
        return false;
    if (!found)
        return pen_fail(st, PEN_NOT_FOUND, "job %s has no stored %s %s", artefact->id,
                        artefact->layer, artefact->format);
    return pen_blob_load(store, PEN_BLOB_ARTEFACT, artefact->row.number, artefact->row.bytes, st);
}

/* Gives the blob that was loaded to `out`. An empty `out` gets the buffer itself: an artefact may
 * be large, and a handle that kept it would keep its memory for ever. */
static bool give_blob(struct pen_buf *blob, struct pen_buf *out, struct pen_status *st)
{
    const bool ok =
        out->data ? pen_buf_add(out, blob->data, blob->bytes) : pen_buf_add(blob, "", 0);
    if (!ok)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a picture");
    if (!out->data) {
        *out = *blob;
        pen_buf_init(blob);
    }
    return true;
}

bool pen_policy_artefact(struct pen_store *store, const char *id, int view, const char *layer,
                         const char *format, struct pen_buf *out, struct pen_status *st)
{
    struct artefact artefact = {.id = id, .view = view, .layer = layer, .format = format};
    if (!pen_store_read(store, read_artefact, &artefact, st))
        return false;
    if (!pen_blob_is_intact(store, artefact.row.has_checksum, artefact.row.checksum)) {
        pen_fail(st, PEN_STORAGE,
                 "the stored %s %s of job %s is damaged: its bytes are not those that were stored",
                 layer, format, id);
        pen_log(PEN_LOG_ERROR, "%s", st->msg);
        return false;
    }
    if (!give_blob(&store->blob, out, st))
        return false;
    pen_note_use(store, &artefact.row);
    return true;
}

bool pen_put_artefact(struct pen_store *store, const struct pen_artefact_key *key,
                      const struct pen_value *value, int64_t *number, struct pen_status *st)
{
    struct pen_blob_start start = pen_value_begin(value);
    return store->driver->ops->artefact_put(store->driver, key, value->checksum, &start, number,
                                            st) &&
           pen_value_finish(store, PEN_BLOB_ARTEFACT, *number, value, st);
}

/* An artefact that a claim's holder stores. */
struct put {
    const struct pen_claim *claim;
    const char *layer, *format;
    struct pen_value value;
};

static bool write_artefact(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct put *put = arg;
    struct pen_batch_row batch;
    bool held;
    int64_t number;
    if (!pen_check_fence(store, put->claim, &batch, &held, st))
        return false;
    if (!held)
        return pen_fail(st, PEN_STALE, "the batch is no longer held; its %s %s was refused",
                        put->layer, put->format);
    const struct pen_artefact_key key = {
        .job = batch.job, .view = batch.view, .layer = put->layer, .format = put->format};
    return pen_put_artefact(store, &key, &put->value, &number, st);
}

bool pen_policy_artefact_put(struct pen_store *store, const struct pen_claim *claim,
                             const char *layer, const char *format, const void *data, size_t bytes,
                             struct pen_status *st)
{
    struct put put = {.claim = claim, .layer = layer, .format = format};
    return pen_value_store(store, claim, data, bytes, &put.value, st) &&
           pen_value_write(store, &put.value, write_artefact, &put, st);
}

bool pen_policy_keep_part(struct pen_store *store, const struct pen_claim *claim,
                          const struct pen_kept_part *part, struct pen_status *st)
{
    struct put put = {.claim = claim, .layer = PEN_KEPT_LAYER, .format = part->name};
    return pen_value_store_apart(store, claim, pen_admit_kept, part->data, part->bytes, &put.value,
                                 st) &&
           pen_value_write(store, &put.value, write_artefact, &put, st);
}

bool pen_policy_audit(struct pen_store *store, pen_audit_fn *each, void *user, int *found,
                      struct pen_status *st)
{
    struct pen_buf findings = {0};
    bool ok = store->driver->ops->audit(store->driver, &findings, found, st);
    const char *at = (const char *)findings.data;
    for (int i = 0; ok && each && !findings.failed && i < *found; i++, at += strlen(at) + 1)
        each(user, at);
    if (ok && findings.failed)
        ok = pen_fail(st, PEN_NO_MEMORY, "no memory for the findings");
    pen_buf_release(&findings);
    return ok;
}
