/* SPDX-License-Identifier: MIT */
/* The policy of the store: the handle behind store.h, helpers that its files share, and each call
 * of store.h as pen_policy_…, without what store.c adds to all of them (health, signals,
 * observers). src/store/README.md has the rules. */
#ifndef PEN_STORE_INTERNAL_POLICY_H
#define PEN_STORE_INTERNAL_POLICY_H

#include "store/internal/compress.h"
#include "store/internal/driver.h"

struct pen_store {
    struct pen_driver *driver;
    char identity[PEN_STORE_IDENTITY_BYTES]; /* from the URL, for the driver; "": any */
    struct pen_compressor *compressor;
    struct pen_pixels *pixels; /* encodes results that come as floats; NULL before the first */
    struct pen_buf blob;       /* the blob last read, as stored */
    float *rgb;                /* buffer for decoded pixels */
    size_t rgb_pixels;         /* capacity of rgb */
    bool work;                 /* this call made a batch claimable: give PEN_SIGNAL_WORK */
    bool changed;              /* this call changed a job: give PEN_SIGNAL_CHANGES */
    int64_t told_ms;           /* when retention.c last logged that the store is too large */
    int64_t waits_ms;          /* since when retention.c waits for values being written; 0: not */
    bool outcome_unknown;      /* the last call failed, and its changes may be stored */
    bool lacks_space;          /* as pen_store_lacks_space */
    char
        waiting[PEN_ID_BYTES]; /* the job whose result this handle could not store last; "": none */
    const struct pen_store_observer *observer; /* NULL: none */
    /* Used by health.c: */
    int depth;      /* of nested calls: a caller's function may call again */
    uint32_t epoch; /* the number of the store's faults when the driver's handle was opened */
};

/* Runs `body` in a write transaction: committed if it returns true, else rolled back. */
typedef bool pen_body(struct pen_store *store, void *arg, struct pen_status *st);
bool pen_store_write(struct pen_store *store, pen_body *body, void *arg, struct pen_status *st);

/* Runs `body` on one unchanging state of the database. */
bool pen_store_read(struct pen_store *store, pen_body *body, void *arg, struct pen_status *st);

/* Fails with PEN_GONE if the job was removed, else with PEN_NOT_FOUND. Fails: always. */
bool pen_fail_missing(struct pen_store *store, const char *id, struct pen_status *st);

/* Finds a job. Fails: PEN_NOT_FOUND, PEN_GONE. */
bool pen_find_job(struct pen_store *store, const char *id, struct pen_job_key *job,
                  struct pen_status *st);

/* Makes a job cancelled or failed, ends its open and leased batches, and drops what they kept;
 * inside a transaction. */
bool pen_end_job(struct pen_store *store, int64_t job, enum pen_job_state state, const char *error,
                 struct pen_status *st);

/* Leases the next open batch to a worker; inside a transaction. */
bool pen_take_next(struct pen_store *store, struct pen_next *next, struct pen_status *st);

/* Tells whether a batch is leased under the attempt of a claim; inside a transaction or before one.
 * row->state is PEN_BATCH_STATE_COUNT if there is no such batch. */
bool pen_check_fence(struct pen_store *store, const struct pen_claim *claim,
                     struct pen_batch_row *row, bool *held, struct pen_status *st);

/* Whether the blob that was loaded into store->blob has this checksum, if one was stored with it.
 */
bool pen_blob_is_intact(const struct pen_store *store, bool has_checksum, int64_t checksum);

/* Decodes the pixels that were loaded into store->blob, into store->rgb. */
bool pen_decode_pixels(struct pen_store *store, int64_t pixels, struct pen_status *st);

/* tally.c: sets a sum that is a state. */
void pen_tally_set(struct pen_store *store, enum pen_tally tally, uint64_t value);

/* tally.c: notes the space for which a new job was refused, and tells it for two minutes; then, and
 * before the first, 0. */
void pen_note_wanted_room(struct pen_store *store, int64_t bytes);
int64_t pen_wanted_room(struct pen_store *store);

/* retention.c: refuses a new job, whose views are stored, if its results may be too much for what
 * the store may hold; inside a transaction. Fails: PEN_STORAGE_FULL, PEN_TOO_LARGE. */
bool pen_admit_bytes(struct pen_store *store, int64_t job, struct pen_status *st);

/* retention.c: refuses so many bytes that a batch keeps, if the store may not hold them beside what
 * it has and what unfinished jobs are expected to store. Fails: PEN_STORAGE_FULL. */
bool pen_admit_kept(struct pen_store *store, int64_t bytes, struct pen_status *st);

/* tally.c: counts a time. */
void pen_timing_add(struct pen_store *store, enum pen_timing timing, int64_t us);

/* times.c: how long ago something was. If it lies in the future, the clock was set back since: that
 * counts as longer ago than anything. */
int64_t pen_since_ms(int64_t then_ms, int64_t now_ms);

/* times.c: mends the stored times that lie in the future (times_mend of the driver), if there are
 * any. Outside a transaction. */
bool pen_times_mend(struct pen_store *store, int64_t now_ms, struct pen_status *st);

/* times.c: whether nothing is to be removed for its age: the clock was found more than a day ahead
 * of the last housekeeping, less than a day ago. Each call is a housekeeping. A machine that was
 * off for longer looks the same. Outside a transaction. */
bool pen_ages_wait(struct pen_store *store, int64_t now_ms, bool *wait, struct pen_status *st);

/* As pen_store_outranked. */
bool pen_outranked(struct pen_driver *driver, const struct pen_claim *claim, int64_t now_ms,
                   bool *outranked, struct pen_status *st);

/* The share of a job's work that so many pixels of it are, if no pixel costs more than another. */
int64_t pen_work_of_pixels(const struct pen_batch_row *batch, int64_t pixels);

/* Adds to the job the time that the claim's holder has told (pen_claim.spent_us) and that was not
 * added before; inside a transaction. Does nothing if the batch is not leased under the claim. */
bool pen_charge_time(struct pen_store *store, const struct pen_claim *claim, struct pen_status *st);

/* Blobs. pen_blob_begin gives the first range, which is stored with its row; pen_blob_finish writes
 * the other ranges; pen_blob_load reads a whole blob into store->blob. Fails: PEN_NOT_FOUND (its
 * row is gone), PEN_STORAGE (also: the row has less), PEN_NO_MEMORY. */
struct pen_blob_start pen_blob_begin(const void *data, size_t bytes);
bool pen_blob_finish(struct pen_store *store, enum pen_blob_kind kind, int64_t number,
                     const void *data, size_t bytes, struct pen_status *st);
bool pen_blob_load(struct pen_store *store, enum pen_blob_kind kind, int64_t number, size_t bytes,
                   struct pen_status *st);

/* Values on their way into the store (values.c). One of PEN_BLOB_RANGE_BYTES goes into its row; a
 * larger one is stored before as a large object, which the row then gets. */
struct pen_value {
    const void *data; /* Owns: the caller, until the row is written */
    size_t bytes;
    int64_t checksum; /* pen_checksum of it */
    int64_t object;   /* 0: none */
};

/* Begins to store a value, outside any transaction: a large one in ranges, each in a transaction,
 * between which others write. fence: a claim that must hold all the time; NULL:
 * none. Fails: PEN_STALE (the claim is lost), and as any write; nothing is left then. */
bool pen_value_store(struct pen_store *store, const struct pen_claim *fence, const void *data,
                     size_t bytes, struct pen_value *value, struct pen_status *st);
/* The same of a value that is stored only while there is space for it: each range only if `admit`
 * allows as many bytes more as are left of the value. Writers that store several values at once
 * so stay within the space together. */
typedef bool pen_value_admit(struct pen_store *store, int64_t bytes, struct pen_status *st);
bool pen_value_store_if(struct pen_store *store, const struct pen_claim *fence,
                        pen_value_admit *admit, const void *data, size_t bytes,
                        struct pen_value *value, struct pen_status *st);
/* As pen_value_store_if, of one of many values that are removed together: each is a large object,
 * however small it is, so that they are removed in slices. */
bool pen_value_store_apart(struct pen_store *store, const struct pen_claim *fence,
                           pen_value_admit *admit, const void *data, size_t bytes,
                           struct pen_value *value, struct pen_status *st);
/* As pen_blob_begin and pen_blob_finish, in the transaction that writes the row. */
struct pen_blob_start pen_value_begin(const struct pen_value *value);
bool pen_value_finish(struct pen_store *store, enum pen_blob_kind kind, int64_t number,
                      const struct pen_value *value, struct pen_status *st);
/* Gives up a value whose row was not written: its space is freed soon, not only in a minute. */
void pen_value_drop(struct pen_store *store, const struct pen_value *value);
/* Writes the row of a value by `write`; gives the value up if that fails. */
bool pen_value_write(struct pen_store *store, const struct pen_value *value, pen_body *write,
                     void *arg, struct pen_status *st);
/* Finds a large object that no row has any more, and whose writer has ended. */
bool pen_value_unused(struct pen_store *store, int64_t *object, bool *found, struct pen_status *st);
/* Removes a slice of such an object. *more: there was one. */
bool pen_values_shrink(struct pen_store *store, bool *more, struct pen_status *st);

/* What batches keep are artefacts of their view, in this layer; each part's name is its format. */
#define PEN_KEPT_LAYER "kept"

/* Notes that a form of a picture was used, if it can be made again. */
void pen_note_use(struct pen_store *store, const struct pen_artefact_row *artefact);

/* Stores an artefact, whose number is *number; inside a transaction. */
bool pen_put_artefact(struct pen_store *store, const struct pen_artefact_key *key,
                      const struct pen_value *value, int64_t *number, struct pen_status *st);

/* The calls of store.h, see there. */
bool pen_policy_submit(struct pen_store *store, const struct pen_job_new *job,
                       enum pen_submit_result *result, struct pen_buf *first_answer,
                       struct pen_status *st);
/* Whether this submit was answered before, and how; reads only. */
bool pen_policy_submitted(struct pen_store *store, const struct pen_job_new *job,
                          enum pen_submit_result *result, struct pen_buf *first_answer, bool *known,
                          struct pen_status *st);
bool pen_policy_job(struct pen_store *store, const char *id, struct pen_job_record *job,
                    struct pen_status *st);
bool pen_policy_jobs(struct pen_store *store, const struct pen_job_filter *filter,
                     struct pen_job_record **jobs, int *count, struct pen_status *st);
bool pen_policy_scene(struct pen_store *store, const char *id, struct pen_buf *scene,
                      struct pen_status *st);
bool pen_policy_check_client(struct pen_store *store, const char *id, const char *client,
                             struct pen_status *st);
bool pen_policy_cancel(struct pen_store *store, const char *id, const char *client,
                       struct pen_status *st);
bool pen_policy_delete(struct pen_store *store, const char *id, const char *client,
                       const char *stats, struct pen_status *st);
bool pen_policy_removed_stats(struct pen_store *store, const char *id, struct pen_buf *stats,
                              struct pen_status *st);
bool pen_policy_purge(struct pen_store *store, int64_t key_age_ms, int64_t stats_age_ms,
                      struct pen_status *st);
bool pen_policy_set_retention(struct pen_store *store, const struct pen_retention *retention,
                              struct pen_status *st);
bool pen_policy_retention(struct pen_store *store, struct pen_retention *out,
                          struct pen_status *st);
bool pen_policy_expired(struct pen_store *store, char id[PEN_ID_BYTES], bool *found,
                        struct pen_status *st);
bool pen_policy_intake(struct pen_store *store, struct pen_status *st);
bool pen_policy_cache_put(struct pen_store *store, const char *id,
                          const struct pen_artefact_key *key, const void *data, size_t bytes,
                          struct pen_status *st);
bool pen_policy_evict(struct pen_store *store, bool *more, struct pen_status *st);
bool pen_policy_purge_slice(struct pen_store *store, bool *more, struct pen_status *st);
bool pen_policy_claim(struct pen_store *store, const char *worker, int64_t lease_ms,
                      struct pen_claim *claim, bool *found, struct pen_status *st);
bool pen_policy_commit(struct pen_store *store, const struct pen_claim *claim,
                       const struct pen_result *result, struct pen_next *next,
                       struct pen_status *st);
bool pen_policy_progress(struct pen_store *store, const struct pen_claim *claim, int64_t done,
                         struct pen_status *st);
bool pen_policy_keep(struct pen_store *store, const struct pen_claim *claim,
                     const struct pen_kept *kept, bool *outranked, struct pen_status *st);
bool pen_policy_estimate(struct pen_store *store, const struct pen_claim *claim,
                         int64_t estimate_ms, const struct pen_buf *cost_map,
                         struct pen_status *st);
bool pen_policy_release(struct pen_store *store, const struct pen_claim *claim,
                        struct pen_status *st);
bool pen_policy_set_back(struct pen_store *store, const struct pen_claim *claim, const char *error,
                         bool always, bool *set_back, struct pen_status *st);
bool pen_policy_fail(struct pen_store *store, const struct pen_claim *claim, const char *error,
                     struct pen_status *st);
bool pen_policy_heartbeat(struct pen_store *store, struct pen_claim *claim, int64_t lease_ms,
                          bool *held, struct pen_status *st);
bool pen_policy_expire_leases(struct pen_store *store, const char *dead_worker, int *opened,
                              struct pen_status *st);
bool pen_policy_release_dead(struct pen_store *store, int *opened, struct pen_status *st);
bool pen_policy_worker_ended(struct pen_store *store, const struct pen_worker_death *death,
                             int *opened, struct pen_status *st);
bool pen_policy_pixels(struct pen_store *store, const char *id, int view, pen_pixels_fn *each,
                       void *user, struct pen_status *st);
bool pen_policy_stats(struct pen_store *store, const char *id, pen_stats_fn *each, void *user,
                      struct pen_status *st);
bool pen_policy_batches(struct pen_store *store, const char *id, pen_batch_fn *each, void *user,
                        struct pen_status *st);
bool pen_policy_commits(struct pen_store *store, const char *id, int64_t after, pen_commit_fn *each,
                        void *user, struct pen_status *st);
bool pen_policy_artefact(struct pen_store *store, const char *id, int view, const char *layer,
                         const char *format, struct pen_buf *out, struct pen_status *st);
bool pen_policy_artefact_put(struct pen_store *store, const struct pen_claim *claim,
                             const char *layer, const char *format, const void *data, size_t bytes,
                             struct pen_status *st);
bool pen_policy_keep_part(struct pen_store *store, const struct pen_claim *claim,
                          const struct pen_kept_part *part, struct pen_status *st);
bool pen_policy_worker_seen(struct pen_store *store, const struct pen_worker_new *worker,
                            struct pen_status *st);
bool pen_policy_worker_gone(struct pen_store *store, const char *id, struct pen_status *st);
bool pen_policy_workers(struct pen_store *store, pen_worker_fn *each, void *user,
                        struct pen_status *st);
bool pen_policy_scrub(struct pen_store *store, struct pen_scrub *scrub, bool *more,
                      struct pen_status *st);
bool pen_policy_audit(struct pen_store *store, pen_audit_fn *each, void *user, int *found,
                      struct pen_status *st);

#endif
