/* SPDX-License-Identifier: MIT */
/* What a handle on a store is, for the files of this room. */
#ifndef PEN_STORE_INTERNAL_HANDLE_H
#define PEN_STORE_INTERNAL_HANDLE_H

#include "store/db.h"
#include "store/internal/compress.h"
#include "store/store.h"

struct pen_store {
    struct pen_db *db;
    struct pen_compressor *documents; /* made when the first one is stored */
    int64_t tidied_ms;                /* when pen_store_tidy last did what it does seldom */
};

/* The number of a job that is not removed. With `lock`, its row is locked by this transaction:
 * every write about a job does that first, then views, then batches. Within a transaction. Fails:
 * PEN_NOT_FOUND, PEN_GONE. */
bool pen_job_number(struct pen_store *store, const char *id, bool lock, int64_t *number,
                    struct pen_status *st);

/* Locks the claim's job and then its batch. *held = false: the batch is not leased under this
 * attempt. *done: it is done under it. Within a transaction. */
bool pen_claim_lock(struct pen_store *store, const struct pen_claim *claim, bool *held, bool *done,
                    struct pen_status *st);

#endif
