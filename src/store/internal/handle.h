/* SPDX-License-Identifier: MIT */
/* What a handle on a store is, for the files of this room. */
#ifndef PEN_STORE_INTERNAL_HANDLE_H
#define PEN_STORE_INTERNAL_HANDLE_H

#include "store/db.h"
#include "store/internal/compress.h"
#include "store/store.h"

struct pen_store {
    struct pen_db *db;
    struct pen_compressor *documents; /* of scenes */
    struct pen_pixels *pixels;        /* made when the first ones are encoded */
};

/* Ends a write; if it is committed, wakes those who wait for changes. */
bool pen_write_end(struct pen_store *store, bool ok, struct pen_status *st);

/* Reads the first row's columns, which are numbers, into those given, up to NULL, and ends the
 * statement. Without a row they are 0. */
bool pen_row_numbers(struct pen_rows *rows, int64_t *first, ...) __attribute__((sentinel));

/* Every write about a job locks its row first, then views, then batches. The lock moves the job's
 * elapsed time on to now. All within a transaction. */

/* The number of a job that is not removed. `state` given: locks the job, and reads its state.
 * Fails: PEN_NOT_FOUND, PEN_GONE. */
bool pen_job_number(struct pen_store *store, const char *id, int64_t *number, int64_t *state,
                    struct pen_status *st);

/* Locks a job. */
bool pen_job_lock(struct pen_store *store, int64_t job, struct pen_status *st);

/* Makes a queued job running, unless another transaction has locked it. */
bool pen_job_start(struct pen_store *store, int64_t job, struct pen_status *st);

/* Ends a locked job and its batches, and drops what these keep; `error`: of a failed one. */
bool pen_job_end(struct pen_store *store, int64_t job, enum pen_job_state state, const char *error,
                 struct pen_status *st);

/* A batch as its holder's calls need it. */
struct pen_batch {
    int64_t number, job, view, kind, tile_count, pixels, told_pixels, work, spent_us;
    int64_t troubles; /* charges and losses of the job since its last commit */
    bool held, done;  /* it is leased, or done, under the claim's attempt */
};

/* Locks the claim's job, which becomes running, and reads its batch; and adds the claim's time to
 * both (claim->spent_us). A batch that is not held and not done is stale: nothing is added. */
bool pen_claim_lock(struct pen_store *store, const struct pen_claim *claim, struct pen_batch *batch,
                    struct pen_status *st);

/* As pen_claim_lock, for a claim that must hold. Fails: PEN_STALE, with `what` was refused. */
bool pen_claim_hold(struct pen_store *store, const struct pen_claim *claim, const char *what,
                    struct pen_batch *batch, struct pen_status *st);

/* Tells the work (below 0: the share of its pixels) and the pixels that a held batch has done so
 * far, and the job's estimate (0: as it was); none of them goes back. For a job's readers it is a
 * change. */
bool pen_claim_tell(struct pen_store *store, const struct pen_batch *batch, int64_t pixels,
                    int64_t work, int64_t estimate_ms, struct pen_status *st);

/* Opens leased batches of one locked job (all of a worker's, or one batch), which take new turns.
 * `lost` quarantines them and counts a loss of the job, whose second loss in a row and later ones
 * let them wait for a time that doubles. */
struct pen_opening {
    int64_t job, batch; /* batch 0: any */
    const char *worker; /* "": any */
    int64_t before_ms;  /* leases that end before it; INT64_MAX: all */
    bool lost;
};
bool pen_batches_open(struct pen_store *store, const struct pen_opening *opening, int64_t *opened,
                      struct pen_status *st);

/* The first turn that new batches of a job get, whose row of turns is locked (order.c). */
bool pen_turn_next(struct pen_store *store, int64_t job, int64_t *turn, struct pen_status *st);

/* A leased batch as a claim (claims.c); not found: there is no such batch. */
bool pen_claim_read(struct pen_store *store, int64_t batch, struct pen_claim *claim, bool *found,
                    struct pen_status *st);

/* Claims within a transaction (claims.c). */
bool pen_claim_next(struct pen_store *store, struct pen_next *next, struct pen_status *st);

/* Whether a claim's batch should give way (order.c). Within a transaction. */
bool pen_claim_outranked(struct pen_store *store, const struct pen_claim *claim, bool *outranked,
                         struct pen_status *st);

/* Fails if a job whose results are expected to take so many bytes is not accepted now
 * (retention.c). Within a transaction. `bytes` 0: any job. */
bool pen_intake(struct pen_store *store, int64_t bytes, struct pen_status *st);

/* A number by its name in `meta`; 0: there is none. */
bool pen_meta_get(struct pen_store *store, const char *name, int64_t *value, struct pen_status *st);
bool pen_meta_set(struct pen_store *store, const char *name, int64_t value, struct pen_status *st);

/* A text in `meta`. */
bool pen_meta_put(struct pen_store *store, const char *name, const char *text,
                  struct pen_status *st);

/* Fails with PEN_STORAGE_FULL if keep_bytes does not allow so many bytes that a batch keeps. */
bool pen_admit_kept(struct pen_store *store, int64_t bytes, struct pen_status *st);

/* Whether removal by age waits, because the clock has jumped ahead. */
bool pen_ages_wait(struct pen_store *store, int64_t now_ms, bool *wait, struct pen_status *st);

#endif
