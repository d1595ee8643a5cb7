/* SPDX-License-Identifier: MIT */
/* Results: pixels, statistics, commits, artefacts. This header is a part of store.h, whose promises
 * hold here. */
#ifndef PEN_STORE_RESULTS_H
#define PEN_STORE_RESULTS_H

#include "store/claims.h"

/* Calls `each` for every committed render batch of a view, in the order of tiles. Stops when it
 * returns false. `rgb` is valid during the call.
 * Fails: PEN_NOT_FOUND (no such job), PEN_STORAGE (damaged pixels). */
typedef bool pen_pixels_fn(void *user, int first_tile, int tile_count, const float *rgb,
                           int64_t pixels);
bool pen_store_pixels(struct pen_store *store, const char *id, int view, pen_pixels_fn *each,
                      void *user, struct pen_status *st);

/* Calls `each` for the statistics of every committed batch of a job, oldest batch first. Stops when
 * it returns false.
 * Fails: PEN_NOT_FOUND (no such job). */
struct pen_batch_stats {
    enum pen_batch_kind kind;
    int view;
    int64_t commit_us; /* how long the worker waited for its commit */
    const char *stats;
};
typedef bool pen_stats_fn(void *user, const struct pen_batch_stats *batch);
bool pen_store_stats(struct pen_store *store, const char *id, pen_stats_fn *each, void *user,
                     struct pen_status *st);

/* The place of a committed render batch in its view. */
struct pen_commit_record {
    int64_t revision; /* the job's revision after this commit */
    int view, first_tile, tile_count;
};

/* Calls `each` for the render batches that were committed after a revision of the job, in the order
 * of their commits. Stops when it returns false. Every commit gives its job a new revision, so no
 * two batches have the same revision.
 * Fails: PEN_NOT_FOUND (no such job). */
typedef bool pen_commit_fn(void *user, const struct pen_commit_record *commit);
bool pen_store_commits(struct pen_store *store, const char *id, int64_t after, pen_commit_fn *each,
                       void *user, struct pen_status *st);

/* Appends an artefact of a job to *out. View -1 is an artefact of all views. If *out was empty, it
 * then has exactly the size of the artefact.
 * Fails: PEN_NOT_FOUND, PEN_STORAGE (damaged). */
bool pen_store_artefact(struct pen_store *store, const char *id, int view, const char *layer,
                        const char *format, struct pen_buf *out, struct pen_status *st);

/* Stores an artefact of the view of the claim's batch, before the commit. It replaces an artefact
 * of the same layer and format.
 * Fails: PEN_STALE (nothing is stored). */
bool pen_store_artefact_put(struct pen_store *store, const struct pen_claim *claim,
                            const char *layer, const char *format, const void *data, size_t bytes,
                            struct pen_status *st);

#endif
