/* SPDX-License-Identifier: MIT */
/* Acts as a worker that held a batch of the job. It needs internal functions of the store, because
 * the store accepts an object only from a claim's holder. */
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
