/* SPDX-License-Identifier: MIT */
/* A handle on a store, for the files of this module. */
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

/* Ends a write. If it has committed, wakes all who wait for changes. */
bool pen_write_end(struct pen_store *store, bool ok, struct pen_status *st);

/* Reads columns of the first row, which are numbers, into the given integers, up to NULL, and ends
 * the statement. Without a row they are 0. */
bool pen_row_numbers(struct pen_rows *rows, int64_t *first, ...) __attribute__((sentinel));

/* The calls below run within a transaction. Every write about a job locks the job's row first, then
 * views, then batches. The lock also moves the job's elapsed time on to now. */

/* Finds the number of a job that is not removed. With `state` (may be NULL), locks the job and
 * reads its state.
 * Fails: PEN_NOT_FOUND, PEN_GONE. */
bool pen_job_number(struct pen_store *store, const char *id, int64_t *number, int64_t *state,
                    struct pen_status *st);

/* Locks a job. */
bool pen_job_lock(struct pen_store *store, int64_t job, struct pen_status *st);

/* Makes a queued job running, unless another transaction has locked it. */
bool pen_job_start(struct pen_store *store, int64_t job, struct pen_status *st);

/* Ends a locked job and its batches, and drops what the batches keep. `error` is the error of a
 * failed job. */
bool pen_job_end(struct pen_store *store, int64_t job, enum pen_job_state state, const char *error,
                 struct pen_status *st);

/* A batch, with the columns that the calls of its holder need. */
struct pen_batch {
    int64_t number, job, view, kind, tile_count, pixels, told_pixels, work, spent_us;
    int64_t troubles; /* charges and losses of the job since its last commit */
    bool held, done;  /* leased, or done, under the claim's attempt */
};

/* Locks the claim's job, reads its batch, and adds the claim's time (claim->spent_us) to both. A
 * queued job becomes running. If the batch is neither held nor done, it is stale and nothing is
 * added. */
bool pen_claim_lock(struct pen_store *store, const struct pen_claim *claim, struct pen_batch *batch,
                    struct pen_status *st);

/* As pen_claim_lock, for a claim that must hold.
 * Fails: PEN_STALE; its message ends with `what`. */
bool pen_claim_hold(struct pen_store *store, const struct pen_claim *claim, const char *what,
                    struct pen_batch *batch, struct pen_status *st);

/* Stores the pixels and the work that a held batch has done so far, and the job's estimate. Work
 * below 0 means: in proportion to the pixels. An estimate of 0 leaves the stored estimate. Pixels
 * and work never decrease. Readers of the job see a change. */
bool pen_claim_tell(struct pen_store *store, const struct pen_batch *batch, int64_t pixels,
                    int64_t work, int64_t estimate_ms, struct pen_status *st);

/* Opens leased batches of one locked job, which take new turns: all batches of a worker, or one
 * batch. `lost` quarantines them and counts a loss of the job. From the second loss in a row, the
 * job's batches wait for a time that doubles with each loss. */
struct pen_opening {
    int64_t job, batch; /* 0: any batch */
    const char *worker; /* "": any worker */
    int64_t before_ms;  /* only leases that end before it; INT64_MAX: all */
    bool lost;
};
bool pen_batches_open(struct pen_store *store, const struct pen_opening *opening, int64_t *opened,
                      struct pen_status *st);

/* Finds the first turn for new batches of a job, and locks its row of turns (order.c). */
bool pen_turn_next(struct pen_store *store, int64_t job, int64_t *turn, struct pen_status *st);

/* Reads a leased batch as a claim (claims.c). *found is false if there is no such batch. */
bool pen_claim_read(struct pen_store *store, int64_t batch, struct pen_claim *claim, bool *found,
                    struct pen_status *st);

/* Claims a batch, within a transaction (claims.c). */
bool pen_claim_next(struct pen_store *store, struct pen_next *next, struct pen_status *st);

/* Tells whether the holder of a claim should release it (order.c), within a transaction. */
bool pen_claim_outranked(struct pen_store *store, const struct pen_claim *claim, bool *outranked,
                         struct pen_status *st);

/* Fails if a job with expected results of this size is not accepted now (retention.c), within a
 * transaction. `bytes` 0 stands for any job. */
bool pen_intake(struct pen_store *store, int64_t bytes, struct pen_status *st);

/* Reads or stores a number by its name in the table `meta`. A missing number is 0. */
bool pen_meta_get(struct pen_store *store, const char *name, int64_t *value, struct pen_status *st);
bool pen_meta_set(struct pen_store *store, const char *name, int64_t value, struct pen_status *st);

/* Stores a text in the table `meta`. */
bool pen_meta_put(struct pen_store *store, const char *name, const char *text,
                  struct pen_status *st);

/* Fails with PEN_STORAGE_FULL if keep_bytes leaves no space for `bytes` that a batch keeps. */
bool pen_admit_kept(struct pen_store *store, int64_t bytes, struct pen_status *st);

/* Tells whether removal by age waits, because the clock has jumped ahead. */
bool pen_ages_wait(struct pen_store *store, int64_t now_ms, bool *wait, struct pen_status *st);

#endif
