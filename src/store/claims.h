/* SPDX-License-Identifier: MIT */
/* The calls of workers and their supervisors: claims, commits, kept state, leases, lost workers,
 * the list of workers and their counters. This header is a part of store.h, whose promises hold
 * here. */
#ifndef PEN_STORE_CLAIMS_H
#define PEN_STORE_CLAIMS_H

#include "store/jobs.h"

enum { PEN_WORKER_ID_BYTES = 33 };

/* A claim: a batch leased to a worker under an attempt number. Work is measured in parts of the
 * job's expected work, PEN_WORK_ALL. */
struct pen_claim {
    int64_t batch, attempt; /* the fencing token */
    enum pen_batch_kind kind;
    char job_id[PEN_ID_BYTES];
    int view, first_tile, tile_count;
    int view_batches; /* render batches of this view; 1: its commit also brings the picture */
    int64_t pixels;
    unsigned char scene_sha256[32];
    int64_t submitted_ms;
    int64_t started_ms; /* when the job was first claimed */
    int64_t claimed_ms;
    int64_t timeout_ms;   /* of the job: limit of the workers' time in all; 0: none */
    int64_t job_spent_us; /* time of all workers on the job, without this claim */
    int64_t job_work;     /* done work of the job, without this batch */
    /* Set by the holder; 0 at first. Heartbeat, commit, release and fail add to the job's sums what
     * is not yet added. */
    int64_t spent_us;    /* working time on this claim, by a monotonic clock */
    int64_t estimate_ms; /* expected time of all workers on the job; 0: not known, and the heartbeat
                            reports no work */
    int64_t work;        /* done under this claim, for a heartbeat */
};

/* Claims the next batch: by priority, then turn, then age (README.md, Order). The job becomes
 * running. A quarantined batch goes only to a worker that holds no other batch. A worker that holds
 * a quarantined batch or a study gets none. `serial` is the worker's own count of claims. A call
 * that is repeated with the same number gets the same batch. *found is false if there is nothing to
 * do. */
bool pen_store_claim(struct pen_store *store, const char *worker, int64_t lease_ms, int64_t serial,
                     struct pen_claim *claim, bool *found, struct pen_status *st);

/* The result of a batch. */
struct pen_result {
    const float *rgb; /* of a render batch: tiles in order, each row by row; pixels * 3 values. Else
                         NULL. Every float is stored and read back bit for bit */
    int64_t pixels;
    int part_tiles; /* of a render batch: how many of its first tiles the result has; 0: all */
    int64_t work;   /* done part of the job's expected work, PEN_WORK_ALL; 0: in proportion to its
                       pixels */
    const char *stats;          /* JSON, kept as long as the job */
    int64_t handed_ns;          /* when the worker gave it to the store, by pen_clock_ns; 0: now */
    const char *layer, *format; /* of the artefact; NULL: none */
    const void *artefact;
    size_t artefact_bytes;
};

/* A worker's next claim, made in the transaction of a commit. */
struct pen_next {
    const char *worker;
    int64_t lease_ms, serial;
    bool found; /* out: there is a claim; false if the commit failed */
    struct pen_claim claim;
};

/* Commits a batch. `next` (may be NULL) claims the worker's next batch in the same transaction.
 *   - A result of the first tiles alone has no picture. It ends the batch as if the batch had only
 *     these tiles. The other tiles become an open batch of the same view, with the same turn.
 *   - The last commit of a view of several render batches adds the view's assemble batch, with the
 *     turn of the batch that ended.
 *   - The commit that ends a view must bring the view's picture. It is the commit of the view's
 *     only batch, or of its assemble batch. The commit of a study must bring its report.
 *   - The commit that ends the last view makes the job succeeded.
 * Fails: PEN_STALE; PEN_STORAGE_FULL, PEN_STORAGE, PEN_UNAVAILABLE (see pen_store_failure; the same
 * commit may always be repeated); PEN_INTERNAL (the result does not fit the batch). */
bool pen_store_commit(struct pen_store *store, const struct pen_claim *claim,
                      const struct pen_result *result, struct pen_next *next,
                      struct pen_status *st);

/* What a batch keeps: a state, and parts. The next worker that claims the batch, or a later batch
 * of its view, continues from it. A part stays until a part of the same name replaces it. */
struct pen_kept_part {
    const char *name; /* any name but PEN_KEPT_STATE */
    const void *data;
    size_t bytes;
};
struct pen_kept {
    /* Progress, which readers see: the finished runs of a study, or the finished pixels of a view
     * that is one batch. It never decreases. Below 0: it stays as it is. */
    int64_t done;
    const void *data; /* NULL: the state stays as it is */
    size_t bytes;
    const struct pen_kept_part *parts;
    int part_count;
};
#define PEN_KEPT_STATE "state"

/* Stores what the claim's batch keeps, its progress, and the claim's time and estimate, in one
 * transaction. It replaces what the view's batches kept before. It stays until the view or the job
 * ends. *outranked (may be NULL) is set as by pen_store_outranked.
 * Fails: PEN_STALE, PEN_STORAGE_FULL (the disk is full, or keep_bytes of pen_retention would be
 * exceeded). Nothing is stored then. */
bool pen_store_keep(struct pen_store *store, const struct pen_claim *claim,
                    const struct pen_kept *kept, bool *outranked, struct pen_status *st);

/* Tells whether the holder should release the claim. This is so if a batch of higher priority is
 * open. After a minute, it is so if any batch of the same priority is open. A released batch takes
 * a new turn, behind the open batches of its client. */
bool pen_store_outranked(struct pen_store *store, const struct pen_claim *claim, bool *outranked,
                         struct pen_status *st);

/* Appends what the batches of the claim's view have kept under this name: a part, or
 * PEN_KEPT_STATE.
 * Fails: PEN_NOT_FOUND (nothing yet), PEN_STORAGE (damaged). */
bool pen_store_kept(struct pen_store *store, const struct pen_claim *claim, const char *name,
                    struct pen_buf *out, struct pen_status *st);

/* Stores the expected time of all workers on the claim's job, for readers. Stores too the map of
 * its work (may be NULL), for other workers; the job has it until it ends.
 * Fails: PEN_STALE. */
bool pen_store_estimate(struct pen_store *store, const struct pen_claim *claim, int64_t estimate_ms,
                        const struct pen_buf *cost_map, struct pen_status *st);

/* Appends the map of an unfinished job's work, if it has one. */
bool pen_store_cost_map(struct pen_store *store, const char *id, struct pen_buf *out,
                        struct pen_status *st);

/* Gives a batch back without a result, and charges nothing. Does nothing if the batch is no longer
 * held. */
bool pen_store_release(struct pen_store *store, const struct pen_claim *claim,
                       struct pen_status *st);

/* Ends the claim's job as failed; `error` is a problem document, JSON. Fails: PEN_STALE. */
bool pen_store_fail(struct pen_store *store, const struct pen_claim *claim, const char *error,
                    struct pen_status *st);

/* Tells whether the claim still holds; if it does not, stop the work. Updates claim->job_spent_us
 * and claim->job_work. It writes if a third of the lease has passed, and extends the lease. It also
 * writes if it reports work (claim->estimate_ms), which readers see at once. Otherwise it only
 * reads.
 * Cost: a read, in most calls; call it often. */
bool pen_store_heartbeat(struct pen_store *store, struct pen_claim *claim, int64_t lease_ms,
                         bool *held, struct pen_status *st);

/* Opens the batches whose lease has expired, and quarantines them. Each job has its own
 * transaction. Nothing is charged, because it is not known how the worker ended. A lease that ends
 * later than its length from now counts as beginning now. *opened is the number of batches. */
bool pen_store_expire_leases(struct pen_store *store, int *opened, struct pen_status *st);

/* Opens the batches of all workers of this host whose process no longer exists, without waiting for
 * their leases, and quarantines them. A process is known by boot id, pid and start time. These
 * workers are removed from the list. A worker whose supervisor still exists is left to it, because
 * the supervisor may charge its end. */
bool pen_store_release_gone(struct pen_store *store, int *opened, struct pen_status *st);

enum pen_worker_end {
    PEN_WORKER_LEFT,   /* it was asked to stop, and returns its batches */
    PEN_WORKER_DIED,   /* another process killed it, or the reason is unknown */
    PEN_WORKER_CRASHED /* its own batch caused its end */
};

/* Makes the error of a job that has used up its attempts, from a batch that the worker held. It is
 * called outside any transaction, so it may read from the store.
 * Owns: returns a text from malloc(), which the store frees; NULL when out of memory. */
typedef char *pen_death_error_fn(void *user, const struct pen_claim *claim, int charges);

struct pen_worker_death {
    const char *worker;
    enum pen_worker_end end;
    pen_death_error_fn *error; /* required with PEN_WORKER_CRASHED */
    void *user;
};

/* Opens the batches of a worker that has ended; *opened is their number.
 *   - Unless the worker left, the batches are quarantined.
 *   - From its second loss of a worker in a row, a job waits. Each further loss doubles the time.
 *   - A crash is charged to the job if the worker held batches of that job only. max_attempts
 *     charges in a row end the job as failed.
 *   - A commit ends the quarantine of its batch, and the wait and the charges of its job.
 * Fails: PEN_NO_MEMORY, and as any write. */
bool pen_store_worker_ended(struct pen_store *store, const struct pen_worker_death *death,
                            int *opened, struct pen_status *st);

/* A worker as it describes itself. The store adds host, boot, pid and start time of this
 * process. */
struct pen_worker_new {
    const char *id; /* random, from pen_worker_id_make */
    int supervisor; /* the process that reports the worker's end by pen_store_worker_ended; 0:
                     * none */
    int threads;
    int64_t lease_ms;   /* length of its leases */
    int64_t rays_per_s; /* of its last batches, with all its threads; 0: not known */
};

/* Makes the id of a worker: 128 random bits as hexadecimal digits. */
void pen_worker_id_make(char id[PEN_WORKER_ID_BYTES]);

/* Stores or renews a worker in the list of workers. A worker calls it before its first claim, and
 * then from time to time. */
bool pen_store_worker_seen(struct pen_store *store, const struct pen_worker_new *worker,
                           struct pen_status *st);

/* Removes a worker from the list, if it is there. */
bool pen_store_worker_gone(struct pen_store *store, const char *id, struct pen_status *st);

/* A worker and a batch that it holds. */
struct pen_worker_record {
    const char *id, *host;
    int64_t pid;
    int threads;
    int64_t rays_per_s;
    int64_t started_ms, seen_ms; /* by the store's clock; seen_ms: when the worker last renewed its
                                    entry, or extended this lease */
    const char *job_id,
        *job_kind; /* NULL: the worker holds no batch, and the members below are not set */
    const char *view;
    int64_t batch, attempt;
    enum pen_batch_kind kind;
    int64_t pixels;
};

/* Calls `each` for every worker, oldest first. A worker with several batches has a call for each
 * batch. Stops when `each` returns false. The list may contain workers whose death was not
 * noticed. */
typedef bool pen_worker_fn(void *user, const struct pen_worker_record *worker);
bool pen_store_workers(struct pen_store *store, pen_worker_fn *each, void *user,
                       struct pen_status *st);

/* Counters for monitoring. A process counts in memory. A worker moves its counts to the store in
 * pen_store_worker_seen and pen_store_worker_gone, so a crash loses its last counts. */
enum pen_counter {
    PEN_COUNT_COMMIT_OK,
    PEN_COUNT_COMMIT_DUPLICATE,
    PEN_COUNT_COMMIT_STALE,
    PEN_COUNT_LEASES_LOST, /* expired, or of a worker that died */
    PEN_COUNT_RAYS,        /* of render batches; added by workers */
    PEN_COUNT_WORKER_STARTS,
    PEN_COUNT_TIMINGS /* the counters of enum pen_timing follow */
};

/* Histograms of times, counted in the same way. The time of a write transaction includes the wait
 * for other writers. A read is a transaction of several statements. */
enum pen_timing {
    PEN_TIMING_BATCH, /* working time of committed batches */
    PEN_TIMING_READ,
    PEN_TIMING_WRITE,
    PEN_TIMING_COUNT
};
enum { PEN_TIMING_BUCKETS = 12 };
enum { PEN_COUNTERS = PEN_COUNT_TIMINGS + PEN_TIMING_COUNT * (PEN_TIMING_BUCKETS + 2) };
struct pen_counters {
    uint64_t
        count[PEN_COUNTERS]; /* of a timing: PEN_TIMING_BUCKETS + 1 counts, and the sum in us */
};
extern const double pen_timing_bounds_s[PEN_TIMING_BUCKETS]; /* upper bounds, ascending */

/* Adds to a counter of this process. Threads: any. */
void pen_store_count(enum pen_counter counter, uint64_t count);

/* Reads all counters: what processes have moved to the store, plus the counts of this process that
 * it has not moved yet. */
bool pen_store_counters(struct pen_store *store, struct pen_counters *counters,
                        struct pen_status *st);

#endif
