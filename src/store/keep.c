/* SPDX-License-Identifier: MIT */
/* What a long batch keeps, so that the next worker that claims it can continue. It belongs to the
 * view, and is dropped with the view's last commit or the job's end. */
#include <stdio.h>
#include <stdlib.h>

#include "store/internal/objects.h"

enum { LAYER_BYTES = 256 };

struct keeping {
    struct pen_object object;
    char layer[LAYER_BYTES];
};

static void init(struct keeping *one, const struct pen_claim *claim, const char *name,
                 const void *data, size_t bytes)
{
    snprintf(one->layer, sizeof one->layer, "kept:%s", name);
    one->object = (struct pen_object){.view = claim->view,
                                      .batch = claim->batch,
                                      .attempt = claim->attempt,
                                      .layer = one->layer,
                                      .format = "kept",
                                      .data = data,
                                      .bytes = bytes};
}

static bool write_kept(struct pen_store *store, const struct pen_claim *claim, struct keeping *all,
                       int count, int64_t done, bool *outranked, struct pen_status *st)
{
    struct pen_batch batch;
    bool ok = pen_claim_hold(store, claim, "what it keeps is not stored", &batch, st);
    for (int i = 0; ok && i < count; i++) {
        all[i].object.job = batch.job;
        ok = pen_object_use(store, &all[i].object, st);
    }
    return ok && (done < 0 || pen_claim_tell(store, &batch, done, -1, claim->estimate_ms, st)) &&
           (!outranked || pen_claim_outranked(store, claim, outranked, st));
}

/* Writes the values, then makes them the view's in one transaction, together with the progress. */
static bool keep(struct pen_store *store, const struct pen_claim *claim, struct keeping *all,
                 int count, int64_t done, bool *outranked, struct pen_status *st)
{
    int64_t bytes = 0;
    for (int i = 0; i < count; i++)
        bytes += (int64_t)all[i].object.bytes;
    bool ok = bytes == 0 || (pen_db_begin(store->db, PEN_DB_READ, st) &&
                             pen_db_end(store->db, pen_admit_kept(store, bytes, st), st));
    for (int i = 0; ok && i < count; i++)
        ok = pen_object_load(store, &all[i].object, claim, st);
    return ok && pen_db_begin(store->db, PEN_DB_WRITE, st) &&
           pen_write_end(store, write_kept(store, claim, all, count, done, outranked, st), st);
}

bool pen_store_keep(struct pen_store *store, const struct pen_claim *claim,
                    const struct pen_kept *kept, bool *outranked, struct pen_status *st)
{
    const int count = kept->part_count + 1;
    struct keeping *all = calloc((size_t)count, sizeof *all);
    if (!all)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for what a batch keeps");
    init(&all[0], claim, PEN_KEPT_STATE, kept->data, kept->bytes);
    for (int i = 1; i < count; i++)
        init(&all[i], claim, kept->parts[i - 1].name, kept->parts[i - 1].data,
             kept->parts[i - 1].bytes);
    const bool ok = keep(store, claim, all, count, kept->done, outranked, st);
    free(all);
    return ok;
}

bool pen_store_kept(struct pen_store *store, const struct pen_claim *claim, const char *name,
                    struct pen_buf *out, struct pen_status *st)
{
    struct keeping one;
    init(&one, claim, name, NULL, 0);
    return pen_object_read(store, claim->job_id, &one.object, out, st) &&
           (one.object.number > 0 || pen_fail(st, PEN_NOT_FOUND, "nothing is kept as %s", name));
}
