/* SPDX-License-Identifier: MIT */
/* Takes the place of a worker that held a batch of the job then: so it needs the store's inner
 * functions, since the store takes a value from a claim's holder only. */
#include "store/internal/objects.h"
#include "support/store.h"

void store_put(struct pen_store *store, const struct store_artefact *artefact)
{
    struct pen_object object = {.view = artefact->view,
                                .layer = artefact->layer,
                                .format = artefact->format,
                                .data = artefact->data,
                                .bytes = artefact->bytes};
    struct pen_status st;
    store_must(pen_db_begin(store->db, PEN_DB_READ, &st) &&
                   pen_db_end(store->db,
                              pen_job_number(store, artefact->id, &object.job, NULL, &st), &st) &&
                   pen_object_load(store, &object, NULL, &st) &&
                   pen_db_begin(store->db, PEN_DB_WRITE, &st) &&
                   pen_db_end(store->db, pen_object_use(store, &object, &st), &st),
               &st, "put");
}
