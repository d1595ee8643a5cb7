/* SPDX-License-Identifier: MIT */
/* The durable store: the only door between the api process and the workers. Jobs, their scene
 * documents, batches with leases, committed pixels, artefacts, idempotency keys and workers.
 * src/store/README.md has the rules: the states of jobs and batches, who may claim and commit, what
 * a failure means. The policy is written once (src/store) over a driver (src/store/sqlite; the
 * interface is src/store/internal/driver.h).
 *
 * What it promises
 *  - A function that returned true has its effect on disk (SQLite: WAL, synchronous=FULL).
 *  - A commit is one transaction: pixels, statistics, artefact and state together. It is refused
 *    with PEN_STALE unless the batch is still leased under the same attempt number.
 *  - A commit repeated with the same claim succeeds as a duplicate and changes nothing; so does a
 *    submit repeated with the same id.
 *  - After a failed call pen_store_failure tells whether nothing has happened or the outcome is
 *    unknown.
 *  - After a failed read, write or sync, or when the disk is full, what the call cannot promise it
 *    refuses (PEN_STORAGE, PEN_STORAGE_FULL), for all handles of all processes, and the store is
 *    used again as soon as it was reopened, checked and written to: handles stay valid, callers
 *    just call again (src/store/internal/health.h has the rules).
 *  - Time is the store's clock (pen_store_now), never a caller's.
 *  - A caller's function is never called inside a transaction: it may use the same handle.
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

enum { PEN_ID_BYTES = 37, /* UUID text and its end */ PEN_WORKER_ID_BYTES = 33 };

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

/* The store's clock. Units: ms since 1970. Fails: as reading. */
bool pen_store_now(struct pen_store *store, int64_t *now_ms, struct pen_status *st);

/* What a failed call has done. */
enum pen_failure {
    PEN_FAILURE_REFUSED, /* nothing; the same call would be refused again */
    PEN_FAILURE_RETRY,   /* nothing; the same call may succeed later */
    PEN_FAILURE_UNKNOWN  /* all or nothing. A submit or a commit may be repeated: if it had its
                            effect, that is recognised */
};

/* Of the call that has just failed on this handle with this status. */
enum pen_failure pen_store_failure(const struct pen_store *store, const struct pen_status *st);

/* One call that was made on a handle, for tests and benches. An observer receives the calls that
 * change a store and those that a worker makes. */
struct pen_store_call {
    const char *name;        /* "claim", "commit", … */
    int64_t transactions;    /* writing ones that it committed */
    int64_t wall_ns, cpu_ns; /* cpu: of the calling thread */
};
struct pen_store_observer {
    void (*called)(void *user, const struct pen_store_call *call);
    void *user;
};

/* Reports every such call to an observer, in the thread of the call. The observer must stay until
 * the handle is closed; NULL: none. */
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
    int64_t created_ms; /* by pen_store_now; the time in the id and in the answer */
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
    const unsigned char *body_sha256; /* 32 bytes; needed with a key */
    const char *answer;               /* stored with the key, given back on a repeat */
};

enum pen_submit_result {
    PEN_SUBMIT_CREATED,
    PEN_SUBMIT_KNOWN,    /* this job is stored: an earlier try of the same submit had its effect */
    PEN_SUBMIT_REPEATED, /* same key, same body: *first_answer is the answer given first */
    PEN_SUBMIT_REUSED    /* same key, another body: nothing was stored */
};

/* Stores a job. A caller who does not know the outcome repeats the call with the same job. Owns:
 * *first_answer is appended to a caller's buffer. Fails: PEN_STORAGE_FULL, PEN_STORAGE,
 * PEN_UNAVAILABLE (busy too long), PEN_CONFLICT (another job has this id). */
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

/* How many jobs there are in each state, and batches of jobs that have not ended. */
struct pen_counts {
    int64_t jobs[PEN_JOB_STATE_COUNT];
    int64_t open_batches, leased_batches;
};
bool pen_store_counts(struct pen_store *store, struct pen_counts *counts, struct pen_status *st);

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

/* Claims the next batch by (priority, age), with the exceptions that src/store/README.md lists for
 * quarantined batches and paused jobs; the job becomes running. A study that is next waits until
 * the worker holds nothing; until then, and while the worker holds the study, this returns nothing
 * else. Returns true with *found = false when there is nothing to do. */
bool pen_store_claim(struct pen_store *store, const char *worker, int64_t lease_ms,
                     struct pen_claim *claim, bool *found, struct pen_status *st);

/* The result of a batch. */
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
 * Fails: PEN_STALE; PEN_STORAGE_FULL, PEN_STORAGE, PEN_UNAVAILABLE (see pen_store_failure; the same
 * commit may be repeated in any case); PEN_INTERNAL (a result that does not fit the batch). */
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

/* Stores how many of its runs a study has made, for readers. Fails: PEN_STALE. */
bool pen_store_progress(struct pen_store *store, const struct pen_claim *claim, int64_t done,
                        struct pen_status *st);

/* Gives a batch back without a result and without charge. A batch no longer held is left as it
 * is. */
bool pen_store_release(struct pen_store *store, const struct pen_claim *claim,
                       struct pen_status *st);

/* Ends the claim's job as failed, with a problem document. Fails: PEN_STALE. */
bool pen_store_fail(struct pen_store *store, const struct pen_claim *claim, const char *error,
                    struct pen_status *st);

/* Tells whether the claim still holds, and extends its lease once a third of it has gone, so it
 * may be called often: most calls only read. *held = false: the job was cancelled or has ended, or
 * the batch was taken; stop working on it. */
bool pen_store_heartbeat(struct pen_store *store, const struct pen_claim *claim, int64_t lease_ms,
                         bool *held, struct pen_status *st);

/* Opens batches whose lease has run out, and those of a worker that is known to be gone (NULL:
 * none), as quarantined batches. Nothing is charged: how the worker ended is not known. *opened is
 * their number. */
bool pen_store_expire_leases(struct pen_store *store, const char *dead_worker, int *opened,
                             struct pen_status *st);

/* Opens the batches of all workers that do not live, as pen_store_expire_leases does, and removes
 * those workers from the list: a worker lives while a handle holds its lock
 * (pen_store_worker_lock). Leases of dead workers would run out anyway: this only saves the wait,
 * when everything was killed at once and no supervisor is left to report its worker. */
bool pen_store_release_dead(struct pen_store *store, int *opened, struct pen_status *st);

enum pen_worker_end {
    PEN_WORKER_LEFT,   /* told to, and leaves its work to others */
    PEN_WORKER_DIED,   /* killed by another process, or for an unknown reason */
    PEN_WORKER_CRASHED /* by what it worked on */
};

/* Makes the error of a job that has used up its attempts, from the batch that its worker worked
 * on; called outside any transaction: it may read from the store. Owns: a malloc()ed text, NULL
 * when out of memory. */
typedef char *pen_death_error_fn(void *user, const struct pen_claim *claim, int charges);

struct pen_worker_death {
    const char *worker;
    enum pen_worker_end end;
    pen_death_error_fn *error; /* of PEN_WORKER_CRASHED */
    void *user;
};

/* Opens the batches of a worker that has ended; *opened is their number. Unless the worker left,
 * they are quarantined: a quarantined batch is leased only to a worker that holds nothing else, and
 * that worker gets nothing else meanwhile. A job that lost workers repeatedly is paused for a time
 * that doubles with each loss, so that other jobs go first. A crash is charged to the job if the
 * worker held batches of that job alone; max_attempts charges in a row end the job as failed. A
 * commit ends the quarantine of its batch, and the pause and the charges of its job. */
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

/* Removes idempotency keys and workers older than key_age_ms and unused scene documents, and gives
 * space no longer needed back to the file system. */
bool pen_store_purge(struct pen_store *store, int64_t key_age_ms, struct pen_status *st);

/* A database first writes changes to a log and later copies them to their place: a checkpoint. A
 * commit does that itself now and then, and takes longer for it. A handle can leave it to another
 * one: pen_store_checkpoint_due returns true after a commit that calls for a checkpoint, and the
 * other handle calls pen_store_checkpoint, which blocks neither readers nor writers. If nobody
 * does, a later commit makes the checkpoint. Fails: PEN_STORAGE, PEN_STORAGE_FULL; nothing is lost.
 */
void pen_store_delegate_checkpoints(struct pen_store *store);
bool pen_store_checkpoint_due(const struct pen_store *store);
bool pen_store_checkpoint(struct pen_store *store, struct pen_status *st);

/* One batch as stored. */
struct pen_batch_record {
    int64_t batch, attempt;
    enum pen_batch_kind kind;
    enum pen_batch_state state;
    int view, first_tile, tile_count;
    int64_t pixels;
    const char *worker; /* the id of its holder, NULL unless leased */
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

/* A worker as it presents itself. */
struct pen_worker_new {
    const char *id;   /* random, see pen_worker_id_make */
    const char *host; /* for readers; with pid it says where the worker runs */
    int64_t pid;
    int threads;
    int64_t lease_ms; /* that it claims with, so that a lease tells when it was last extended */
};

/* Makes the id of a worker: 128 random bits in hexadecimal digits. Fails: PEN_IO (the system gives
 * no random bytes). */
bool pen_worker_id_make(char id[PEN_WORKER_ID_BYTES], struct pen_status *st);

/* Takes a lock that marks the worker as living, for as long as this handle is open; the end of the
 * process ends it too. Fails: PEN_CONFLICT (another handle has it), PEN_STORAGE. */
bool pen_store_worker_lock(struct pen_store *store, const char *id, struct pen_status *st);

/* Stores that a worker is there. To be repeated from time to time. */
bool pen_store_worker_seen(struct pen_store *store, const struct pen_worker_new *worker,
                           struct pen_status *st);

/* Removes a worker from the list, if it is there. */
bool pen_store_worker_gone(struct pen_store *store, const char *id, struct pen_status *st);

/* A worker and a batch that it holds. */
struct pen_worker_record {
    const char *id, *host;
    int64_t pid;
    int threads;
    int64_t started_ms, seen_ms; /* by the store's clock; seen: reported itself, or extended this
                                    lease */
    const char *job_id;          /* NULL: it holds none, and what follows means nothing */
    const char *view;
    int64_t batch, attempt;
    enum pen_batch_kind kind;
    int64_t pixels;
};

/* Calls `each` for every worker, oldest first, once for every batch that it holds, and once if it
 * holds none; stops when it returns false. Workers that have died unnoticed are among them. */
typedef bool pen_worker_fn(void *user, const struct pen_worker_record *worker);
bool pen_store_workers(struct pen_store *store, pen_worker_fn *each, void *user,
                       struct pen_status *st);

/* Looks for contradictions: rows without an owner, states that contradict each other, sums that do
 * not add up. Calls `each` with a sentence for every one found; *found is their number. For tests
 * and after a crash. Cost: reads everything but pixels and pictures. */
typedef void pen_audit_fn(void *user, const char *finding);
bool pen_store_audit(struct pen_store *store, pen_audit_fn *each, void *user, int *found,
                     struct pen_status *st);

/* Signals between all handles of a store: two counters that only grow. PEN_SIGNAL_WORK grows when a
 * batch may be claimed, PEN_SIGNAL_CHANGES (the change notification) when any job changed. A signal
 * may be lost: callers also look at the store from time to time. */
enum pen_signal { PEN_SIGNAL_WORK, PEN_SIGNAL_CHANGES };

/* Waits until the counter differs from *seen or the time is up; *seen becomes its value.
 * Threads: may be called while another thread uses the same handle. */
void pen_store_wait(struct pen_store *store, enum pen_signal signal, uint32_t *seen,
                    int timeout_ms);

/* Wakes all who wait for a signal, in all processes. */
void pen_store_wake(struct pen_store *store, enum pen_signal signal);

#endif
