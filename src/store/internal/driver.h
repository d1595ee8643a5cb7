/* SPDX-License-Identifier: MIT */
/* What a database must do for the store. The policy (src/store: who may claim, what a commit
 * changes, who is charged for a crash) is written once over these operations; a driver
 * (src/store/sqlite/) runs one or a few statements for each and decides nothing. The rules of the
 * policy are in src/store/README.md.
 *
 * Transactions
 *  - An operation that changes rows is called between begin_write and commit, unless it says
 *    otherwise; one that reads, there, between begin_read and rollback, or alone.
 *  - begin_read gives one unchanging state of the database until rollback. PostgreSQL: REPEATABLE
 *    READ, READ ONLY.
 *  - begin_write: what has been read stays so until the end of the transaction, where this header
 *    says "locks"; elsewhere a conditional UPDATE tells by its number of rows. SQLite takes the one
 *    write lock (BEGIN IMMEDIATE), so everything is locked. PostgreSQL: READ COMMITTED, and what
 *    "locks" means is said beside each operation.
 *  - A race between find and insert is closed by a unique constraint alone: `*added = false` says
 *    that another had inserted the row before; the caller then reads that one.
 *  - No operation calls back into the caller: lists are pages, or arrays that the caller owns.
 *
 * Failures
 *  - An operation returns false and fills the status; the transaction is then rolled back.
 *  - A commit that fails sets outcome_unknown when its changes may be stored nevertheless (a sync
 *    failed, the connection was lost after COMMIT was sent). Else nothing has happened.
 *  - What a failure tells of the store's health is noted in `faults`; health.h decides the rest.
 *  - A statement that the database refused because of a concurrent transaction (PostgreSQL: 40001,
 *    40P01, a foreign key whose row was just removed) is PEN_UNAVAILABLE: nothing has happened.
 *
 * Time: `now` is the only clock of the policy: that of the database, the same for all handles. */
#ifndef PEN_STORE_INTERNAL_DRIVER_H
#define PEN_STORE_INTERNAL_DRIVER_H

#include <stdatomic.h>

#include "base/arena.h"
#include "store/store.h"

/* What can be wrong with a store; see health.h. */
enum pen_fault {
    PEN_FAULT_FULL,   /* no space: nothing is broken */
    PEN_FAULT_IO,     /* a read, write or sync failed: what the handle believes may not be so */
    PEN_FAULT_DAMAGE, /* what was read cannot be */
    PEN_FAULT_COUNT
};

/* Words of a driver that health.h uses. */
enum { PEN_HEALTH_WORDS = 16 };

/* The head of every driver's handle. */
struct pen_driver {
    const struct pen_driver_ops *ops;
    const char *name;           /* of the store, for messages; the driver's */
    bool delegates_checkpoints; /* in: commits of this handle leave checkpoints to another */
    bool checkpoint_due;        /* out: it is time for one */
    bool closed;                /* out: the handle cannot go on and must be reopened */
    bool outcome_unknown;       /* out: the last commit failed and may have happened */
    int64_t transactions;       /* out: writing ones that were committed */
    unsigned faults;            /* out: bits of enum pen_fault that were met */
    int fault_errno;            /* out: of the last one, 0 if not known */
};

/* Blobs are read and written in ranges of at most so many bytes. */
enum { PEN_BLOB_RANGE_BYTES = 1 << 20 };

enum pen_blob_kind {
    PEN_BLOB_SCENE,   /* by number of the scene */
    PEN_BLOB_PIXELS,  /* by number of the batch */
    PEN_BLOB_ARTEFACT /* by number of the artefact */
};

/* A new blob: its length, and its first range, which is stored together with its row. */
struct pen_blob_start {
    size_t total;
    const void *data;
    size_t bytes; /* of data: min(total, PEN_BLOB_RANGE_BYTES) */
};

struct pen_key_row {
    const char *key;
    const unsigned char *body_sha256; /* 32 bytes */
    const char *answer;
    int64_t created_ms;
};

/* A job's place in the database, and what is decided by. */
struct pen_job_key {
    int64_t number, scene;
    enum pen_job_state state;
};

struct pen_job_row {
    struct pen_job_record record; /* attempts is the policy's: 0 */
    int64_t charges, scene;
};

/* A batch as decided by. */
struct pen_batch_row {
    enum pen_batch_state state;
    enum pen_batch_kind kind;
    int64_t job, attempt, pixels, lease_until_ms;
    int view;
};

struct pen_batch_add {
    int64_t job;
    struct pen_batch_new batch;
};

/* Progress of a job. */
struct pen_progress {
    int64_t job, pixels, now_ms;
    bool add;     /* to what is done; else this is what is done, at most the job's total */
    bool forgive; /* the deaths and charges of the job, and its pause */
};

/* Leases that are lost: of `worker` (NULL: of none), and those that end before before_ms. */
struct pen_lost {
    const char *worker;
    int64_t before_ms;
};

/* A job of which a lease was lost. */
struct pen_lost_job {
    int64_t number, deaths, charges, max_attempts;
};

/* A render batch that is done, and the length of its pixels as stored. */
struct pen_pixels_row {
    int64_t batch, pixels;
    int first_tile, tile_count;
    size_t bytes;
};

struct pen_stats_row {
    int64_t batch;
    struct pen_batch_stats stats; /* its text is the arena's */
};

struct pen_artefact_key {
    int64_t job;
    int view;
    const char *layer, *format;
};

struct pen_artefact_row {
    int64_t number, checksum;
    bool has_checksum; /* false: stored by a schema that had none */
    size_t bytes;
};

struct pen_driver_ops {
    /* The handle. */

    void (*close)(struct pen_driver *driver);
    /* Closes the connection without writing, and opens it anew; only a store that is there. After a
     * failure nothing but this and close may be called. */
    bool (*reopen)(struct pen_driver *driver, struct pen_status *st);
    /* Reads all for damage. */
    bool (*check)(struct pen_driver *driver, struct pen_status *st);
    /* A small write that is synced, in a transaction of its own. */
    bool (*probe)(struct pen_driver *driver, struct pen_status *st);
    /* Whether there is space for more than a trifle: writes about a MiB, and takes it back. */
    bool (*space)(struct pen_driver *driver, struct pen_status *st);
    /* Brings the log's changes to their place. PostgreSQL: nothing to do. */
    bool (*checkpoint)(struct pen_driver *driver, struct pen_status *st);
    /* Gives space no longer needed back to the file system, in short transactions of its own. */
    bool (*reclaim)(struct pen_driver *driver, struct pen_status *st);
    /* Looks for rows that contradict each other. Appends a sentence for each to `findings`, each
     * with its end; *found is their number. */
    bool (*audit)(struct pen_driver *driver, struct pen_buf *findings, int *found,
                  struct pen_status *st);

    /* Time and signals. */

    /* The store's clock, ms since 1970. In a transaction it may be the time of its beginning. */
    bool (*now)(struct pen_driver *driver, int64_t *now_ms, struct pen_status *st);
    /* As pen_store_wait and pen_store_wake. A signal may be lost, never invented for ever; a wait
     * ends in time without one. PostgreSQL: LISTEN and NOTIFY.
     * Threads: wait and wake may be called while another thread uses the handle. */
    void (*wait)(struct pen_driver *driver, enum pen_signal signal, uint32_t *seen, int timeout_ms);
    void (*wake)(struct pen_driver *driver, enum pen_signal signal);
    /* PEN_HEALTH_WORDS words that are zero at first, shared by as many handles of the store as can
     * be; see health.h. */
    _Atomic uint32_t *(*health_words)(struct pen_driver *driver);
    /* A lock on the store's repair, unless another has it; false: another has. */
    bool (*repair_lock)(struct pen_driver *driver, int *lock);
    void (*repair_unlock)(struct pen_driver *driver, int lock);

    /* Transactions. */

    bool (*begin_read)(struct pen_driver *driver, struct pen_status *st);
    bool (*begin_write)(struct pen_driver *driver, struct pen_status *st);
    bool (*commit)(struct pen_driver *driver, struct pen_status *st);
    void (*rollback)(struct pen_driver *driver); /* also ends begin_read */

    /* Submitting. */

    bool (*key_add)(struct pen_driver *driver, const struct pen_key_row *key, bool *added,
                    struct pen_status *st);
    /* The answer is appended; NULL: not wanted. */
    bool (*key_get)(struct pen_driver *driver, const char *key, unsigned char body_sha256[32],
                    struct pen_buf *answer, bool *found, struct pen_status *st);
    bool (*scene_find)(struct pen_driver *driver, const unsigned char sha256[32], int64_t *number,
                       bool *found, struct pen_status *st);
    bool (*scene_add)(struct pen_driver *driver, const unsigned char sha256[32],
                      const struct pen_blob_start *document, int64_t *number, bool *added,
                      struct pen_status *st);
    /* Numbers of jobs grow and are never used twice, nor are those of batches. *added = false:
     * there is a job of this id. */
    bool (*job_add)(struct pen_driver *driver, const struct pen_job_new *job, int64_t scene,
                    int64_t total_pixels, int64_t *number, bool *added, struct pen_status *st);
    bool (*view_add)(struct pen_driver *driver, int64_t job, int view,
                     const struct pen_view_new *what, int batches, struct pen_status *st);
    /* With the priority of its job. *added = false: the view has its assemble batch. */
    bool (*batch_add)(struct pen_driver *driver, const struct pen_batch_add *batch, bool *added,
                      struct pen_status *st);

    /* Jobs. */

    /* Owns: the record's texts, malloc()ed; see pen_job_record_release. */
    bool (*job_get)(struct pen_driver *driver, const char *id, struct pen_job_row *job, bool *found,
                    struct pen_status *st);
    /* Newest first; `rows` has space for filter->limit. After a failure it holds none. */
    bool (*job_page)(struct pen_driver *driver, const struct pen_job_filter *filter,
                     struct pen_job_row *rows, int *count, struct pen_status *st);
    /* Locks the job. PostgreSQL: FOR UPDATE in a write transaction. */
    bool (*job_find)(struct pen_driver *driver, const char *id, struct pen_job_key *job,
                     bool *found, struct pen_status *st);
    bool (*job_counts)(struct pen_driver *driver, struct pen_counts *counts, struct pen_status *st);
    /* A queued job becomes running, with a new revision; another stays as it is. */
    bool (*job_start)(struct pen_driver *driver, int64_t job, int64_t now_ms, bool *changed,
                      struct pen_status *st);
    /* Adds a revision. */
    bool (*job_progress)(struct pen_driver *driver, const struct pen_progress *progress,
                         struct pen_status *st);
    /* Counts a view off; *open_views: how many are left. Locks the job. */
    bool (*job_view_ended)(struct pen_driver *driver, int64_t job, int64_t *open_views,
                           struct pen_status *st);
    /* A running job has succeeded; the revision is that of the progress before. */
    bool (*job_succeed)(struct pen_driver *driver, int64_t job, int64_t now_ms,
                        struct pen_status *st);
    /* A queued or running job is failed or cancelled, with a new revision; another stays as it is.
     * `error` is NULL unless it failed. */
    bool (*job_end)(struct pen_driver *driver, int64_t job, enum pen_job_state state,
                    const char *error, int64_t now_ms, bool *changed, struct pen_status *st);
    /* Its open and leased batches are ended. */
    bool (*job_end_batches)(struct pen_driver *driver, int64_t job, struct pen_status *st);
    /* With its views, batches, pixels and artefacts. */
    bool (*job_remove)(struct pen_driver *driver, int64_t job, struct pen_status *st);
    /* number 0: all that no job names. */
    bool (*scene_remove_unused)(struct pen_driver *driver, int64_t number, struct pen_status *st);
    bool (*keys_remove)(struct pen_driver *driver, int64_t before_ms, struct pen_status *st);

    /* Batches and leases. */

    bool (*any_open)(struct pen_driver *driver, bool *any, struct pen_status *st);
    /* The first open batch by (priority, job, number), of jobs whose pause ends by paused_until_ms;
     * quarantined ones only if wanted. Locks the batch. PostgreSQL: FOR UPDATE OF batch SKIP
     * LOCKED, so that two workers never wait for each other here. *job is its number; attempt is
     * that before this claim. */
    bool (*next_open)(struct pen_driver *driver, int64_t paused_until_ms, bool quarantined,
                      struct pen_claim *claim, int64_t *job, bool *found, struct pen_status *st);
    /* How many batches a worker holds, and how many of them it must hold alone: quarantined ones
     * and studies. */
    bool (*held_by)(struct pen_driver *driver, const char *worker, int *count, int *alone,
                    struct pen_status *st);
    /* The first batch that a worker holds, as a claim. */
    bool (*first_held)(struct pen_driver *driver, const char *worker, struct pen_claim *claim,
                       int64_t *job, bool *found, struct pen_status *st);
    /* Locks the batch. */
    bool (*batch_get)(struct pen_driver *driver, int64_t batch, struct pen_batch_row *row,
                      bool *found, struct pen_status *st);
    /* An open batch becomes leased; *changed = false: it was not open. */
    bool (*batch_lease)(struct pen_driver *driver, int64_t batch, int64_t attempt,
                        const char *worker, int64_t until_ms, bool *changed, struct pen_status *st);
    /* A leased batch becomes open, is done, or its lease lasts longer, if it is still leased under
     * that attempt; else *changed is false. Done takes note of the revision of its job. */
    bool (*batch_open)(struct pen_driver *driver, int64_t batch, int64_t attempt, bool *changed,
                       struct pen_status *st);
    bool (*batch_done)(struct pen_driver *driver, int64_t batch, int64_t attempt, const char *stats,
                       int64_t now_ms, bool *changed, struct pen_status *st);
    bool (*batch_extend)(struct pen_driver *driver, int64_t batch, int64_t attempt,
                         int64_t until_ms, bool *changed, struct pen_status *st);
    /* Counts a batch off its view. *batches: how many the view had; *open: how many are left.
     * Locks the view: of two last commits only one sees 0. */
    bool (*view_batch_done)(struct pen_driver *driver, int64_t job, int view, int64_t *batches,
                            int64_t *open, struct pen_status *st);

    /* Lost leases. */

    bool (*any_lost)(struct pen_driver *driver, const struct pen_lost *lost, bool *any,
                     struct pen_status *st);
    /* The next jobs with numbers above `after`, at most `capacity`. Locks them. */
    bool (*lost_jobs)(struct pen_driver *driver, const struct pen_lost *lost, int64_t after,
                      struct pen_lost_job *jobs, int capacity, int *count, struct pen_status *st);
    /* Opens the batches; *opened is their number. */
    bool (*open_lost)(struct pen_driver *driver, const struct pen_lost *lost, bool quarantine,
                      int *opened, struct pen_status *st);
    bool (*job_set_deaths)(struct pen_driver *driver, int64_t job, int64_t deaths,
                           int64_t paused_until_ms, struct pen_status *st);
    /* Adds a revision. */
    bool (*job_set_charges)(struct pen_driver *driver, int64_t job, int64_t charges, int64_t now_ms,
                            struct pen_status *st);

    /* Blobs and lists. A page begins after `after` in its order, and has at most `capacity` rows.
     */

    bool (*blob_write)(struct pen_driver *driver, enum pen_blob_kind kind, int64_t number,
                       size_t offset, const void *data, size_t bytes, struct pen_status *st);
    /* Fails: PEN_NOT_FOUND (no such blob, or it is shorter). */
    bool (*blob_read)(struct pen_driver *driver, enum pen_blob_kind kind, int64_t number,
                      size_t offset, void *to, size_t bytes, struct pen_status *st);
    bool (*pixels_add)(struct pen_driver *driver, int64_t batch,
                       const struct pen_blob_start *pixels, struct pen_status *st);
    bool (*pixels_page)(struct pen_driver *driver, int64_t job, int view, int64_t after,
                        struct pen_pixels_row *rows, int capacity, int *count,
                        struct pen_status *st);
    /* Replaces one that is there. */
    bool (*artefact_put)(struct pen_driver *driver, const struct pen_artefact_key *key,
                         int64_t checksum, const struct pen_blob_start *data, int64_t *number,
                         struct pen_status *st);
    bool (*artefact_find)(struct pen_driver *driver, const struct pen_artefact_key *key,
                          struct pen_artefact_row *artefact, bool *found, struct pen_status *st);
    bool (*scene_of_job)(struct pen_driver *driver, const char *id, int64_t *number, size_t *bytes,
                         bool *found, struct pen_status *st);
    bool (*stats_page)(struct pen_driver *driver, int64_t job, int64_t after,
                       struct pen_arena *arena, struct pen_stats_row *rows, int capacity,
                       int *count, struct pen_status *st);
    bool (*batch_page)(struct pen_driver *driver, int64_t job, int64_t after,
                       struct pen_arena *arena, struct pen_batch_record *rows, int capacity,
                       int *count, struct pen_status *st);
    /* By revision. */
    bool (*commit_page)(struct pen_driver *driver, int64_t job, int64_t after,
                        struct pen_commit_record *rows, int capacity, int *count,
                        struct pen_status *st);

    /* Workers. */

    bool (*worker_put)(struct pen_driver *driver, const struct pen_worker_new *worker,
                       int64_t now_ms, struct pen_status *st);
    bool (*worker_remove)(struct pen_driver *driver, const char *id, struct pen_status *st);
    bool (*workers_remove)(struct pen_driver *driver, int64_t before_ms, struct pen_status *st);
    /* All: a row for each batch that a worker holds, and one for a worker that holds none.
     * Owns: *rows is the arena's, as are its texts. */
    bool (*worker_list)(struct pen_driver *driver, struct pen_arena *arena,
                        struct pen_worker_record **rows, int *count, struct pen_status *st);
    /* The ids of all that hold a lease or are on that list, in order, above `after`. */
    bool (*worker_id_page)(struct pen_driver *driver, const char *after, struct pen_arena *arena,
                           const char **ids, int capacity, int *count, struct pen_status *st);
    /* A lock that is the worker's for as long as this handle is open and its process lives.
     * PostgreSQL: pg_advisory_lock of a session. Fails: PEN_CONFLICT (another has it). */
    bool (*worker_lock)(struct pen_driver *driver, const char *id, struct pen_status *st);
    /* Whether somebody has that lock. */
    bool (*worker_lives)(struct pen_driver *driver, const char *id, bool *lives,
                         struct pen_status *st);
};

/* Opens the SQLite driver on a file. */
struct pen_driver *pen_sqlite_open(const char *path, struct pen_status *st);

/* As pen_store_backup. */
bool pen_sqlite_backup(const char *path, const char *file, bool replace, struct pen_backup *out,
                       struct pen_status *st);

#endif
