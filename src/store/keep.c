/* SPDX-License-Identifier: MIT */
/* What a long batch keeps, so that the next worker to claim it goes on from there. It belongs to
 * the view, and goes with the view's last commit or with the job's end. */
#include <stdio.h>
#include <stdlib.h>

#include "store/internal/objects.h"
#include "store/internal/retention.h"

enum { LAYER_BYTES = 256 };

/* The state and the parts of one call, as objects. */
struct keeping {
    const void *data;
    size_t bytes;
    int64_t number;
    char layer[LAYER_BYTES];
    struct pen_object_owner owner;
};

static struct keeping keeping_of(const struct pen_claim *claim, const char *name, const void *data,
                                 size_t bytes)
{
    struct keeping one = {.data = data, .bytes = bytes};
    snprintf(one.layer, sizeof one.layer, "kept:%s", name);
    one.owner = (struct pen_object_owner){
        .view = claim->view, .batch = claim->batch, .attempt = claim->attempt, .format = "kept"};
    return one;
}

/* Loads the values, and makes them the view's in one transaction with the progress. */
static bool keep(struct pen_store *store, const struct pen_claim *claim, struct keeping *all,
                 int count, int64_t done, bool *outranked, struct pen_status *st)
{
    struct pen_batch batch;
    int64_t bytes = 0, work;
    for (int i = 0; i < count; i++) {
        all[i].owner.layer = all[i].layer;
        bytes += (int64_t)all[i].bytes;
    }
    if (!pen_db_begin(store->db, PEN_DB_READ, st) ||
        !pen_db_end(store->db, pen_admit_kept(store, bytes, st), st))
        return false;
    for (int i = 0; i < count; i++) {
        if (!pen_object_load(store, &all[i].owner, claim, all[i].data, all[i].bytes, &all[i].number,
                             st))
            return false;
    }
    if (!pen_db_begin(store->db, PEN_DB_WRITE, st))
        return false;
    bool ok = pen_claim_hold(store, claim, "what it keeps is not stored", &batch, st);
    for (int i = 0; ok && i < count; i++) {
        all[i].owner.job = batch.job;
        ok = pen_object_use(store, &all[i].owner, all[i].number, all[i].data, all[i].bytes, st);
    }
    ok = ok &&
         (done < 0 || (pen_work_of_pixels(store, batch.job, done, &work, st) &&
                       pen_claim_tell(store, &batch, done, work, claim->estimate_ms, st))) &&
         (!outranked || pen_claim_outranked(store, claim, outranked, st));
    if (!pen_db_end(store->db, ok, st))
        return false;
    if (done >= 0)
        pen_db_wake(store->db);
    return true;
}

bool pen_store_keep(struct pen_store *store, const struct pen_claim *claim,
                    const struct pen_kept *kept, bool *outranked, struct pen_status *st)
{
    struct keeping *all = calloc((size_t)kept->part_count + 1, sizeof *all);
    int count = 0;
    if (!all)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for what a batch keeps");
    if (kept->data)
        all[count++] = keeping_of(claim, PEN_KEPT_STATE, kept->data, kept->bytes);
    for (int i = 0; i < kept->part_count; i++)
        all[count++] =
            keeping_of(claim, kept->parts[i].name, kept->parts[i].data, kept->parts[i].bytes);
    const bool ok = keep(store, claim, all, count, kept->done, outranked, st);
    free(all);
    return ok;
}

bool pen_store_keep_part(struct pen_store *store, const struct pen_claim *claim,
                         const struct pen_kept_part *part, struct pen_status *st)
{
    struct keeping one = keeping_of(claim, part->name, part->data, part->bytes);
    return keep(store, claim, &one, 1, -1, NULL, st);
}

bool pen_store_kept(struct pen_store *store, const struct pen_claim *claim, const char *name,
                    struct pen_buf *out, struct pen_status *st)
{
    struct keeping one = keeping_of(claim, name, NULL, 0);
    int64_t number = 0;
    one.owner.layer = one.layer;
    if (!pen_db_begin(store->db, PEN_DB_READ, st))
        return false;
    bool ok = pen_job_number(store, claim->job_id, &one.owner.job, NULL, st) &&
              pen_object_find(store, &one.owner, &number, st) &&
              (number > 0 || pen_fail(st, PEN_NOT_FOUND, "nothing is kept as %s", name)) &&
              pen_object_read_row(store, number, out, st);
    return pen_db_end(store->db, ok, st);
}
