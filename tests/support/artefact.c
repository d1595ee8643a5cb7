/* SPDX-License-Identifier: MIT */
/* Takes the place of a worker that held a batch of the job then: so it needs the store's inner
 * functions, since the store takes an artefact from a claim's holder only. */
#include "store/internal/policy.h"
#include "support/store.h"

struct put {
    const char *id;
    struct pen_artefact_key key;
    struct pen_value value;
};

static bool write(struct pen_store *store, void *arg, struct pen_status *st)
{
    struct put *put = arg;
    struct pen_job_key job;
    int64_t number;
    if (!pen_find_job(store, put->id, &job, st))
        return false;
    put->key.job = job.number;
    return pen_put_artefact(store, &put->key, &put->value, &number, st);
}

void store_put(struct pen_store *store, const struct store_artefact *artefact)
{
    struct put put = {
        .id = artefact->id,
        .key = {.view = artefact->view, .layer = artefact->layer, .format = artefact->format}};
    struct pen_status st;
    store_must(pen_value_store(store, NULL, artefact->data, artefact->bytes, &put.value, &st) &&
                   pen_value_write(store, &put.value, write, &put, &st),
               &st, "put");
}
