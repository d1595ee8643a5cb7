/* SPDX-License-Identifier: MIT */
/* The durable store, the only connection between the api process and the workers. It keeps jobs,
 * their scene documents, batches with leases, committed pixels, artefacts (pictures and reports),
 * idempotency keys and workers. src/store/README.md has the rules: the states of jobs and batches,
 * who may claim and commit, what a failure means.
 *
 * What the store promises
 *  - A function that returned true has its effect on disk (SQLite: WAL, synchronous=FULL).
 *  - A commit is one transaction: pixels, statistics, artefact and state together. It fails with
 *    PEN_STALE unless the batch is still leased under the same attempt.
 *  - A commit repeated with the same claim succeeds and changes nothing. So does a submit repeated
 *    with the same id.
 *  - After a failed call, pen_store_failure tells whether nothing has happened or the outcome is
 *    unknown.
 *  - After a failed read, write or sync, or on a full disk, all handles of all processes refuse
 *    calls whose effect they cannot promise (PEN_STORAGE, PEN_STORAGE_FULL). The store is used
 *    again once it was reopened, checked and written to. Handles stay valid; callers call again
 *    (src/store/internal/health.h has the rules).
 *  - Time is the store's clock (pen_store_now), never a caller's.
 *  - A caller's function is never called inside a transaction. It may use the same handle.
 *  - Text is opaque to the store (JSON written by room jobs).
 *
 * Threads: a handle is used by one thread at a time; open one per thread. Handles of different
 * processes may be open on the same store. */
#ifndef PEN_STORE_STORE_H
#define PEN_STORE_STORE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/buf.h"
#include "base/clock.h"
#include "base/status.h"
#include "store/pixels.h"

enum {
    PEN_ID_BYTES = 37, /* UUID text and its end */
    PEN_WORKER_ID_BYTES = 33,
    PEN_STORE_IDENTITY_BYTES = 33
};

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
    PEN_BATCH_ASSEMBLE, /* makes the picture of a view from its committed batches */
    PEN_BATCH_STUDY     /* the only batch of a job with a report; its worker holds nothing else */
};

/* The name of a state in the API, "queued" and so on; pen_job_state_of_name returns false if no
 * state has this name. */
const char *pen_job_state_name(enum pen_job_state state);
bool pen_job_state_of_name(const char *name, enum pen_job_state *state);

static inline bool pen_job_state_ended(enum pen_job_state state)
{
    return state >= PEN_JOB_SUCCEEDED;
}

struct pen_store;

/* Opens a store and migrates an older schema. `url` is one of
 *   PATH                 the path of its file. If there is no store, and neither a log nor a -wake
 *                        file of one, the file and its folders are made.
 *   store::PATH          the store that is there. Nothing is made.
 *   store:IDENTITY:PATH  the store that has this identity. Nothing is made, and no other store is
 *                        opened: a process that works for another one cannot end up elsewhere.
 * Owns: pen_store_close. Fails: PEN_NOT_FOUND (store::PATH, and there is no store), PEN_STORAGE
 * (not a Penumbra store, damaged, newer schema, gone, another store, a log that is missing or
 * another store's, no permission: the message says what to do, and the file is as it was),
 * PEN_UNSUPPORTED (a postgres:// URL, for which there is no driver), PEN_USAGE (no path, or too
 * long), PEN_STORAGE_FULL, PEN_UNAVAILABLE (also: another process holds the lock for opening),
 * PEN_NO_MEMORY. */
struct pen_store *pen_store_open(const char *url, struct pen_status *st);
void pen_store_close(struct pen_store *store);

/* The store's identity: 32 hexadecimal digits, random, made with the store and never changed. A
 * backup has one of its own. */
const char *pen_store_identity(const struct pen_store *store);

/* The path of the store's file without symbolic links. Another process that opens this path, and
 * not the one that was given, cannot be led elsewhere by a link that changes. Owns: the store. */
const char *pen_store_path(const struct pen_store *store);

/* Brings everything into the store's own file, so that it is complete without the files beside it.
 * To be called before the last handle is closed; nothing is done while there are others. */
bool pen_store_settle(struct pen_store *store, struct pen_status *st);

/* Looks for damage in the whole store and its log. Fails: PEN_STORAGE with the first damage found.
 * Cost: reads every page. */
bool pen_store_check(struct pen_store *store, struct pen_status *st);

/* As the daemon does at its start: a store of more than 64 MiB is checked in part, its log, schema,
 * length and the tables of jobs and batches, for a third of a second at most. */
bool pen_store_check_start(struct pen_store *store, struct pen_status *st);

/* Whether the store accepts new work: writes a little and syncs it. Fails: PEN_STORAGE_FULL,
 * PEN_STORAGE, PEN_UNAVAILABLE, with the reason. */
bool pen_store_probe(struct pen_store *store, struct pen_status *st);

/* Whether a new job would be accepted now: as pen_store_probe, and there is enough space on the
 * disk, and below keep_bytes. Fails: as pen_store_submit. */
bool pen_store_intake(struct pen_store *store, struct pen_status *st);

/* Sets a part of the disk aside, which is given up when the disk is full, so that jobs can still be
 * cancelled and deleted. To be called once, by the daemon; it is set aside again by itself. Fails:
 * PEN_STORAGE_FULL, PEN_STORAGE. */
bool pen_store_reserve(struct pen_store *store, struct pen_status *st);

/* Makes a handle use another clock; for tests. */
void pen_store_set_clock(struct pen_store *store, int64_t (*now_ms)(void *user), void *user);

/* The store's clock. Units: ms since 1970. Fails: as any read. */
bool pen_store_now(struct pen_store *store, int64_t *now_ms, struct pen_status *st);

/* What a failed call has done. */
enum pen_failure {
    PEN_FAILURE_REFUSED, /* nothing; the same call would be refused again */
    PEN_FAILURE_RETRY,   /* nothing; the same call may succeed later */
    PEN_FAILURE_UNKNOWN  /* everything or nothing. A submit or a commit may be repeated: the store
                            recognises an effect that it had */
};

/* Classifies the failure of the last call on this handle; `st` is the status it has filled. */
enum pen_failure pen_store_failure(const struct pen_store *store, const struct pen_status *st);

/* One call on a handle, for tests and benchmarks. Observers are told of the calls that change the
 * store and of those that workers make. */
struct pen_store_call {
    const char *name;        /* "claim", "commit", … */
    int64_t transactions;    /* write transactions that it committed */
    int64_t wall_ns, cpu_ns; /* cpu_ns: of the calling thread */
};
struct pen_store_observer {
    void (*called)(void *user, const struct pen_store_call *call);
    void *user;
};

/* Reports these calls to an observer, in the thread of the call; NULL: to none. Owns: the observer
 * stays the caller's, and must live until the handle is closed. */
void pen_store_observe(struct pen_store *store, const struct pen_store_observer *observer);

struct pen_backup {
    const atomic_bool *stop; /* given: ends the call when it becomes true; NULL: never */
    int64_t jobs, bytes;     /* of the copy */
};

/* Copies a store, which may be in use, to a file. The copy is the store as of one moment, with
 * everything that was acknowledged before the call. It is made under another name,
 * FILE.part-XXXXXX, checked, synced and then renamed (a symbolic link FILE is replaced itself).
 * Copies under such names that a killed process has left are removed. Fails: PEN_TIMEOUT (stopped),
 * PEN_CONFLICT (the file exists, and `replace` is false), PEN_USAGE (the name is a folder, the
 * store itself, or too long), PEN_IO, PEN_STORAGE_FULL (the copy cannot be written), PEN_STORAGE
 * (the store is damaged or cannot be read), PEN_NOT_FOUND (there is no store), PEN_UNAVAILABLE,
 * PEN_NO_MEMORY. A failed call leaves no file. Cost: reads every page, and the copy twice. */
bool pen_store_backup(const char *url, const char *file, bool replace, struct pen_backup *out,
                      struct pen_status *st);

/* Removes the unfinished copies that killed processes have left of this backup. */
void pen_store_backup_remove_left(const char *file);

struct pen_view_new {
    const char *name;
    int width, height;
};

struct pen_batch_new {
    int view;
    int first_tile, tile_count;
    int64_t pixels;           /* of a study: the number of its runs, which its progress counts */
    enum pen_batch_kind kind; /* render or study; a study is the only batch of its job */
};

struct pen_job_new {
    const char *id;            /* UUIDv7 */
    int64_t created_ms;        /* by pen_store_now; also the time in the id and in the answer */
    struct pen_moment created; /* the same moment */
    const char *kind;
    const char *request; /* JSON: the job as accepted, without its scene */
    const void *scene;   /* the scene document as sent; stored once per content */
    size_t scene_bytes;
    const unsigned char *scene_sha256; /* 32 bytes */
    int priority, max_attempts;
    int64_t timeout_ms; /* 0: none */
    int view_count;
    const struct pen_view_new *views;
    int batch_count;
    const struct pen_batch_new *batches;
    const char *client;                  /* the job's owner, who also has its share; NULL: "" */
    int64_t queue_max, client_queue_max; /* the most unfinished jobs, this one included: in all,
                                            and of this client; 0: any number */
    const char *idempotency_key;         /* of the client; NULL: none */
    const unsigned char *body_sha256;    /* 32 bytes; required with a key */
    const char *answer;                  /* stored with the key, returned to a repeated submit */
};

enum pen_submit_result {
    PEN_SUBMIT_CREATED,
    PEN_SUBMIT_KNOWN,    /* the job is stored already: an earlier try of this submit succeeded */
    PEN_SUBMIT_REPEATED, /* same key, same body: *first_answer is the answer given first */
    PEN_SUBMIT_REUSED    /* same key, another body: nothing was stored */
};

/* Stores a job. A caller that does not know the outcome repeats the call with the same job. The
 * first answer is appended to *first_answer; a submit that was answered before needs no space.
 * Fails: PEN_STORAGE_FULL (the disk is nearly full, or the store holds keep_bytes, the results of
 * unfinished jobs counted as expected), PEN_TOO_LARGE (the job's results alone are expected to take
 * more than keep_bytes), PEN_STORAGE, PEN_UNAVAILABLE (busy too long), PEN_QUOTA (too many
 * unfinished jobs), PEN_CONFLICT (another job has this id), PEN_INTERNAL (a view without a batch),
 * PEN_NO_MEMORY. */
bool pen_store_submit(struct pen_store *store, const struct pen_job_new *job,
                      enum pen_submit_result *result, struct pen_buf *first_answer,
                      struct pen_status *st);

/* All of a job's work, of which claims tell shares. */
enum { PEN_WORK_ALL = 1000000000 };

/* A job as stored. Owns: the texts belong to the record; free them with pen_job_record_release. */
struct pen_job_record {
    int64_t number; /* order of submission */
    char id[PEN_ID_BYTES];
    enum pen_job_state state;
    int64_t revision; /* grows with every change that a reader can see; 1 at first */
    char *kind, *request;
    char *error; /* JSON of the problem, NULL unless failed */
    int priority, max_attempts;
    int attempts; /* 0 before the first claim, then 1 and one more for each crash of a worker
                     charged to the job since its last commit; at most max_attempts */
    int64_t timeout_ms;
    int64_t created_ms, started_ms, finished_ms; /* by the store's clock; 0: not yet */
    int64_t updated_ms;                          /* when the revision last changed */
    int64_t done_pixels, total_pixels;
    int64_t work;        /* the share of its expected work that is done, of PEN_WORK_ALL */
    int64_t estimate_ms; /* how long workers are expected to work on it in all; 0: not estimated */
    int64_t told_us;     /* how long they had worked on it when `work` was last told */
    /* The time since the submit: up to the last change; up to when `work` was last told, 0: never;
     * up to the first claim. Measured by the clock of the boot. From one boot to the next it is the
     * difference of the store's clock, or none if that was set back. */
    int64_t elapsed_us, told_elapsed_us, queue_us;
};

void pen_job_record_release(struct pen_job_record *job);

/* The length of its request and error together. */
size_t pen_job_record_text_bytes(const struct pen_job_record *job);

/* Fails: PEN_NOT_FOUND; PEN_GONE (the job was removed), as every other call about a job. */
bool pen_store_job(struct pen_store *store, const char *id, struct pen_job_record *job,
                   struct pen_status *st);

struct pen_queue {
    struct pen_buf ids; /* of the queued jobs, PEN_ID_BYTES each, in the order in which they begin,
                         * as far as the shares of now tell (README.md, "Shares") */
    int64_t running;    /* jobs that have begun, but for those of hand_us */
    int64_t hand_us;    /* what the batches in hand still take, as far as it is known, each at most
                         * a minute: by then its turn is over */
    int64_t workers;    /* that are there now */
    int64_t job_us;     /* how long workers took for a job: the mean of the last 50 jobs that took
                         * any time and have ended. 0: there were none */
};

/* Reads the queue; the caller releases its ids, also after a failure. Fails: PEN_NO_MEMORY. Cost:
 * grows with the number of queued jobs, some us for each. */
bool pen_store_queue(struct pen_store *store, struct pen_queue *queue, struct pen_status *st);

struct pen_job_filter {
    int state;        /* enum pen_job_state, or -1: any */
    const char *kind; /* NULL: any */
    /* Of the request, which is a JSON object here: its member `name`, and a member of its `labels`.
     * NULL: any. */
    const char *name, *label_key, *label_value;
    int64_t below; /* the cursor: only jobs with smaller numbers; 0: all */
    int limit;
    /* The list ends with the job whose texts, request and error, bring those of all to more than
     * this, but not with the first one; 0: no bound. */
    size_t text_bytes;
};

/* Lists jobs, newest first, at most filter->limit. Owns: *jobs are *count records; free them with
 * pen_job_records_free. */
bool pen_store_jobs(struct pen_store *store, const struct pen_job_filter *filter,
                    struct pen_job_record **jobs, int *count, struct pen_status *st);
void pen_job_records_free(struct pen_job_record *jobs, int count);

/* The number of jobs in each state, and of batches that are open or leased. */
struct pen_counts {
    int64_t jobs[PEN_JOB_STATE_COUNT];
    int64_t open_batches, leased_batches;
    int64_t oldest_queued_ms; /* when the oldest queued job was submitted; 0: there is none */
    int64_t bytes;            /* of the store's files */
};
bool pen_store_counts(struct pen_store *store, struct pen_counts *counts, struct pen_status *st);

/* Appends the scene document, as it was sent. Fails: PEN_NOT_FOUND, PEN_STORAGE (damaged). */
bool pen_store_scene(struct pen_store *store, const char *id, struct pen_buf *scene,
                     struct pen_status *st);

/* Returns true if a client may change a job, which may have been removed; the two calls below check
 * it too. NULL as `client` is the operator. Fails: PEN_FORBIDDEN (it belongs to another client). */
bool pen_store_check_client(struct pen_store *store, const char *id, const char *client,
                            struct pen_status *st);

/* Cancels a job, and ends its open and leased batches, in one transaction. A job that has ended
 * stays as it is. Fails: PEN_NOT_FOUND, PEN_FORBIDDEN. */
bool pen_store_cancel(struct pen_store *store, const char *id, const char *client,
                      struct pen_status *st);

/* Removes an ended job. Only `stats`, a text, stays readable, by pen_store_removed_stats (NULL:
 * nothing; on a job that was removed before, its text is dropped). Space is freed later, by
 * pen_store_purge_slice. Fails: PEN_NOT_FOUND, PEN_GONE, PEN_FORBIDDEN, PEN_CONFLICT (it has not
 * ended). */
bool pen_store_delete(struct pen_store *store, const char *id, const char *client,
                      const char *stats, struct pen_status *st);

/* Appends what a removed job left. Fails: PEN_NOT_FOUND (no such job, or not removed), PEN_GONE (it
 * left nothing). */
bool pen_store_removed_stats(struct pen_store *store, const char *id, struct pen_buf *stats,
                             struct pen_status *st);

/* A claim: a batch leased to a worker under an attempt number. */
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
    int64_t job_work;     /* the share of its expected work that is done, without this batch */
    int64_t spent_us; /* set by the holder, 0 at first: how long it has worked on this claim, by a
                         monotonic clock. Heartbeat, commit, release and fail add to the job what
                         they have not added yet */
    /* Set by the holder for a heartbeat, a commit and the progress of a study: how long workers are
     * expected to work on the job in all. 0: that is not known, and the heartbeat tells nothing. */
    int64_t estimate_ms;
    /* Set by the holder for a heartbeat: the share of the job's expected work that this claim has
     * done, of PEN_WORK_ALL. */
    int64_t work;
};

/* Claims the next batch by priority, fair shares and age, with the exceptions for quarantined
 * batches and paused jobs; src/store/README.md has the rules. The job becomes running. If a study
 * is next, the worker gets nothing until it holds nothing; while it holds the study, it gets
 * nothing else. *found = false: there is nothing to do. */
bool pen_store_claim(struct pen_store *store, const char *worker, int64_t lease_ms,
                     struct pen_claim *claim, bool *found, struct pen_status *st);

/* The result of a batch. */
struct pen_result {
    const float *rgb; /* tiles in order, each row by row; pixels * 3 values; or NULL */
    int64_t pixels;
    int part_tiles; /* of a render batch: it has its first tiles only, so many; 0: all */
    const struct pen_pixels *encoded; /* the same, encoded; or NULL. Only render batches have one */
    int64_t work; /* the share of the job's expected work, of PEN_WORK_ALL; 0: that of its pixels */
    const char *stats;          /* JSON, kept as long as the job */
    int64_t handed_ns;          /* when it was given to the store, by pen_clock_ns; 0: now */
    const char *layer, *format; /* of the artefact; NULL: none */
    const void *artefact;
    size_t artefact_bytes;
};

/* Commits a batch.
 *  - A result of the first tiles alone, which has no picture, ends the batch as if it had only
 *    these; the others become an open batch of the same view.
 *  - The last commit of a view of several render batches adds the view's assemble batch.
 *  - The commit that ends a view (of its only batch, or of the assemble batch) must bring the
 *    view's picture, that of a study its report.
 *  - The commit that ends the last view makes the job succeeded.
 * Fails: PEN_STALE; PEN_STORAGE_FULL, PEN_STORAGE, PEN_UNAVAILABLE (see pen_store_failure; the same
 * commit may be repeated in any case); PEN_INTERNAL (the result does not fit the batch). */
bool pen_store_commit(struct pen_store *store, const struct pen_claim *claim,
                      const struct pen_result *result, struct pen_status *st);

/* The worker's next claim, made in the transaction of a commit. */
struct pen_next {
    const char *worker;
    int64_t lease_ms;
    bool found; /* out: there is a claim; false if the commit failed */
    struct pen_claim claim;
};

/* Commits, and claims the next batch in the same transaction. Fails: as pen_store_commit. */
bool pen_store_commit_and_claim(struct pen_store *store, const struct pen_claim *claim,
                                const struct pen_result *result, struct pen_next *next,
                                struct pen_status *st);

/* Stores how many of its runs a study has finished, for readers, with the claim's time and
 * estimate. Fails: PEN_STALE. */
bool pen_store_progress(struct pen_store *store, const struct pen_claim *claim, int64_t done,
                        struct pen_status *st);

/* A part of what a batch keeps that is written when it has changed, and not with every state. */
struct pen_kept_part {
    const char *name; /* anything but PEN_KEPT_STATE */
    const void *data;
    size_t bytes;
};

/* What a study or a view with a target error keeps, so that the next worker to claim it goes on
 * from there: a state, and parts, each of which stays until one of its name replaces it. */
struct pen_kept {
    /* Runs, as for pen_store_progress; of a view that is one batch, pixels: readers see them as
     * done. Progress does not go back. Below 0: it stays as it is. */
    int64_t done;
    const void *data; /* NULL: the state stays as it is */
    size_t bytes;
    const struct pen_kept_part *parts;
    int part_count;
};
#define PEN_KEPT_STATE "state"

/* Stores what the claim's batch keeps until its view ends or its job, in place of what the view's
 * batches kept before, with its progress, in one transaction. *outranked: as pen_store_outranked
 * tells. Fails: PEN_STALE; PEN_STORAGE_FULL, also if the store may not hold so much
 * (pen_retention.keep_bytes). Nothing is stored then. */
bool pen_store_keep(struct pen_store *store, const struct pen_claim *claim,
                    const struct pen_kept *kept, bool *outranked, struct pen_status *st);

/* Whether the holder should release the claim: a batch of higher priority is open; or the claim is
 * held for five seconds already, and one is open whose address has come to a higher priority by
 * waiting; or it is held for a minute, and one of the same priority and another job is open. */
bool pen_store_outranked(struct pen_store *store, const struct pen_claim *claim, bool *outranked,
                         struct pen_status *st);

/* Keeps a part without a state, which belongs to the result of the claim's batch, for a later batch
 * of the view. Fails: as pen_store_keep. */
bool pen_store_keep_part(struct pen_store *store, const struct pen_claim *claim,
                         const struct pen_kept_part *part, struct pen_status *st);

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

/* Gives a batch back without a result or a charge, and adds claim->spent_us to the job. Does
 * nothing if the batch is no longer held. */
bool pen_store_release(struct pen_store *store, const struct pen_claim *claim,
                       struct pen_status *st);

/* Whether the last call, a commit or pen_store_artefact_put, failed because the disk has too little
 * space for so large a result. Smaller ones may still be stored. */
bool pen_store_lacks_space(const struct pen_store *store);

/* Gives a batch back whose result the disk has no space for, so that others, whose results fit, get
 * their turn: as pen_store_release, and its job is paused as after lost workers, without a charge.
 * After the 16th time since the job's last commit, and ten minutes after its begin at the earliest,
 * the job fails with `error`, a problem document. Unless `always`, this is only done if a batch of
 * another job is open. *set_back: it was done, or the claim is no longer held. */
bool pen_store_set_back(struct pen_store *store, const struct pen_claim *claim, const char *error,
                        bool always, bool *set_back, struct pen_status *st);

/* Ends the claim's job as failed; `error` is a problem document, JSON. Fails: PEN_STALE. */
bool pen_store_fail(struct pen_store *store, const struct pen_claim *claim, const char *error,
                    struct pen_status *st);

/* Tells whether the claim still holds, and extends its lease once a third of it has gone. Most
 * calls only read, so it may be called often. *held = false: the job has ended, or the batch was
 * opened again; stop working on it. Else claim->job_spent_us is brought up to date: other workers
 * may work on the job, and so is claim->job_work. A call that extends the lease adds
 * claim->spent_us to the job: if the worker dies, the job has spent what it told last. So does one
 * that tells of work (claim->estimate_ms), which readers see at once. */
bool pen_store_heartbeat(struct pen_store *store, struct pen_claim *claim, int64_t lease_ms,
                         bool *held, struct pen_status *st);

/* Opens the batches whose lease has expired, and those that `dead_worker` holds (NULL: none), and
 * quarantines them. Nothing is charged, because it is not known how the worker ended. *opened is
 * the number of batches. */
bool pen_store_expire_leases(struct pen_store *store, const char *dead_worker, int *opened,
                             struct pen_status *st);

/* Opens and quarantines the batches of every dead worker, and removes these workers from the list.
 * A worker lives while a handle holds its lock (pen_store_worker_lock); if that cannot be told, it
 * counts as living. Leases of dead workers would expire anyway; this saves the wait when everything
 * was killed at once and no supervisor is left to report the worker's end. *opened is the number of
 * batches. */
bool pen_store_release_dead(struct pen_store *store, int *opened, struct pen_status *st);

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
 *  - Unless the worker left, they are quarantined: a quarantined batch is leased only to a worker
 *    that holds nothing else, and that worker gets nothing else meanwhile.
 *  - A job that loses workers repeatedly is paused, for a time that doubles with each loss.
 *  - A crash is charged to the job if the worker held batches of that job only. max_attempts
 *    charges in a row end the job as failed.
 *  - A commit ends the quarantine of its batch, and the pause and the charges of its job.
 * Fails: PEN_UNAVAILABLE (the worker's batches keep changing), PEN_NO_MEMORY, and as any write. */
bool pen_store_worker_ended(struct pen_store *store, const struct pen_worker_death *death,
                            int *opened, struct pen_status *st);

/* Calls `each` for every committed render batch of a view, in the order of tiles; stops when it
 * returns false. rgb is valid during the call. Fails: PEN_NOT_FOUND (no such job), PEN_STORAGE
 * (damaged pixels). */
typedef bool pen_pixels_fn(void *user, int first_tile, int tile_count, const float *rgb,
                           int64_t pixels);
bool pen_store_pixels(struct pen_store *store, const char *id, int view, pen_pixels_fn *each,
                      void *user, struct pen_status *st);

/* Calls `each` for the statistics of every committed batch of a job, oldest batch first; stops
 * when it returns false. Fails: PEN_NOT_FOUND (no such job). */
struct pen_batch_stats {
    enum pen_batch_kind kind;
    int view;
    int64_t commit_us; /* how long the worker waited for its commit */
    const char *stats;
};
typedef bool pen_stats_fn(void *user, const struct pen_batch_stats *batch);
bool pen_store_stats(struct pen_store *store, const char *id, pen_stats_fn *each, void *user,
                     struct pen_status *st);

/* Appends an artefact of a job to *out; view -1: made from all views. An empty *out is then as
 * large as the artefact. Fails: PEN_NOT_FOUND, PEN_STORAGE (damaged). */
bool pen_store_artefact(struct pen_store *store, const char *id, int view, const char *layer,
                        const char *format, struct pen_buf *out, struct pen_status *st);

/* Stores an artefact of the view of the claim's batch, before the commit; one that exists is
 * replaced. Fails: PEN_STALE (nothing is stored). */
bool pen_store_artefact_put(struct pen_store *store, const struct pen_claim *claim,
                            const char *layer, const char *format, const void *data, size_t bytes,
                            struct pen_status *st);

/* What the store keeps. Ended jobs beyond these limits are removed, those that ended first before
 * others; a live job never. The limits are stored. 0: no limit. */
struct pen_retention {
    int64_t keep_ms;    /* since the job's end */
    int64_t keep_bytes; /* used in its file, without log and reserve; new jobs are accepted as far
                           as their results are expected to fit */
    int64_t keep_jobs;  /* ended ones */
};
bool pen_store_set_retention(struct pen_store *store, const struct pen_retention *retention,
                             struct pen_status *st);
bool pen_store_retention(struct pen_store *store, struct pen_retention *out, struct pen_status *st);

/* Finds the next job that retention removes; the caller makes its statistics and deletes it. Drops
 * statistics of removed jobs, the oldest first, that are beyond their part of keep_bytes, and
 * others if there is no ended job left and the store is still too large. */
bool pen_store_expired(struct pen_store *store, char id[PEN_ID_BYTES], bool *found,
                       struct pen_status *st);

/* Stores an artefact of a job that can be made again, from what is committed; one that exists is
 * replaced. It is dropped when others are used later, or space runs short; it is not stored at all
 * if it is too large or space is short, also if that is only until what was dropped for it is gone.
 * Fails: PEN_NOT_FOUND. */
bool pen_store_cache_put(struct pen_store *store, const char *id, int view, const char *layer,
                         const char *format, const void *data, size_t bytes, struct pen_status *st);

/* Drops one such artefact if they are too large together, or the disk runs short; *more: it did. */
bool pen_store_evict(struct pen_store *store, bool *more, struct pen_status *st);

/* Removes idempotency keys, workers and removed jobs without statistics that are older than
 * key_age_ms, statistics of removed jobs older than stats_age_ms, and scene documents that no job
 * uses. In several transactions, each of a bounded number of rows. */
bool pen_store_purge(struct pen_store *store, int64_t key_age_ms, int64_t stats_age_ms,
                     struct pen_status *st);

/* Does a little of what deletes have left to do, in one short transaction: removes some megabytes
 * of a removed job, or of a value that was replaced or not finished, or returns a megabyte of free
 * space to the file system. *more is false if there was nothing to do, or nothing to remove where
 * it fails: then the reserve is not used for it. A caller that repeats it should pause between, so
 * that other writers get their turn. */
bool pen_store_purge_slice(struct pen_store *store, bool *more, struct pen_status *st);

/* The background check of stored scene documents, pixels, pictures and reports, which the check at
 * a start leaves out. Each call checks the next one by its checksum; what is damaged is logged with
 * its job, and counted (PEN_TALLY_DAMAGED); so is what cannot be read. It begins at {0}; *more is
 * false at the end of a pass, and *scrub is {0} again. Fails: as a reader's call, if the store
 * itself cannot be read; PEN_NO_MEMORY, for one, after which the next call goes on. */
struct pen_scrub {
    int kind;      /* of the last one that was checked */
    int64_t after; /* its number */
    int64_t damaged;
};
bool pen_store_scrub(struct pen_store *store, struct pen_scrub *scrub, bool *more,
                     struct pen_status *st);

/* Checkpoints. A database writes changes to a log first and later copies them to their place. That
 * copying, a checkpoint, makes some commits slow. A handle can leave it to another handle:
 *  1. It calls pen_store_delegate_checkpoints once.
 *  2. After a commit pen_store_checkpoint_due tells whether a checkpoint is due.
 *  3. The other handle calls pen_store_checkpoint, which blocks neither readers nor writers.
 * If none does, a later commit makes the checkpoint after all.
 * Fails: PEN_STORAGE, PEN_STORAGE_FULL; nothing is lost. */
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
    const char *worker; /* the id of its holder; NULL unless leased */
    bool quarantined;   /* a worker was lost while it held this batch */
};

/* Calls `each` for every batch of a job, oldest first; stops when it returns false.
 * Fails: PEN_NOT_FOUND (no such job). */
typedef bool pen_batch_fn(void *user, const struct pen_batch_record *batch);
bool pen_store_batches(struct pen_store *store, const char *id, pen_batch_fn *each, void *user,
                       struct pen_status *st);

/* The place of a committed render batch in its view. */
struct pen_commit_record {
    int64_t revision; /* that the commit gave the job */
    int view, first_tile, tile_count;
};

/* Calls `each` for the render batches that were committed after a revision of the job, in the order
 * of their commits; stops when it returns false. Every commit gives its job a new revision, so no
 * two batches have the same. Fails: PEN_NOT_FOUND (no such job). */
typedef bool pen_commit_fn(void *user, const struct pen_commit_record *commit);
bool pen_store_commits(struct pen_store *store, const char *id, int64_t after, pen_commit_fn *each,
                       void *user, struct pen_status *st);

/* A worker as it describes itself. */
struct pen_worker_new {
    const char *id;   /* random, from pen_worker_id_make */
    const char *host; /* for readers: host and pid tell where the worker runs */
    int64_t pid;
    int threads;
    int64_t lease_ms; /* length of its leases; a lease's end then tells when it was extended */
};

/* Makes the id of a worker: 128 random bits as hexadecimal digits. Fails: PEN_IO (the system gives
 * no random bytes). */
bool pen_worker_id_make(char id[PEN_WORKER_ID_BYTES], struct pen_status *st);

/* Takes a lock that marks the worker as living, for as long as this handle is open; the end of the
 * process ends it too. Fails: PEN_CONFLICT (another handle has it), PEN_STORAGE. */
bool pen_store_worker_lock(struct pen_store *store, const char *id, struct pen_status *st);

/* Takes the lock that only one handle of a store may have, that of its supervisor, until the handle
 * is closed or the process ends. It is in the store itself, so no file that may be removed has it.
 * No other handle of the process may be open when this one is closed: it could lose SQLite's locks.
 * Fails: PEN_CONFLICT (another handle has it), PEN_STORAGE. */
bool pen_store_supervise(struct pen_store *store, struct pen_status *st);

/* Stores or renews a worker's row in the list of workers. To be called before the first claim and
 * repeated from time to time. */
bool pen_store_worker_seen(struct pen_store *store, const struct pen_worker_new *worker,
                           struct pen_status *st);

/* Removes a worker from the list, if it is there. */
bool pen_store_worker_gone(struct pen_store *store, const char *id, struct pen_status *st);

/* A worker and a batch that it holds. */
struct pen_worker_record {
    const char *id, *host;
    int64_t pid;
    int threads;
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

/* Looks for contradictions between rows: missing owners, states that exclude each other, wrong
 * sums. Calls `each` with a sentence for each one; *found is their number. For tests and after a
 * crash. Cost: reads everything except pixels and pictures. */
typedef void pen_audit_fn(void *user, const char *finding);
bool pen_store_audit(struct pen_store *store, pen_audit_fn *each, void *user, int *found,
                     struct pen_status *st);

/* Counters of what all processes have done since the store's shared memory was made (SQLite: the
 * -wake file). They are for monitoring; a crash may lose the last ones. */
enum pen_tally {
    PEN_TALLY_COMMIT_OK,
    PEN_TALLY_COMMIT_DUPLICATE,
    PEN_TALLY_COMMIT_STALE,
    PEN_TALLY_LEASES_LOST,   /* expired, or their worker found dead */
    PEN_TALLY_RAYS,          /* of render batches; added by workers */
    PEN_TALLY_WORKER_STARTS, /* added by workers */
    PEN_TALLY_SCRUBBED,      /* blobs that pen_store_scrub has checked */
    PEN_TALLY_DAMAGED,       /* those that it found damaged in its last whole pass: a state */
    PEN_TALLY_TIMINGS        /* those of enum pen_timing follow */
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
struct pen_histogram {
    const double *bounds_s;                 /* PEN_TIMING_BUCKETS upper bounds, ascending */
    uint64_t count[PEN_TIMING_BUCKETS + 1]; /* of times above the bound before; the last: longer */
    uint64_t sum_us;
};

/* Threads: any. */
void pen_store_tally_add(struct pen_store *store, enum pen_tally tally, uint64_t count);
uint64_t pen_store_tally(struct pen_store *store, enum pen_tally tally);
struct pen_histogram pen_store_timing(struct pen_store *store, enum pen_timing timing);

/* Signals between all handles of a store: two counters that only grow. PEN_SIGNAL_WORK grows when a
 * batch becomes claimable, PEN_SIGNAL_CHANGES (the change notification) when a job changes. A
 * signal may be lost, so callers also read the store from time to time. */
enum pen_signal { PEN_SIGNAL_WORK, PEN_SIGNAL_CHANGES };

/* Waits until the counter differs from *seen or the time is up; sets *seen to its value.
 * Threads: may be called while another thread uses the same handle; so may pen_store_wake. */
void pen_store_wait(struct pen_store *store, enum pen_signal signal, uint32_t *seen,
                    int timeout_ms);

/* Gives a signal: wakes all that wait for it, in all processes. */
void pen_store_wake(struct pen_store *store, enum pen_signal signal);

#endif
