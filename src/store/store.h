/* SPDX-License-Identifier: MIT */
/* The durable store, the only connection between the api process and the workers. It keeps jobs,
 * their scene documents, batches with leases, results (pixels, pictures, layers, reports),
 * idempotency keys and workers. src/store/README.md has the rules.
 *
 * What the store promises
 *  - A function that returned true has its effect on disk.
 *  - A commit is one transaction: pixels, statistics, artefact and state together. It fails with
 *    PEN_STALE unless the batch is still leased under the same attempt.
 *  - A commit repeated with the same claim succeeds and changes nothing. So does a submit repeated
 *    with the same id, and a claim repeated with the same serial number returns the same batch.
 *  - After a failed call, pen_store_failure tells whether nothing has happened or the outcome is
 *    unknown.
 *  - PEN_STORAGE is an I/O error or damage: the process should end, so that another one recovers.
 *    PEN_STORAGE_FULL passes when there is space again.
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
    PEN_WORKER_ID_BYTES = 33
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

/* Opens a store. `url` is the path of its file; with `make`, the file and its folders are made if
 * they are not there. Owns: pen_store_close. Fails: PEN_NOT_FOUND (there is none), PEN_STORAGE (not
 * a Penumbra store, another schema version (the message names both), damaged, no permission),
 * PEN_UNSUPPORTED (a postgres:// URL), PEN_USAGE (no path, or too long), PEN_STORAGE_FULL,
 * PEN_UNAVAILABLE (busy), PEN_NO_MEMORY. */
struct pen_store *pen_store_open(const char *url, bool make, struct pen_status *st);
void pen_store_close(struct pen_store *store);

/* Looks for damage, for at most limit_ms (0: in everything). *finished: it came to the end. Fails:
 * PEN_STORAGE with the first damage found. */
bool pen_store_check(struct pen_store *store, int limit_ms, bool *finished, struct pen_status *st);

/* Whether a new job would be accepted now: there is space on the disk, and below keep_bytes. Fails:
 * as pen_store_submit. */
bool pen_store_intake(struct pen_store *store, struct pen_status *st);

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

/* Whether a call on this handle has failed by an I/O error or damage of the database itself, and
 * not of one value; *why (may be NULL) is the first such failure. The process should end. */
bool pen_store_is_broken(const struct pen_store *store, struct pen_status *why);

/* Classifies the failure of the last call on this handle; `st` is the status it has filled. */
enum pen_failure pen_store_failure(const struct pen_store *store, const struct pen_status *st);

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
    struct pen_buf ids; /* of the first PEN_QUEUE_TOLD open jobs, PEN_ID_BYTES each, in the order in
                         * which their next batches are claimed */
    int64_t hand_us;    /* what the batches in hand still take, as far as it is known, each at most
                         * a minute: by then its turn is over */
    int64_t workers;    /* that are there now */
    int64_t job_us;     /* how long workers took for a job: the mean of the last 50 jobs that took
                         * any time and have ended. 0: there were none */
};

/* Open jobs are told their place up to here. */
enum { PEN_QUEUE_TOLD = 1000 };

/* Reads the queue; the caller releases its ids, also after a failure. Fails: PEN_NO_MEMORY. Cost:
 * an index of open batches, as far as PEN_QUEUE_TOLD jobs. */
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

/* Claims the next batch: by priority, then turn, then age (README.md, Order). The job becomes
 * running. A quarantined batch goes only to a worker that holds nothing else, and a worker that
 * holds a quarantined batch or a study gets nothing. `serial` is the worker's own count of claims:
 * a call that is repeated with the same number gets the batch that it got. *found = false: there is
 * nothing to do. */
bool pen_store_claim(struct pen_store *store, const char *worker, int64_t lease_ms, int64_t serial,
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
 * held for a minute, and any batch of its own priority is open. A batch that is released takes a
 * new turn, behind those of its client that are open. */
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

/* Finds the next job that retention removes, the one with the oldest end; the caller makes its
 * statistics and deletes it. */
bool pen_store_expired(struct pen_store *store, char id[PEN_ID_BYTES], bool *found,
                       struct pen_status *st);

/* Stores an artefact of a job that can be made again, from what is committed; one that exists is
 * replaced. It is dropped when others are used later, or space runs short; it is not stored at all
 * if it is too large or space is short. Fails: PEN_NOT_FOUND. */
bool pen_store_cache_put(struct pen_store *store, const char *id, int view, const char *layer,
                         const char *format, const void *data, size_t bytes, struct pen_status *st);

/* A slice of what deletes, retention and time leave to do, in a short transaction: parts of removed
 * jobs and of objects that nothing uses, cached artefacts beyond their share, scenes without a job,
 * old keys, statistics and workers, free space for the file system. *more is false if there was
 * nothing to do. One process at a time does it; a caller pauses between slices. */
bool pen_store_tidy(struct pen_store *store, bool *more, struct pen_status *st);

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

/* A worker as it describes itself. Its host, boot id, pid and start time are this process's. */
struct pen_worker_new {
    const char *id; /* random, from pen_worker_id_make */
    int supervisor; /* the process that reports its end by pen_store_worker_ended; 0: none */
    int threads;
    int64_t lease_ms;   /* length of its leases */
    int64_t rays_per_s; /* by its last batches, with all its threads; 0: not known */
};

/* Makes the id of a worker: 128 random bits as hexadecimal digits. Fails: PEN_IO (the system gives
 * no random bytes). */
bool pen_worker_id_make(char id[PEN_WORKER_ID_BYTES], struct pen_status *st);

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

/* Counters of what the processes have done, for monitoring. A process counts in memory; a worker's
 * numbers are stored with its row (pen_store_worker_seen, pen_store_worker_gone), so a crash loses
 * the last ones. Numbers of workers that are gone stay in the sums. */
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

/* The sums over all processes. Cost: a row for each worker. */
bool pen_store_counters(struct pen_store *store, struct pen_counters *counters,
                        struct pen_status *st);

/* A counter that grows when a process may have changed the store, as far as this process knows:
 * with each change of its own, and with those of others that a thread in pen_store_wait has
 * noticed. Threads: any. */
uint32_t pen_store_changes(void);

/* Waits until the counter differs from *seen or the time is up; sets *seen to its value. Signals
 * are hints: a caller reads the store after it has read the counter, and from time to time in any
 * case. Threads: beside others that use the handle; so may pen_store_wake. */
void pen_store_wait(struct pen_store *store, uint32_t *seen, int timeout_ms);

/* Lets the counters of all processes grow, which ends their waits. */
void pen_store_wake(struct pen_store *store);

/* Signals between processes. A supervisor calls pen_store_signals_make once, before its first
 * child, for so many processes; each child names its slot by pen_store_signals_join before it opens
 * a store. Without them, a wait looks every quarter of a second. */
bool pen_store_signals_make(int slots, struct pen_status *st);
void pen_store_signals_join(int slot);

#endif
