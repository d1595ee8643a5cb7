/* SPDX-License-Identifier: MIT */
/* The background check of blobs. A blob is read in a transaction of its own, so that it cannot be
 * removed meanwhile, and checked after it. */
#include "base/log.h"
#include "store/internal/policy.h"

struct next {
    const struct pen_scrub *scrub;
    enum pen_blob_kind kind;
    struct pen_blob_row row;
    bool found, loaded;
    struct pen_status why; /* it was not loaded, or is damaged */
};

/* Finds the next blob of any kind and loads it. Fails: only if none can be looked for. */
static bool load_next(struct pen_store *store, void *arg, struct pen_status *st)
{
    struct next *next = arg;
    int64_t after = next->scrub->after;
    for (int kind = next->scrub->kind; kind < PEN_BLOB_KINDS; kind++, after = 0) {
        next->kind = (enum pen_blob_kind)kind;
        if (!store->driver->ops->blob_next(store->driver, next->kind, after, &next->row,
                                           &next->found, st))
            return false;
        if (next->found) {
            next->loaded =
                pen_blob_load(store, next->kind, next->row.number, next->row.bytes, &next->why);
            return true;
        }
    }
    return true;
}

/* Checks the blob that was loaded. Fails: PEN_STORAGE (it is damaged), PEN_NO_MEMORY. */
static bool check(struct pen_store *store, const struct next *next, struct pen_status *st)
{
    const struct pen_buf *blob = &store->blob;
    struct pen_bytes document;
    switch (next->kind) {
    case PEN_BLOB_SCENE:
        return pen_decompress(store->compressor, blob->data, blob->bytes, &document, st);
    case PEN_BLOB_PIXELS:
        return pen_decode_pixels(store, next->row.pixels, st);
    case PEN_BLOB_ARTEFACT:
        break;
    }
    return pen_blob_is_intact(store, next->row.has_checksum, next->row.checksum) ||
           pen_fail(st, PEN_STORAGE, "its bytes are not those that were stored");
}

static void tell(const struct next *next)
{
    static const char *const kinds[] = {[PEN_BLOB_SCENE] = "scene",
                                        [PEN_BLOB_PIXELS] = "pixels of a batch",
                                        [PEN_BLOB_ARTEFACT] = "picture"};
    const struct pen_log_about about = {.job = next->row.job[0] ? next->row.job : NULL};
    pen_log_about(PEN_LOG_ERROR, &about, "the store's background check: %s%s%s %lld: %s",
                  kinds[next->kind], next->row.name[0] ? " " : "", next->row.name,
                  (long long)next->row.number, next->why.msg);
}

/* Goes on from a blob before anything is said of it: one that can never be read must not keep the
 * others from being checked. */
bool pen_policy_scrub(struct pen_store *store, struct pen_scrub *scrub, bool *more,
                      struct pen_status *st)
{
    struct next next = {.scrub = scrub};
    if (!pen_store_read(store, load_next, &next, st))
        return false;
    *more = next.found;
    if (!next.found) {
        pen_tally_set(store, PEN_TALLY_DAMAGED, (uint64_t)scrub->damaged);
        *scrub = (struct pen_scrub){0};
        return true;
    }
    scrub->kind = (int)next.kind;
    scrub->after = next.row.number;
    pen_store_tally_add(store, PEN_TALLY_SCRUBBED, 1);
    if (next.loaded && check(store, &next, &next.why))
        return true;
    if (next.why.code != PEN_STORAGE) {
        *st = next.why;
        return false;
    }
    scrub->damaged++;
    tell(&next);
    return true;
}
