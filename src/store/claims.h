/* SPDX-License-Identifier: MIT */
/* What workers and their supervisors do: claims, commits, what a batch keeps, leases, lost workers,
 * the list of workers and what they have counted. A part of store.h, whose promises hold here. */
#ifndef PEN_STORE_CLAIMS_H
#define PEN_STORE_CLAIMS_H

#include "store/jobs.h"

enum { PEN_WORKER_ID_BYTES = 33 };

/* A claim: a batch leased to a worker under an attempt number. Work is the share of the job's
 * expected work, of PEN_WORK_ALL. */
struct pen_claim {
    int64_t batch, attempt; /* the fencing token */
    enum pen_batch_kind kind;
    char job_id[PEN_ID_BYTES];
    int view, first_tile, tile_count;
    int view_batches; /* render batches of this view; 1: its commit brings the picture, too */
    int64_t pixels;
    unsigned char scene_sha256[32];
    int64_t submitted_ms;
    int64_t started_ms; /* the job's first claim */
    int64_t claimed_ms;
    int64_t timeout_ms;   /* of the job: how long workers may work on it in all; 0: none */
    int64_t job_spent_us; /* how long they have worked on it, without this claim */
    int64_t job_work;     /* the job's work that is done, without this batch */
    /* Set by the holder, 0 at first. Heartbeat, commit, release and fail add to the job what they
     * have not added yet. */
    int64_t spent_us;    /* how long it has worked on this claim, by a monotonic clock */
    int64_t estimate_ms; /* how long workers are expected to work on the job in all. 0: not known,
                            and the heartbeat tells no work */
    int64_t work;        /* that this claim has done, for a heartbeat */
};

/* Claims the next batch: by priority, then turn, then age (README.md, Order). The job becomes
 * running. A quarantined batch goes only to a worker that holds nothing else, and a worker that
 * holds a quarantined batch or a study gets nothing. `serial` is the worker's own count of claims:
 * a call that is repeated with the same number gets the batch that it got. *found = false: there is
 * nothing to do. */
bool pen_store_claim(struct pen_store *store, const char *worker, int64_t lease_ms, int64_t serial,
                     struct pen_claim *claim, bool *found, struct pen_status *st);

/* The result of a batch. */
struct pen_result {
    const float *rgb; /* of a render batch: tiles in order, each row by row; pixels * 3 values;
                         else NULL. Stored without loss: every float comes back bit for bit */
    int64_t pixels;
    int part_tiles; /* of a render batch: it has its first tiles only, so many; 0: all */
    int64_t work; /* the share of the job's expected work, of PEN_WORK_ALL; 0: that of its pixels */
    const char *stats;          /* JSON, kept as long as the job */
    int64_t handed_ns;          /* when it was given to the store, by pen_clock_ns; 0: now */
    const char *layer, *format; /* of the artefact; NULL: none */
    const void *artefact;
    size_t artefact_bytes;
};

/* The worker's next claim, made in the transaction of a commit. */
struct pen_next {
    const char *worker;
    int64_t lease_ms, serial;
    bool found; /* out: there is a claim; false if the commit failed */
    struct pen_claim claim;
};

/* Commits a batch; `next` (NULL: none) claims the next one in the same transaction.
 *  - A result of the first tiles alone, which has no picture, ends the batch as if it had only
 *    these; the others become an open batch of the same view, with the same turn.
 *  - The last commit of a view of several render batches adds the view's assemble batch, with the
 *    turn of the batch that ended.
 *  - The commit that ends a view (of its only batch, or of the assemble batch) must bring the
 *    view's picture, that of a study its report.
 *  - The commit that ends the last view makes the job succeeded.
 * Fails: PEN_STALE; PEN_STORAGE_FULL, PEN_STORAGE, PEN_UNAVAILABLE (see pen_store_failure; the same
 * commit may be repeated in any case); PEN_INTERNAL (the result does not fit the batch). */
bool pen_store_commit(struct pen_store *store, const struct pen_claim *claim,
                      const struct pen_result *result, struct pen_next *next,
                      struct pen_status *st);

/* What a batch keeps, so that the next worker to claim it, or a later batch of its view, goes on
 * from there: a state, and parts, each of which stays until one of its name replaces it. */
struct pen_kept_part {
    const char *name; /* anything but PEN_KEPT_STATE */
    const void *data;
    size_t bytes;
};
struct pen_kept {
    /* The runs that a study has finished; of a view that is one batch, pixels: readers see them as
     * done. Progress does not go back. Below 0: it stays as it is. */
    int64_t done;
    const void *data; /* NULL: the state stays as it is */
    size_t bytes;
    const struct pen_kept_part *parts;
    int part_count;
};
#define PEN_KEPT_STATE "state"

/* Stores what the claim's batch keeps until its view ends or its job, in place of what the view's
 * batches kept before, with its progress and the claim's time and estimate, in one transaction.
 * *outranked (may be NULL): as pen_store_outranked tells. Fails: PEN_STALE; PEN_STORAGE_FULL, also
 * if the store may not hold so much (pen_retention.keep_bytes). Nothing is stored then. */
bool pen_store_keep(struct pen_store *store, const struct pen_claim *claim,
                    const struct pen_kept *kept, bool *outranked, struct pen_status *st);

/* Whether the holder should release the claim: a batch of higher priority is open; or the claim is
 * held for a minute, and any batch of its own priority is open. A batch that is released takes a
 * new turn, behind those of its client that are open. */
bool pen_store_outranked(struct pen_store *store, const struct pen_claim *claim, bool *outranked,
                         struct pen_status *st);

/* Appends what the batches of the claim's view have kept: the part of that name, or PEN_KEPT_STATE.
 * Fails: PEN_NOT_FOUND (nothing yet), PEN_STORAGE (damaged). */
bool pen_store_kept(struct pen_store *store, const struct pen_claim *claim, const char *name,
                    struct pen_buf *out, struct pen_status *st);

/* Stores how long workers are expected to work on the claim's job in all, for readers, and for
 * other workers the map of its work, which it has until it ends; NULL: none. Fails: PEN_STALE. */
bool pen_store_estimate(struct pen_store *store, const struct pen_claim *claim, int64_t estimate_ms,
                        const struct pen_buf *cost_map, struct pen_status *st);

/* Appends the map of an unfinished job's work; nothing, if it has none. */
bool pen_store_cost_map(struct pen_store *store, const char *id, struct pen_buf *out,
                        struct pen_status *st);

/* Gives a batch back without a result or a charge. Does nothing if it is no longer held. */
bool pen_store_release(struct pen_store *store, const struct pen_claim *claim,
                       struct pen_status *st);

/* Ends the claim's job as failed; `error` is a problem document, JSON. Fails: PEN_STALE. */
bool pen_store_fail(struct pen_store *store, const struct pen_claim *claim, const char *error,
                    struct pen_status *st);

/* Tells whether the claim still holds (if not, stop working on it), and brings claim->job_spent_us
 * and claim->job_work up to date. Most calls only read, so it may be called often. A call writes
 * once a third of the lease has gone, which it extends, and if it tells of work
 * (claim->estimate_ms), which readers see at once. */
bool pen_store_heartbeat(struct pen_store *store, struct pen_claim *claim, int64_t lease_ms,
                         bool *held, struct pen_status *st);

/* Opens the batches whose lease has expired, each job's in a transaction of its own, and
 * quarantines them. Nothing is charged, because it is not known how the worker ended. A lease that
 * ends later than now + its length counts as beginning now. *opened is the number of batches. */
bool pen_store_expire_leases(struct pen_store *store, int *opened, struct pen_status *st);

/* The same for the batches of all workers of this host whose process no longer exists (boot id, pid
 * and start time tell), without waiting for their leases; removes these workers from the list. A
 * worker whose supervisor exists is left to that one, which may charge its end. */
bool pen_store_release_gone(struct pen_store *store, int *opened, struct pen_status *st);

enum pen_worker_end {
    PEN_WORKER_LEFT,   /* it was told to stop, and gives its batches back */
    PEN_WORKER_DIED,   /* another process killed it, or the reason is unknown */
    PEN_WORKER_CRASHED /* the batch it worked on caused its end */
};

/* Makes the error of a job that has used up its attempts, from a batch that the worker held. Called
 * outside any transaction, so it may read from the store. Owns: returns a malloc()ed text, NULL
 * when out of memory. */
typedef char *pen_death_error_fn(void *user, const struct pen_claim *claim, int charges);

struct pen_worker_death {
    const char *worker;
    enum pen_worker_end end;
    pen_death_error_fn *error; /* required with PEN_WORKER_CRASHED */
    void *user;
};

/* Opens the batches of a worker that has ended; *opened is their number.
 *  - Unless the worker left, they are quarantined.
 *  - A job that loses workers repeatedly is paused, for a time that doubles with each loss.
 *  - A crash is charged to the job if the worker held batches of that job only. max_attempts
 *    charges in a row end the job as failed.
 *  - A commit ends the quarantine of its batch, and the pause and the charges of its job.
 * Fails: PEN_NO_MEMORY, and as any write. */
bool pen_store_worker_ended(struct pen_store *store, const struct pen_worker_death *death,
                            int *opened, struct pen_status *st);

/* A worker as it describes itself. Its host, boot, pid and start time are this process's. */
struct pen_worker_new {
    const char *id; /* random, from pen_worker_id_make */
    int supervisor; /* the process that reports its end by pen_store_worker_ended; 0: none */
    int threads;
    int64_t lease_ms;   /* length of its leases */
    int64_t rays_per_s; /* by its last batches, with all its threads; 0: not known */
};

/* Makes the id of a worker: 128 random bits as hexadecimal digits. */
void pen_worker_id_make(char id[PEN_WORKER_ID_BYTES]);

/* Stores or renews a worker's row in the list of workers: before the first claim, and from time to
 * time. */
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
                                    row, or extended this lease */
    const char *job_id, *job_kind; /* NULL: it holds no batch, and the members below are not set */
    const char *view;
    int64_t batch, attempt;
    enum pen_batch_kind kind;
    int64_t pixels;
};

/* Calls `each` for every worker, oldest first: once for every batch that it holds, or once if it
 * holds none; stops when it returns false. The list may contain workers that died unnoticed. */
typedef bool pen_worker_fn(void *user, const struct pen_worker_record *worker);
bool pen_store_workers(struct pen_store *store, pen_worker_fn *each, void *user,
                       struct pen_status *st);

/* Counters of what the processes have done, for monitoring. A process counts in memory; a worker
 * moves its numbers to the store (pen_store_worker_seen, pen_store_worker_gone), so a crash loses
 * the last ones. */
enum pen_counter {
    PEN_COUNT_COMMIT_OK,
    PEN_COUNT_COMMIT_DUPLICATE,
    PEN_COUNT_COMMIT_STALE,
    PEN_COUNT_LEASES_LOST, /* expired, or their worker found dead */
    PEN_COUNT_RAYS,        /* of render batches; added by workers */
    PEN_COUNT_WORKER_STARTS,
    PEN_COUNT_TIMINGS /* those of enum pen_timing follow */
};

/* Histograms of times, counted likewise. A write transaction's time includes the wait for other
 * writers; a read is a transaction of several statements. */
enum pen_timing {
    PEN_TIMING_BATCH, /* that workers spent on the batches that were committed */
    PEN_TIMING_READ,
    PEN_TIMING_WRITE,
    PEN_TIMING_COUNT
};
enum { PEN_TIMING_BUCKETS = 12 };
enum { PEN_COUNTERS = PEN_COUNT_TIMINGS + PEN_TIMING_COUNT * (PEN_TIMING_BUCKETS + 2) };
struct pen_counters {
    uint64_t
        count[PEN_COUNTERS]; /* of a timing: PEN_TIMING_BUCKETS + 1 numbers, and the sum in us */
};
extern const double pen_timing_bounds_s[PEN_TIMING_BUCKETS]; /* upper bounds, ascending */

/* Adds to a counter of this process. Threads: any. */
void pen_store_count(enum pen_counter counter, uint64_t count);

/* The sums of what processes have moved to the store, and what this one has not. */
bool pen_store_counters(struct pen_store *store, struct pen_counters *counters,
                        struct pen_status *st);

#endif
