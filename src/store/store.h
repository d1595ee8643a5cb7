/* SPDX-License-Identifier: MIT */
/* The durable store: the only door between the api process and the workers. Jobs, their scene
 * documents, batches with leases, committed pixels, artefacts, idempotency keys and workers.
 * SQLite is the first implementation; PostgreSQL comes behind this same header (src/store/ops.h
 * holds the table that pen_store_* calls go through).
 *
 * What it promises
 *  - A function that returned true has its effect on disk (WAL, synchronous=FULL).
 *  - A commit is one transaction: pixels, statistics, artefact and state together. It is refused
 *    with PEN_STALE unless the batch is still leased under the same attempt number.
 *  - A commit repeated with the same claim succeeds as a duplicate and changes nothing.
 *  - After a failed read, write or fsync, or when the disk is full, what the call cannot promise it
 *    refuses (PEN_STORAGE, PEN_STORAGE_FULL), for all handles of all processes, and the store is
 *    used again as soon as it was reopened, checked and written to: handles stay valid, callers
 *    just call again (src/store/health.h has the rules).
 *  - Leases use the store's clock only.
 *  - Everything stored as text is opaque here (JSON written by room jobs).
 *
 * Threads: a handle is used by one thread at a time; open one per thread. Handles of different
 * processes may be open on the same store. */
#ifndef PEN_STORE_STORE_H
#define PEN_STORE_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/buf.h"
#include "base/status.h"
#include "store/pixels.h"

enum { PEN_ID_BYTES = 37 }; /* UUID text and its end */

enum pen_job_state {
    PEN_JOB_QUEUED,
    PEN_JOB_RUNNING,
    PEN_JOB_SUCCEEDED,
    PEN_JOB_FAILED,
    PEN_JOB_CANCELLED,
    PEN_JOB_STATE_COUNT
};

enum pen_batch_state {
    PEN_BATCH_OPEN,   /* may be claimed */
    PEN_BATCH_LEASED, /* a worker holds an attempt */
    PEN_BATCH_DONE,   /* result committed */
    PEN_BATCH_ENDED,  /* its job failed or was cancelled */
    PEN_BATCH_STATE_COUNT
};

enum pen_batch_kind {
    PEN_BATCH_RENDER,   /* tiles of a view */
    PEN_BATCH_ASSEMBLE, /* makes a view's picture from its committed batches */
    PEN_BATCH_STUDY     /* the whole of a job that measures; its worker holds nothing else */
};

const char *pen_job_state_name(enum pen_job_state state);
bool pen_job_state_of_name(const char *name, enum pen_job_state *state);

static inline bool pen_job_state_ended(enum pen_job_state state)
{
    return state >= PEN_JOB_SUCCEEDED;
}

struct pen_store;

/* Opens a store: a file path (SQLite; folders are made) or a postgres:// URL (to come).
 * Creates and migrates it as needed. Fails: PEN_STORAGE (not a Penumbra store, damaged, newer
 * schema, no permission: the message says what to do, and the file is as it was), PEN_UNSUPPORTED
 * (postgres://), PEN_STORAGE_FULL, PEN_UNAVAILABLE, PEN_NO_MEMORY. */
struct pen_store *pen_store_open(const char *url, struct pen_status *st);
void pen_store_close(struct pen_store *store);

/* Reads the whole store, and its log, for damage. The daemon does so once at its start.
 * Fails: PEN_STORAGE with the first damage found. Cost: reads every page. */
bool pen_store_check(struct pen_store *store, struct pen_status *st);

/* Whether new work gets to disk now; the reason if not. */
bool pen_store_probe(struct pen_store *store, struct pen_status *st);

/* One call that was made on a handle, as whoever looks on is told: for tests and benches. Told of
 * are the calls that change a store and those that a worker makes. */
struct pen_store_call {
    const char *name;        /* "claim", "commit", … */
    int64_t transactions;    /* writing ones that it committed */
    int64_t wall_ns, cpu_ns; /* cpu: of the calling thread */
};
struct pen_store_observer {
    void (*called)(void *user, const struct pen_store_call *call);
    void *user;
};

/* Has an observer told of every such call, from its thread. It must stay until the handle is
 * closed; NULL: none. */
void pen_store_observe(struct pen_store *store, const struct pen_store_observer *observer);

struct pen_backup {
    int64_t jobs, bytes; /* in the copy */
};

/* Copies a store, which may be in use, to a file: all that was acknowledged before the call is in
 * it, and it is one moment of the store. It is made beside its name, checked, synced and named
 * last. Fails: PEN_CONFLICT (the file is there and is not to be replaced), PEN_USAGE (it is a
 * folder or the store), PEN_IO, PEN_STORAGE_FULL (the copy cannot be written), PEN_STORAGE (the
 * store is damaged or cannot be read), PEN_NOT_FOUND (there is no store), PEN_NO_MEMORY; nothing is
 * left then. Cost: reads every page, and the copy twice. */
bool pen_store_backup(const char *url, const char *file, bool replace, struct pen_backup *out,
                      struct pen_status *st);

struct pen_view_new {
    const char *name;
    int width, height;
};

struct pen_batch_new {
    int view;
    int first_tile, tile_count;
    int64_t pixels;           /* of a study: the runs it makes, which its progress counts */
    enum pen_batch_kind kind; /* render or study; a study is the only batch of its job */
};

struct pen_job_new {
    const char *id;     /* UUIDv7 */
    int64_t created_ms; /* wall clock; the time in the id and in the answer */
    const char *kind;
    const char *request; /* the job as accepted, without its scene: JSON */
    const void *scene;   /* the scene document as sent; stored once per content */
    size_t scene_bytes;
    const unsigned char *scene_sha256; /* 32 bytes */
    int priority, max_attempts;
    int64_t timeout_ms; /* 0: none */
    int view_count;
    const struct pen_view_new *views;
    int batch_count;
    const struct pen_batch_new *batches;
    const char *idempotency_key;      /* NULL: none */
    const unsigned char *body_sha256; /* 32 bytes; with a key */
    const char *answer;               /* stored with the key, given back on a repeat */
};

enum pen_submit_result {
    PEN_SUBMIT_CREATED,
    PEN_SUBMIT_REPEATED, /* same key, same body: *first_answer is the answer of then */
    PEN_SUBMIT_REUSED    /* same key, another body: nothing was stored */
};

/* Stores a job. Owns: *first_answer is appended to a caller's buffer. Fails: PEN_STORAGE_FULL,
 * PEN_STORAGE, PEN_UNAVAILABLE (busy too long). */
bool pen_store_submit(struct pen_store *store, const struct pen_job_new *job,
                      enum pen_submit_result *result, struct pen_buf *first_answer,
                      struct pen_status *st);

/* A job as stored. Owns: text fields belong to the record; release it. */
struct pen_job_record {
    int64_t number; /* order of submission */
    char id[PEN_ID_BYTES];
    enum pen_job_state state;
    int64_t revision; /* grows with every change that a reader can see */
    char *kind, *request;
    char *error; /* JSON of the problem, NULL unless failed */
    int priority, max_attempts;
    int attempts; /* the attempt it is on: 0 before the first claim, 1 from then on, and one more
                     for every death of a worker charged to it since its last commit */
    int64_t timeout_ms;
    int64_t created_ms, started_ms, finished_ms; /* wall clock; 0: not yet */
    int64_t updated_ms;                          /* when the revision began */
    int64_t done_pixels, total_pixels;
};

void pen_job_record_release(struct pen_job_record *job);

/* Fails: PEN_NOT_FOUND. */
bool pen_store_job(struct pen_store *store, const char *id, struct pen_job_record *job,
                   struct pen_status *st);

struct pen_job_filter {
    int state;        /* enum pen_job_state, or -1: any */
    const char *kind; /* NULL: any */
    int64_t below;    /* only numbers below this (the cursor); 0: from the newest */
    int limit;
};

/* Newest first. Owns: *jobs is malloc()ed, *count records; free with pen_job_records_free. */
bool pen_store_jobs(struct pen_store *store, const struct pen_job_filter *filter,
                    struct pen_job_record **jobs, int *count, struct pen_status *st);
void pen_job_records_free(struct pen_job_record *jobs, int count);

/* The scene document as sent. */
bool pen_store_scene(struct pen_store *store, const char *id, struct pen_buf *scene,
                     struct pen_status *st);

/* Cancels: the job and its open and leased batches, in one transaction. A job that has ended
 * stays as it is. Fails: PEN_NOT_FOUND. */
bool pen_store_cancel(struct pen_store *store, const char *id, struct pen_status *st);

/* Removes an ended job and all that belongs to it. Fails: PEN_NOT_FOUND, PEN_CONFLICT. */
bool pen_store_delete(struct pen_store *store, const char *id, struct pen_status *st);

/* A claim: a batch leased to a worker under an attempt number. */
struct pen_claim {
    int64_t batch, attempt; /* the fencing token */
    enum pen_batch_kind kind;
    char job_id[PEN_ID_BYTES];
    int view, first_tile, tile_count;
    int view_batches; /* render batches of this view: 1 means encode and commit together */
    int64_t pixels;
    unsigned char scene_sha256[32];
    int64_t submitted_ms;
    int64_t started_ms; /* the job's first claim */
    int64_t claimed_ms;
    int64_t timeout_ms; /* of the job, from started_ms; 0: none */
};

/* Claims the next batch by (priority, age), but see pen_store_worker_ended about quarantined
 * batches; the job becomes running. A study whose turn it is waits for the worker to hold nothing,
 * and until then, as long as it is held, there is nothing else for that worker. Returns true with
 * *found = false when there is nothing to do. */
bool pen_store_claim(struct pen_store *store, const char *worker, int64_t lease_ms,
                     struct pen_claim *claim, bool *found, struct pen_status *st);

/* What a batch came to. */
struct pen_result {
    const float *rgb; /* tiles in order, each its rows; pixels * 3 values; or NULL */
    int64_t pixels;
    const struct pen_pixels *encoded; /* the same, encoded beforehand; or NULL. Assemble: neither */
    const char *stats;                /* JSON, kept as long as the job */
    const char *layer, *format;       /* of the artefact; NULL: none */
    const void *artefact;
    size_t artefact_bytes;
};

/* Commits a batch. The commit that leaves no open render batch in a view of several batches adds
 * an assemble batch; the one that ends the last view makes the job succeeded. The batch that ends
 * a view (its only one, or the assemble batch) brings the view's picture, a study its report.
 * Fails: PEN_STALE; PEN_STORAGE_FULL, PEN_STORAGE, PEN_UNAVAILABLE (nothing was changed, or the
 * outcome is unknown: commit again); PEN_INTERNAL (a result that does not fit the batch). */
bool pen_store_commit(struct pen_store *store, const struct pen_claim *claim,
                      const struct pen_result *result, struct pen_status *st);

/* The next claim of a worker, taken in the transaction of a commit. */
struct pen_next {
    const char *worker;
    int64_t lease_ms;
    bool found; /* filled, with the claim, when the commit succeeded */
    struct pen_claim claim;
};

/* Commits, and claims the next batch in the same transaction. Fails: as pen_store_commit. */
bool pen_store_commit_and_claim(struct pen_store *store, const struct pen_claim *claim,
                                const struct pen_result *result, struct pen_next *next,
                                struct pen_status *st);

/* Says how many of its runs a study has made, for readers to see. Fails: PEN_STALE. */
bool pen_store_progress(struct pen_store *store, const struct pen_claim *claim, int64_t done,
                        struct pen_status *st);

/* Gives a batch back without a result and without charge. A batch no longer held is left as it
 * is. */
bool pen_store_release(struct pen_store *store, const struct pen_claim *claim,
                       struct pen_status *st);

/* Ends the claim's job as failed, with a problem document. Fails: PEN_STALE. */
bool pen_store_fail(struct pen_store *store, const struct pen_claim *claim, const char *error,
                    struct pen_status *st);

/* Asks whether the claim still holds, and extends its lease once a third of it has gone, so it
 * may be called often: most calls only read. *held = false: cancelled, taken or ended; stop
 * working on it. */
bool pen_store_heartbeat(struct pen_store *store, const struct pen_claim *claim, int64_t lease_ms,
                         bool *held, struct pen_status *st);

/* Opens batches whose lease has run out, and those of a worker that is known to be gone (NULL:
 * none), as quarantined batches, see pen_store_worker_ended. Nothing is charged: how the worker
 * went is not known. *opened is their number. */
bool pen_store_expire_leases(struct pen_store *store, const char *dead_worker, int *opened,
                             struct pen_status *st);

enum pen_worker_end {
    PEN_WORKER_LEFT,   /* told to, and leaves its work to others */
    PEN_WORKER_DIED,   /* by somebody else's doing, or nobody knows */
    PEN_WORKER_CRASHED /* by the doing of what it worked on */
};

/* Makes the error of a job that has used up its attempts, from the batch that its worker was at;
 * called inside the transaction: it may read from the store. Owns: a malloc()ed text, NULL when out
 * of memory. */
typedef char *pen_death_error_fn(void *user, const struct pen_claim *claim, int charges);

struct pen_worker_death {
    const char *worker;
    enum pen_worker_end end;
    pen_death_error_fn *error; /* of PEN_WORKER_CRASHED */
    void *user;
};

/* What to do about the batches of a worker that has ended. Unless it left, they become quarantined
 * batches: a suspect is handed only to a worker that holds nothing else, which then gets nothing
 * else until it is done with it; and a job whose batches keep coming back this way lets all others
 * go first for a while that doubles each time. A crash is charged to the job if nothing but its
 * batches was held; max_attempts charges in a row end it as failed. A commit takes all of this
 * back. *opened is the number of batches that are open again. */
bool pen_store_worker_ended(struct pen_store *store, const struct pen_worker_death *death,
                            int *opened, struct pen_status *st);

/* Calls `each` for every committed render batch of a view, in order of tiles, with its pixels
 * and place; stops when it returns false. Fails: PEN_NOT_FOUND (no such job). */
typedef bool pen_pixels_fn(void *user, int first_tile, int tile_count, const float *rgb,
                           int64_t pixels);
bool pen_store_pixels(struct pen_store *store, const char *id, int view, pen_pixels_fn *each,
                      void *user, struct pen_status *st);

/* Calls `each` for the statistics of every committed batch of a job, oldest batch first; stops
 * when it returns false. Fails: PEN_NOT_FOUND (no such job). */
struct pen_batch_stats {
    enum pen_batch_kind kind;
    int view;
    int64_t done_ms; /* wall clock of its commit */
    const char *stats;
};
typedef bool pen_stats_fn(void *user, const struct pen_batch_stats *batch);
bool pen_store_stats(struct pen_store *store, const char *id, pen_stats_fn *each, void *user,
                     struct pen_status *st);

/* Stored pictures; view -1 is for what is made from all views. Putting one that is there replaces
 * it. Fails: PEN_NOT_FOUND. */
bool pen_store_artefact(struct pen_store *store, const char *id, int view, const char *layer,
                        const char *format, struct pen_buf *out, struct pen_status *st);
bool pen_store_artefact_put(struct pen_store *store, const char *id, int view, const char *layer,
                            const char *format, const void *data, size_t bytes,
                            struct pen_status *st);

/* Housekeeping: idempotency keys and workers older than key_age_ms go, unused scene documents go,
 * room no longer needed is given back to the file system. */
bool pen_store_purge(struct pen_store *store, int64_t key_age_ms, struct pen_status *st);

/* An engine first writes changes to a log and later brings them to their place. A commit does that
 * itself now and then, and takes the longer for it; a handle can leave it to another one, whose
 * caller has the time: pen_store_checkpoint_due says after a commit that it is due, and the other
 * calls pen_store_checkpoint, which keeps nobody from reading or writing. Where that does not
 * happen, a commit does it in the end. Fails: PEN_STORAGE, PEN_STORAGE_FULL; nothing is lost. */
void pen_store_delegate_checkpoints(struct pen_store *store);
bool pen_store_checkpoint_due(const struct pen_store *store);
bool pen_store_checkpoint(struct pen_store *store, struct pen_status *st);

/* One batch as stored, for looking on. */
struct pen_batch_record {
    int64_t batch, attempt;
    enum pen_batch_kind kind;
    enum pen_batch_state state;
    int view, first_tile, tile_count;
    int64_t pixels;
    const char *worker; /* who holds it, NULL unless leased */
    bool quarantined;   /* a worker ended while it held this batch */
};

/* Calls `each` for every batch of a job, oldest first; stops when it returns false.
 * Fails: PEN_NOT_FOUND (no such job). */
typedef bool pen_batch_fn(void *user, const struct pen_batch_record *batch);
bool pen_store_batches(struct pen_store *store, const char *id, pen_batch_fn *each, void *user,
                       struct pen_status *st);

/* Where a committed render batch belongs. */
struct pen_commit_record {
    int64_t revision; /* the one its commit gave the job */
    int view, first_tile, tile_count;
};

/* Calls `each` for the render batches of a job that were committed after a revision of it, in the
 * order of their commits; stops when it returns false. Every commit gives its job a new revision,
 * so no two batches have the same. Fails: PEN_NOT_FOUND (no such job). */
typedef bool pen_commit_fn(void *user, const struct pen_commit_record *commit);
bool pen_store_commits(struct pen_store *store, const char *id, int64_t after, pen_commit_fn *each,
                       void *user, struct pen_status *st);

/* Notes that a worker is there. It says so from time to time; lease_ms is what it claims with, so
 * that a lease tells when it was last extended. */
bool pen_store_worker_seen(struct pen_store *store, const char *name, int threads, int64_t lease_ms,
                           struct pen_status *st);

/* Forgets a worker, if it is known. */
bool pen_store_worker_gone(struct pen_store *store, const char *name, struct pen_status *st);

/* A worker and a batch that it holds. */
struct pen_worker_record {
    const char *name;
    int threads;
    int64_t started_ms, seen_ms; /* wall clock; seen: said so, or extended this lease */
    const char *job_id;          /* NULL: it holds none, and what follows means nothing */
    const char *view;
    int64_t batch, attempt;
    enum pen_batch_kind kind;
    int64_t pixels;
};

/* Calls `each` for every worker, oldest first, and there once for every batch it holds; stops when
 * it returns false. Workers that have died unnoticed are among them. */
typedef bool pen_worker_fn(void *user, const struct pen_worker_record *worker);
bool pen_store_workers(struct pen_store *store, pen_worker_fn *each, void *user,
                       struct pen_status *st);

/* Looks for what must never be: rows without an owner, states that contradict each other, sums
 * that do not add up. Calls `each` with a sentence for every one found; *found is their number.
 * For tests and after a crash. Cost: reads everything but pixels and pictures. */
typedef void pen_audit_fn(void *user, const char *finding);
bool pen_store_audit(struct pen_store *store, pen_audit_fn *each, void *user, int *found,
                     struct pen_status *st);

/* Wake-up hints across processes: two counters that only grow. WORK grows when a batch may be
 * claimed, NEWS when any job changed. A hint may be lost; polling is the safety net. */
enum pen_signal { PEN_SIGNAL_WORK, PEN_SIGNAL_CHANGES };

/* Waits until the counter differs from *seen or the time is up; *seen becomes its value.
 * Threads: may be called while another thread uses the same handle. */
void pen_store_wait(struct pen_store *store, enum pen_signal signal, uint32_t *seen,
                    int timeout_ms);

/* Wakes all waiters of the store in all processes (used at shutdown). */
void pen_store_wake(struct pen_store *store, enum pen_signal signal);

#endif
