/* SPDX-License-Identifier: MIT */
/* The operations that the store needs of a database. The policy (src/store: who may claim, what a
 * commit changes, who is charged for a crash) is written once over them. A driver
 * (src/store/sqlite) runs one or a few statements for each operation and decides nothing.
 * src/store/README.md has the rules of the policy.
 *
 * Transactions
 *  - An operation that changes rows is called between begin_write and commit, unless its comment
 *    says otherwise. An operation that reads is called there, between begin_read and rollback, or
 *    alone.
 *  - begin_read shows one unchanging state of the database until rollback. PostgreSQL: REPEATABLE
 *    READ, READ ONLY.
 *  - begin_write: where this header says "locks", the rows that were read stay as they are until
 *    the end of the transaction. Elsewhere a conditional UPDATE tells by its number of rows
 *    whether they were as expected. SQLite takes its one write lock (BEGIN IMMEDIATE), which
 *    locks everything. PostgreSQL: READ COMMITTED, with the row locks named beside the
 *    operations.
 *  - A unique constraint alone closes the race between find and insert. `*added = false` means that
 *    another transaction has inserted the row; the caller then reads that row.
 *  - No operation calls a function of the caller. Lists are pages, or arrays that the caller owns.
 *
 * Failures
 *  - A failed operation returns false and fills the status; the caller rolls the transaction back.
 *  - A failed commit sets outcome_unknown if its changes may be stored (a sync failed, or the
 *    connection was lost after COMMIT was sent). Otherwise nothing has happened.
 *  - A failure that tells something about the store's health sets a bit in `faults` (health.h).
 *  - A statement that the database refuses because of a concurrent transaction (PostgreSQL:
 *    40001, 40P01, a foreign key whose row was just removed) fails with PEN_UNAVAILABLE, without
 *    an effect.
 *
 * Time: `now` is the policy's only clock, the same for all handles. */
#ifndef PEN_STORE_INTERNAL_DRIVER_H
#define PEN_STORE_INTERNAL_DRIVER_H

#include <errno.h>
#include <stdatomic.h>

#include "base/arena.h"
#include "store/store.h"

/* The kinds of fault of a store; health.h has their consequences. */
enum pen_fault {
    PEN_FAULT_FULL,   /* no space; nothing is broken */
    PEN_FAULT_IO,     /* a read, write or sync failed; the handle's caches may be wrong */
    PEN_FAULT_DAMAGE, /* the stored bytes contradict each other */
    PEN_FAULT_COUNT
};

static inline bool pen_errno_is_full(int error)
{
    return error == ENOSPC || error == EDQUOT;
}

/* The numbers of shared words that health.c and tally.c use. */
enum { PEN_HEALTH_WORDS = 16, PEN_TALLY_WORDS = 64 };

/* The head of every driver's handle. */
struct pen_driver {
    const struct pen_driver_ops *ops;
    const char *name; /* of the store; SQLite: its path without symbolic links. Owns: the driver */
    bool delegates_checkpoints; /* in: commits of this handle leave checkpoints to another handle */
    bool checkpoint_due;        /* out: a checkpoint is due */
    bool closed;                /* out: the handle is unusable until it is reopened */
    bool outcome_unknown;       /* out: the last commit failed, and its changes may be stored */
    int64_t transactions;       /* out: number of write transactions committed */
    unsigned faults;      /* out: faults met since the caller cleared it, as 1 << enum pen_fault */
    int fault_errno;      /* out: errno of the last fault, 0 if unknown */
    int64_t wanted_bytes; /* out: what the disk must have free for the blob that was refused last
                             for lack of space; stays until the caller clears it */
    int64_t (*clock)(void *user); /* in: for tests, the clock instead of the driver's; NULL: none */
    void *clock_user;
};

/* The most bytes of a blob that one call reads or writes. */
enum { PEN_BLOB_RANGE_BYTES = 1 << 20 };

enum pen_blob_kind {
    PEN_BLOB_SCENE,   /* numbered as the scene */
    PEN_BLOB_PIXELS,  /* numbered as the batch */
    PEN_BLOB_ARTEFACT /* numbered as the artefact */
};

enum { PEN_BLOB_KINDS = PEN_BLOB_ARTEFACT + 1 };

/* A blob with what its check needs, and to what it belongs. */
struct pen_blob_row {
    int64_t number;
    size_t bytes;
    int64_t pixels;    /* of a batch */
    int64_t checksum;  /* of an artefact */
    bool has_checksum; /* false: stored under a schema without checksums */
    char job[PEN_ID_BYTES];
    char name[64]; /* of an artefact: its layer and format */
};

/* A new blob: its length, and its first range, which is stored with its row. */
struct pen_blob_start {
    size_t total;
    const void *data;
    size_t bytes;   /* of data: min(total, PEN_BLOB_RANGE_BYTES) */
    int64_t object; /* above 0: the large object that has it all instead; not of a scene */
};

/* Whose a new job is. */
static inline const char *pen_job_client(const struct pen_job_new *job)
{
    return job->client ? job->client : "";
}

struct pen_key_row {
    const char *client, *key;
    const unsigned char *body_sha256; /* 32 bytes */
    const char *answer;
    int64_t created_ms;
};

/* A job as far as the policy needs it to decide. */
struct pen_job_key {
    int64_t number, scene;
    enum pen_job_state state;
};

struct pen_job_row {
    struct pen_job_record record; /* attempts is 0; the policy sets it */
    int64_t charges, scene;
};

/* A batch as far as the policy needs it to decide. */
struct pen_batch_row {
    enum pen_batch_state state;
    enum pen_batch_kind kind;
    int64_t job, attempt, pixels, lease_until_ms;
    int64_t spent_us, job_spent_us; /* the time spent under this attempt; on the job in all */
    int64_t work, job_work;         /* as told, of the batch and of the job, of PEN_WORK_ALL */
    int64_t job_pixels;             /* of the job in all */
    int64_t job_deaths, job_started_ms;
    int view;
};

/* The longest pause of a job. One that ends later is not kept: the clock was set back. */
enum { PEN_PAUSE_MAX_MS = 60000 };

struct pen_batch_add {
    int64_t job;
    struct pen_batch_new batch;
};

/* Progress of a job. */
struct pen_progress {
    int64_t job, pixels, now_ms;
    bool add;     /* true: add `pixels` to done_pixels. false: set it, to the job's total at most */
    bool forgive; /* set the job's deaths and charges to 0, end its pause */
    int64_t estimate_ms; /* above 0: what the job is expected to take */
    int64_t batch, work; /* the share of the job's work that this batch has, from now on, which is
                            told with the time spent, if there is an estimate or `forgive`; batch 0:
                            as it was */
    const struct pen_buf *cost_map; /* NULL: as it was */
    /* Instead of `add`: raise done_pixels to the pixels of the batches that are done and these, if
     * it is below. */
    bool raise;
};

/* What is stored with a batch that is done. */
struct pen_batch_end {
    const char *stats;
    int64_t now_ms, commit_us;
};

/* Which leases are lost: those of `worker` (NULL: of none), and those that end before before_ms. */
struct pen_lost {
    const char *worker;
    int64_t before_ms;
};

/* A job with a lost lease. */
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
    struct pen_batch_stats stats; /* its text belongs to the arena */
};

struct pen_artefact_key {
    int64_t job;
    int view;
    const char *layer, *format;
};

struct pen_artefact_row {
    int64_t number, checksum;
    bool cached;       /* it can be made again */
    int64_t used_ms;   /* then: when it was last used, about */
    bool has_checksum; /* false: stored under a schema without checksums */
    size_t bytes;
};

/* How much space there is. */
struct pen_room {
    int64_t used_bytes;                  /* of the store, without what is free in it */
    int64_t free_bytes;                  /* free in it, for what it stores next */
    int64_t disk_bytes, disk_free_bytes; /* of its disk; 0: not known */
    int64_t log_bytes; /* that its log may take of the disk for a while; the disk being known */
};

struct pen_driver_ops {
    /* The handle. */

    void (*close)(struct pen_driver *driver);
    /* Closes the connection without writing, and connects anew. Makes no new store. After a failure
     * only reopen and close may be called. */
    bool (*reopen)(struct pen_driver *driver, struct pen_status *st);
    /* Looks for damage; reads everything. */
    bool (*check)(struct pen_driver *driver, struct pen_status *st);
    /* The same in a part that takes well below a second, however large the store is. */
    bool (*check_start)(struct pen_driver *driver, struct pen_status *st);
    /* Writes a little in a transaction of its own, and syncs it. */
    bool (*probe)(struct pen_driver *driver, struct pen_status *st);
    /* Fails unless a MiB is free, what is missing of the reserve, and what the log needs to be
     * copied. PostgreSQL: a trial write. */
    bool (*space)(struct pen_driver *driver, struct pen_status *st);
    bool (*room)(struct pen_driver *driver, struct pen_room *room, struct pen_status *st);
    /* A part of the disk that is set aside for the calls that free space. `make` sets it aside, or
     * what is missing of it, and fails with PEN_STORAGE_FULL; `move` gives a part of it to the
     * store's own files, and returns whether there was any; `is_out`: it is wanted, and not all
     * there, or the log has more to copy than there is space for. PostgreSQL: does nothing. */
    bool (*reserve_make)(struct pen_driver *driver, struct pen_status *st);
    bool (*reserve_move)(struct pen_driver *driver);
    bool (*reserve_is_out)(struct pen_driver *driver);
    /* A number that is stored under a name; 0 if there is none. */
    bool (*meta_get)(struct pen_driver *driver, const char *name, int64_t *value,
                     struct pen_status *st);
    bool (*meta_put)(struct pen_driver *driver, const char *name, int64_t value,
                     struct pen_status *st);
    /* Copies the log's changes to their place. PostgreSQL: does nothing. */
    bool (*checkpoint)(struct pen_driver *driver, struct pen_status *st);
    /* The same, and waits for readers, longer at the first try, so that the next write begins the
     * log anew, for which a full disk needs no space. Faults are noted. PostgreSQL: does nothing.
     */
    void (*restart_log)(struct pen_driver *driver, bool first);
    /* As `checkpoint`, once a fraction of the length has been reached at which commits do so:
     * whoever can wait spares others the wait. PostgreSQL: does nothing. */
    bool (*keep_log_short)(struct pen_driver *driver, struct pen_status *st);
    /* The store's identity. PostgreSQL: a row. */
    const char *(*identity)(struct pen_driver *driver);
    /* As pen_store_settle. PostgreSQL: does nothing. */
    bool (*settle)(struct pen_driver *driver, struct pen_status *st);
    /* Returns a little free space to the file system, in a short transaction of its own. *more:
     * there was some, and there may be more. PostgreSQL: does nothing. */
    bool (*reclaim)(struct pen_driver *driver, bool *more, struct pen_status *st);
    /* Looks for rows that contradict each other. Appends a sentence with its terminating zero to
     * `findings` for each; *found is their number. In a transaction of its own. */
    bool (*audit)(struct pen_driver *driver, struct pen_buf *findings, int *found,
                  struct pen_status *st);

    /* Time and signals. */

    /* The store's clock, ms since 1970. In a transaction it may be the time at which that began. */
    bool (*now)(struct pen_driver *driver, int64_t *now_ms, struct pen_status *st);
    /* As pen_store_wait and pen_store_wake. A signal may be lost, and a counter may change without
     * one, but not all the time. PostgreSQL: LISTEN and NOTIFY.
     * Threads: wait and wake may be called while another thread uses the handle. */
    void (*wait)(struct pen_driver *driver, enum pen_signal signal, uint32_t *seen, int timeout_ms);
    void (*wake)(struct pen_driver *driver, enum pen_signal signal);
    /* PEN_HEALTH_WORDS words, zero at first, shared by as many handles of the store as possible.
     * Used by health.c only. */
    _Atomic uint32_t *(*health_words)(struct pen_driver *driver);
    /* PEN_TALLY_WORDS sums, zero at first, shared likewise. Used by tally.c only. Threads: any. */
    _Atomic uint64_t *(*tallies)(struct pen_driver *driver);
    /* Takes the lock on the store's recovery; returns false if another handle has it. *lock is for
     * repair_unlock. */
    bool (*repair_lock)(struct pen_driver *driver, int *lock);
    void (*repair_unlock)(struct pen_driver *driver, int lock);

    /* Transactions. */

    bool (*begin_read)(struct pen_driver *driver, struct pen_status *st);
    bool (*begin_write)(struct pen_driver *driver, struct pen_status *st);
    bool (*commit)(struct pen_driver *driver, struct pen_status *st);
    /* Also ends begin_read. Without an open transaction it does nothing. */
    void (*rollback)(struct pen_driver *driver);

    /* Submitting. */

    bool (*key_add)(struct pen_driver *driver, const struct pen_key_row *key, bool *added,
                    struct pen_status *st);
    /* Appends the stored answer; NULL: it is not wanted. */
    bool (*key_get)(struct pen_driver *driver, const char *client, const char *key,
                    unsigned char body_sha256[32], struct pen_buf *answer, bool *found,
                    struct pen_status *st);
    bool (*scene_find)(struct pen_driver *driver, const unsigned char sha256[32], int64_t *number,
                       bool *found, struct pen_status *st);
    bool (*scene_add)(struct pen_driver *driver, const unsigned char sha256[32],
                      const struct pen_blob_start *document, int64_t *number, bool *added,
                      struct pen_status *st);
    /* Also counts the job into the peer of its client and priority. Numbers of jobs and of batches
     * grow and are never reused. *added = false: there is a job with this id. */
    bool (*job_add)(struct pen_driver *driver, const struct pen_job_new *job, int64_t scene,
                    int64_t total_pixels, int64_t *number, bool *added, struct pen_status *st);
    bool (*view_add)(struct pen_driver *driver, int64_t job, int view,
                     const struct pen_view_new *what, int batches, struct pen_status *st);
    /* The batch gets the priority of its job. *added = false: the view has an assemble batch. */
    bool (*batch_add)(struct pen_driver *driver, const struct pen_batch_add *batch, bool *added,
                      struct pen_status *st);

    /* Jobs. */

    /* Owns: the record's texts are the caller's; see pen_job_record_release. */
    bool (*job_get)(struct pen_driver *driver, const char *id, struct pen_job_row *job, bool *found,
                    struct pen_status *st);
    /* Newest first; `rows` takes filter->limit rows. What filter->text_bytes leaves out is not
     * read. After a failure they hold nothing to release.
     */
    bool (*job_page)(struct pen_driver *driver, const struct pen_job_filter *filter,
                     struct pen_job_row *rows, int *count, struct pen_status *st);
    /* Locks the job. PostgreSQL: FOR UPDATE in a write transaction. */
    bool (*job_find)(struct pen_driver *driver, const char *id, struct pen_job_key *job,
                     bool *found, struct pen_status *st);
    /* Whether a job, or one of which removed_get finds what stays, is of a client. */
    bool (*job_is_of)(struct pen_driver *driver, const char *id, const char *client, bool *is,
                      struct pen_status *st);
    bool (*job_counts)(struct pen_driver *driver, struct pen_counts *counts, struct pen_status *st);
    /* Makes a queued job running, with a new revision; *changed = false: it was not queued. This,
     * job_progress and job_end bring the job's elapsed time up to now. */
    bool (*job_start)(struct pen_driver *driver, int64_t job, int64_t now_ms, bool *changed,
                      struct pen_status *st);
    /* Gives the job a new revision. */
    bool (*job_progress)(struct pen_driver *driver, const struct pen_progress *progress,
                         struct pen_status *st);
    /* Subtracts one from the job's open views; *open_views is the rest. Locks the job. */
    bool (*job_view_ended)(struct pen_driver *driver, int64_t job, int64_t *open_views,
                           struct pen_status *st);
    /* Makes a running job succeeded, without a new revision: job_progress has given one. This and
     * job_end count it out of its peer. */
    bool (*job_succeed)(struct pen_driver *driver, int64_t job, int64_t now_ms,
                        struct pen_status *st);
    /* Makes a queued or running job failed or cancelled, with a new revision; *changed = false: it
     * had ended. `error` is NULL unless it fails. */
    bool (*job_end)(struct pen_driver *driver, int64_t job, enum pen_job_state state,
                    const char *error, int64_t now_ms, bool *changed, struct pen_status *st);
    /* Ends its open and leased batches, and their quarantine. */
    bool (*job_end_batches)(struct pen_driver *driver, int64_t job, struct pen_status *st);
    /* Removes it with its views, batches, pixels and artefacts. */
    bool (*job_remove)(struct pen_driver *driver, int64_t job, struct pen_status *st);
    /* Appends the map of a job's work, which job_progress stores, and which goes when the job ends.
     */
    bool (*job_cost_map)(struct pen_driver *driver, const char *id, struct pen_buf *out,
                         struct pen_status *st);
    /* Marks an ended job as removed: from then on job_get, job_find, job_page, job_counts and
     * scene_of_job do not see it. */
    bool (*job_mark_removed)(struct pen_driver *driver, int64_t job, int64_t now_ms,
                             struct pen_status *st);
    /* The job that was submitted first of those marked as removed. */
    bool (*removed_next)(struct pen_driver *driver, struct pen_job_key *job, bool *found,
                         struct pen_status *st);
    /* Removes artefacts, batches and pixels of such a job, about so many bytes and one row at
     * least; *emptied: none is left. */
    bool (*job_shrink)(struct pen_driver *driver, int64_t job, int64_t bytes, bool *emptied,
                       struct pen_status *st);
    bool (*count_ended)(struct pen_driver *driver, int64_t *count, struct pen_status *st);
    /* The job that ended first of those that ended after after_ms. */
    bool (*first_ended)(struct pen_driver *driver, int64_t after_ms, char id[PEN_ID_BYTES],
                        int64_t *ended_ms, bool *found, struct pen_status *st);
    /* How much would become free if all ended jobs and the statistics of removed ones went, about
     * and rather too much; counted until it is `enough`. A scene document counts once, and not at
     * all if an unfinished job names it. */
    bool (*ended_bytes)(struct pen_driver *driver, int64_t enough, int64_t *bytes,
                        struct pen_status *st);
    /* What stays of a removed job: its id, its client, when it was removed, and its statistics
     * (NULL: none).
     * removed_get appends the statistics to `stats`, unless that is NULL. */
    bool (*removed_add)(struct pen_driver *driver, const char *id, int64_t now_ms,
                        const char *stats, struct pen_status *st);
    bool (*removed_get)(struct pen_driver *driver, const char *id, struct pen_buf *stats,
                        bool *has_stats, bool *found, struct pen_status *st);
    bool (*removed_drop_stats)(struct pen_driver *driver, const char *id, struct pen_status *st);
    /* Begins to count what the statistics of removed jobs take, unless it is counted already, or
     * ends counting; it is the number of the name "stats_bytes". Cost: beginning reads all of them.
     */
    bool (*stats_count)(struct pen_driver *driver, bool counted, struct pen_status *st);
    /* Removes at most `limit` such rows of jobs whose own rows are all gone, the oldest first:
     * those with statistics from before before_ms, and those without from before bare_before_ms.
     * *more: there may be more. */
    bool (*removed_purge)(struct pen_driver *driver, int64_t bare_before_ms, int64_t before_ms,
                          int limit, bool *more, struct pen_status *st);
    /* Removes the scene unless a job names it; number 0: all scenes that no job names. */
    bool (*scene_remove_unused)(struct pen_driver *driver, int64_t number, struct pen_status *st);
    /* Removes at most `limit` keys; *more: there may be more. */
    bool (*keys_remove)(struct pen_driver *driver, int64_t before_ms, int limit, bool *more,
                        struct pen_status *st);

    /* Batches and leases. */

    bool (*any_open)(struct pen_driver *driver, bool *any, struct pen_status *st);
    /* Finds the open batch that is next by the rules of shares (README.md), of jobs whose pause
     * ends by paused_until_ms, or later than PEN_PAUSE_MAX_MS after it; a quarantined batch only if
     * `quarantined`. Locks the batch. PostgreSQL: FOR UPDATE OF batch SKIP LOCKED, so that two
     * workers never wait for each other. *job is the job's number; claim->attempt is the attempt
     * before this claim. */
    bool (*next_open)(struct pen_driver *driver, int64_t paused_until_ms, bool quarantined,
                      struct pen_claim *claim, int64_t *job, bool *found, struct pen_status *st);
    /* Whether a batch is open, of a job that is not paused at now_ms, that comes before this one:
     * by its priority; if `aged`, by that to which its peer has come by waiting (README.md,
     * "Shares", 6); or, if `equal`, since it has the same and is another job's. */
    bool (*open_above)(struct pen_driver *driver, int64_t batch, int64_t now_ms, bool aged,
                       bool equal, bool *any, struct pen_status *st);
    /* Whether a batch of another job than this one's is open, of a job whose pause ends by
     * paused_until_ms. */
    bool (*open_elsewhere)(struct pen_driver *driver, int64_t batch, int64_t paused_until_ms,
                           bool *any, struct pen_status *st);
    /* Counts the batches that a worker holds, and those that it must hold alone: quarantined
     * batches and studies. */
    bool (*held_by)(struct pen_driver *driver, const char *worker, int *count, int *alone,
                    struct pen_status *st);
    /* Finds the first batch that a worker holds, as a claim. */
    bool (*first_held)(struct pen_driver *driver, const char *worker, struct pen_claim *claim,
                       int64_t *job, bool *found, struct pen_status *st);
    /* Locks the batch. */
    bool (*batch_get)(struct pen_driver *driver, int64_t batch, struct pen_batch_row *row,
                      bool *found, struct pen_status *st);
    /* Makes an open batch leased, with no time spent; *changed = false: it was not open. */
    bool (*batch_lease)(struct pen_driver *driver, int64_t batch, int64_t attempt,
                        const char *worker, int64_t until_ms, bool *changed, struct pen_status *st);
    /* Make a batch open or done, or extend its lease, if it is leased under that attempt; otherwise
     * *changed = false. batch_done also stores the job's revision and ends the quarantine. */
    bool (*batch_open)(struct pen_driver *driver, int64_t batch, int64_t attempt, bool *changed,
                       struct pen_status *st);
    bool (*batch_done)(struct pen_driver *driver, int64_t batch, int64_t attempt,
                       const struct pen_batch_end *end, bool *changed, struct pen_status *st);
    /* Leaves a render batch that is leased under that attempt its first `tile_count` tiles, which
     * have so many pixels. The others become an open batch of the same view, which then has one
     * batch more. Otherwise *changed = false. */
    bool (*batch_split)(struct pen_driver *driver, int64_t batch, int64_t attempt, int tile_count,
                        int64_t pixels, bool *changed, struct pen_status *st);
    bool (*batch_extend)(struct pen_driver *driver, int64_t batch, int64_t attempt,
                         int64_t until_ms, bool *changed, struct pen_status *st);
    /* Raises the time spent under the attempt of a leased batch to spent_us, and adds the
     * difference to the time of its job and its peer, which waits since now: time in which a peer
     * is served is none in which it waits. Does nothing if it is not leased under that attempt, or
     * has spent more. */
    bool (*batch_spend)(struct pen_driver *driver, int64_t batch, int64_t attempt, int64_t spent_us,
                        struct pen_status *st);
    /* Adds to the time of a job's leased batches, as batch_spend, what has passed since their
     * leases began or were extended: for a job that is ended from outside, whose workers have not
     * told yet. At most the length of a lease, since it is told by the clock of the store. */
    bool (*job_charge_leases)(struct pen_driver *driver, int64_t job, int64_t now_ms,
                              struct pen_status *st);
    /* Notes that the peer of the batch is served now. */
    bool (*share_served)(struct pen_driver *driver, int64_t batch, int64_t now_ms,
                         struct pen_status *st);
    /* What the results of unfinished jobs are expected to take, by the pixels and layers of their
     * views. expected_count counts the sum anew, or ends counting; it is the number of the name
     * "expected_bytes". expected_enter adds a job that has its views, if the sum is counted, and
     * tells what the job takes; job_succeed and job_end subtract that again. */
    bool (*expected_count)(struct pen_driver *driver, bool counted, struct pen_status *st);
    bool (*expected_enter)(struct pen_driver *driver, int64_t job, int64_t *bytes,
                           struct pen_status *st);
    /* The number of unfinished jobs, in all and of a client. */
    bool (*queue_lengths)(struct pen_driver *driver, const char *client, int64_t *all,
                          int64_t *of_client, struct pen_status *st);
    /* Sets the queue, which is {0}, as pen_store_queue. A worker is there while it was seen within
     * the length of its leases, or has a lease. */
    bool (*queue)(struct pen_driver *driver, struct pen_queue *queue, struct pen_status *st);
    /* Forgets what clients were served that have no unfinished jobs and were not served since. */
    bool (*peers_remove)(struct pen_driver *driver, int64_t before_ms, struct pen_status *st);
    /* Subtracts one from the view's open batches. *batches is the number of its batches, *open the
     * rest. Locks the view: of two concurrent last commits only one gets 0. */
    bool (*view_batch_done)(struct pen_driver *driver, int64_t job, int view, int64_t *batches,
                            int64_t *open, struct pen_status *st);

    /* Lost leases. */

    /* After the clock was set back stored times lie in the future which no call makes that has the
     * time now_ms. times_ahead tells whether there are any, and times_mend makes them now: since
     * when peers wait that have jobs, and when workers were seen; and the end of leases that would
     * last longer than the leases of their workers do: those last so long from now on. */
    bool (*times_ahead)(struct pen_driver *driver, int64_t now_ms, bool *any,
                        struct pen_status *st);
    bool (*times_mend)(struct pen_driver *driver, int64_t now_ms, struct pen_status *st);
    bool (*any_lost)(struct pen_driver *driver, const struct pen_lost *lost, bool *any,
                     struct pen_status *st);
    /* The next jobs that lost a lease, with numbers above `after`, at most `capacity`. Locks them.
     */
    bool (*lost_jobs)(struct pen_driver *driver, const struct pen_lost *lost, int64_t after,
                      struct pen_lost_job *jobs, int capacity, int *count, struct pen_status *st);
    /* Opens the batches, and quarantines them if wanted; *opened is their number. */
    bool (*open_lost)(struct pen_driver *driver, const struct pen_lost *lost, bool quarantine,
                      int *opened, struct pen_status *st);
    bool (*job_set_deaths)(struct pen_driver *driver, int64_t job, int64_t deaths,
                           int64_t paused_until_ms, struct pen_status *st);
    /* Gives the job a new revision. */
    bool (*job_set_charges)(struct pen_driver *driver, int64_t job, int64_t charges, int64_t now_ms,
                            struct pen_status *st);

    /* Blobs and lists. A page holds the next rows above `after`, at most `capacity`. */

    bool (*blob_write)(struct pen_driver *driver, enum pen_blob_kind kind, int64_t number,
                       size_t offset, const void *data, size_t bytes, struct pen_status *st);
    /* Fails: PEN_NOT_FOUND (there is no such blob), PEN_STORAGE (it is shorter). */
    bool (*blob_read)(struct pen_driver *driver, enum pen_blob_kind kind, int64_t number,
                      size_t offset, void *to, size_t bytes, struct pen_status *st);
    /* The blob of a kind with the next number after `after`; row->bytes is its length, and the job
     * is one to which it belongs ("": none). */
    bool (*blob_next)(struct pen_driver *driver, enum pen_blob_kind kind, int64_t after,
                      struct pen_blob_row *row, bool *found, struct pen_status *st);
    /* Large objects: values that are written before their row, in several transactions. object_add
     * makes one, of no parts yet. object_write adds one range of it, in order, and keeps the object
     * until expires_ms; *there = false: it was removed meanwhile. pixels_add and artefact_put give
     * it to their row, and fail with PEN_UNAVAILABLE if it was removed; it is released with that
     * row, or when that gets another value. object_release gives up one that no row has got. */
    bool (*object_add)(struct pen_driver *driver, size_t bytes, int64_t *number,
                       struct pen_status *st);
    bool (*object_write)(struct pen_driver *driver, int64_t number, size_t offset, const void *data,
                         size_t bytes, int64_t expires_ms, bool *there, struct pen_status *st);
    bool (*object_release)(struct pen_driver *driver, int64_t number, struct pen_status *st);
    /* Finds one that was released, or that no row has and whose time is before before_ms or after
     * after_ms. */
    bool (*object_unused)(struct pen_driver *driver, int64_t before_ms, int64_t after_ms,
                          int64_t *number, bool *found, struct pen_status *st);
    /* What is left of those that were released. */
    bool (*object_released_bytes)(struct pen_driver *driver, int64_t *bytes, struct pen_status *st);
    /* Removes about so many bytes of such an object, with the last of them the object. */
    bool (*object_shrink)(struct pen_driver *driver, int64_t number, int64_t bytes,
                          struct pen_status *st);
    bool (*pixels_add)(struct pen_driver *driver, int64_t batch,
                       const struct pen_blob_start *pixels, struct pen_status *st);
    bool (*pixels_page)(struct pen_driver *driver, int64_t job, int view, int64_t after,
                        struct pen_pixels_row *rows, int capacity, int *count,
                        struct pen_status *st);
    /* Replaces an artefact with the same key. */
    bool (*artefact_put)(struct pen_driver *driver, const struct pen_artefact_key *key,
                         int64_t checksum, const struct pen_blob_start *data, int64_t *number,
                         struct pen_status *st);
    bool (*artefact_find)(struct pen_driver *driver, const struct pen_artefact_key *key,
                          struct pen_artefact_row *artefact, bool *found, struct pen_status *st);
    /* Removes the artefacts of a layer of a view, in any format. */
    bool (*artefacts_drop)(struct pen_driver *driver, const struct pen_artefact_key *key,
                           struct pen_status *st);
    /* The same, of all views of a job. */
    bool (*job_artefacts_drop)(struct pen_driver *driver, int64_t job, const char *layer,
                               struct pen_status *st);
    /* Artefacts that can be made again. cached_put marks one, with its length; cached_evict removes
     * the one that was used longest ago, and subtracts its length from *bytes. */
    bool (*cached_put)(struct pen_driver *driver, int64_t artefact, int64_t bytes, int64_t now_ms,
                       struct pen_status *st);
    bool (*cached_touch)(struct pen_driver *driver, int64_t artefact, int64_t now_ms,
                         struct pen_status *st);
    bool (*cached_bytes)(struct pen_driver *driver, int64_t *bytes, struct pen_status *st);
    bool (*cached_evict)(struct pen_driver *driver, int64_t *bytes, struct pen_status *st);
    bool (*scene_of_job)(struct pen_driver *driver, const char *id, int64_t *number, size_t *bytes,
                         bool *found, struct pen_status *st);
    bool (*stats_page)(struct pen_driver *driver, int64_t job, int64_t after,
                       struct pen_arena *arena, struct pen_stats_row *rows, int capacity,
                       int *count, struct pen_status *st);
    bool (*batch_page)(struct pen_driver *driver, int64_t job, int64_t after,
                       struct pen_arena *arena, struct pen_batch_record *rows, int capacity,
                       int *count, struct pen_status *st);
    /* In the order of revisions. */
    bool (*commit_page)(struct pen_driver *driver, int64_t job, int64_t after,
                        struct pen_commit_record *rows, int capacity, int *count,
                        struct pen_status *st);

    /* Workers. */

    bool (*worker_put)(struct pen_driver *driver, const struct pen_worker_new *worker,
                       int64_t now_ms, struct pen_status *st);
    bool (*worker_remove)(struct pen_driver *driver, const char *id, struct pen_status *st);
    bool (*workers_remove)(struct pen_driver *driver, int64_t before_ms, struct pen_status *st);
    /* All workers: a row for each batch that a worker holds, or one row if it holds none.
     * Owns: *rows and its texts belong to the arena. */
    bool (*worker_list)(struct pen_driver *driver, struct pen_arena *arena,
                        struct pen_worker_record **rows, int *count, struct pen_status *st);
    /* The next ids above `after`, in order, of all that hold a lease or are in the list of workers.
     */
    bool (*worker_id_page)(struct pen_driver *driver, const char *after, struct pen_arena *arena,
                           const char **ids, int capacity, int *count, struct pen_status *st);
    /* Takes the worker's lock, until the handle is closed or its process ends. PostgreSQL:
     * pg_try_advisory_lock of the session. Fails: PEN_CONFLICT (another handle has it). */
    bool (*worker_lock)(struct pen_driver *driver, const char *id, struct pen_status *st);
    /* Tells whether a handle has that lock; true also if that cannot be told. */
    bool (*worker_lives)(struct pen_driver *driver, const char *id, bool *lives,
                         struct pen_status *st);
    /* As pen_store_supervise. PostgreSQL: pg_try_advisory_lock of the session. */
    bool (*supervise)(struct pen_driver *driver, struct pen_status *st);
};

/* Opens the SQLite driver on a file. identity: that of the store, "": any; nothing is made then.
 * NULL: any store, which is made if there is none. Owns: free with its `close`. Fails: as
 * pen_store_open. */
struct pen_driver *pen_sqlite_open(const char *path, const char *identity, struct pen_status *st);

/* As pen_store_backup and pen_store_backup_remove_left. */
bool pen_sqlite_backup(const char *path, const char *file, bool replace, struct pen_backup *out,
                       struct pen_status *st);
void pen_sqlite_backup_remove_left(const char *file);

#endif
