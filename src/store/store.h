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
 *  - A caller's function that a read calls for each row must not use the handle.
 *
 * jobs.h, claims.h and results.h are parts of this header.
 *
 * Threads: a handle is used by one thread at a time; open one per thread. Handles of different
 * processes may be open on the same store. */
#ifndef PEN_STORE_STORE_H
#define PEN_STORE_STORE_H

#include <stdatomic.h>

#include "store/claims.h"
#include "store/jobs.h"
#include "store/results.h"

/* Whether a store's address is that of a PostgreSQL database: a URL of libpq, which begins with
 * postgresql:// or postgres://. Any other is the path of a file. */
bool pen_store_is_postgres(const char *url);

/* Whether this build can use one. */
bool pen_store_has_postgres(void);

/* The address for logs and messages: without password and parameters. */
enum { PEN_STORE_LABEL_BYTES = 256 };
void pen_store_label(const char *url, char label[PEN_STORE_LABEL_BYTES]);

/* Whether the address has a password. */
bool pen_store_has_password(const char *url);

/* Opens a store. `url` is the path of its file, or the address of a PostgreSQL database, which is
 * there. With `make`, a file and its folders, or the tables, are made if they are not there. Owns:
 * pen_store_close. Fails: PEN_NOT_FOUND (there is none), PEN_STORAGE (not a Penumbra store, another
 * schema version (the message names both), damaged, no permission; a database that cannot be used,
 * with what to do about it), PEN_UNSUPPORTED (a build without PostgreSQL), PEN_USAGE (no path, or
 * too long), PEN_STORAGE_FULL, PEN_UNAVAILABLE (busy), PEN_NO_MEMORY. */
struct pen_store *pen_store_open(const char *url, bool make, struct pen_status *st);
void pen_store_close(struct pen_store *store);

/* Looks for damage, for at most limit_ms (0: in everything). *finished: it came to the end. Fails:
 * PEN_STORAGE with the first damage found. */
bool pen_store_check(struct pen_store *store, int limit_ms, bool *finished, struct pen_status *st);

/* Whether a new job would be accepted now: there is space on the disk, and below keep_bytes, and a
 * write reaches the disk. Cost: a synced write. Fails: as pen_store_submit. */
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

/* Finds the next job that retention removes, the one with the oldest end; the caller makes its
 * statistics and deletes it. */
bool pen_store_expired(struct pen_store *store, char id[PEN_ID_BYTES], bool *found,
                       struct pen_status *st);

/* A slice of what deletes, retention and time leave to do, in a short transaction: parts of removed
 * jobs and of objects that nothing uses, scenes without a job, old keys, statistics and workers,
 * free space for the file system. *more is false if there was nothing to do. One process at a time
 * does it; a caller pauses between slices. */
bool pen_store_purge(struct pen_store *store, bool *more, struct pen_status *st);

struct pen_backup {
    const atomic_bool *stop; /* given: ends the call when it becomes true; NULL: never */
    int64_t jobs, bytes;     /* of the copy */
};

/* Copies a store, which may be in use, to a file, as of one moment, with everything that was
 * acknowledged before the call. The copy is made as FILE.part-new, checked, synced and then renamed
 * (a symbolic link FILE is replaced itself); one that a killed process left is written over. Fails:
 * PEN_TIMEOUT (stopped), PEN_CONFLICT (the file exists, and `replace` is false; or another backup
 * to it is being made), PEN_USAGE (the name is a folder, the store itself, or too long), PEN_IO,
 * PEN_STORAGE_FULL (the copy cannot be written), PEN_STORAGE (the store is damaged or cannot be
 * read), PEN_NOT_FOUND (there is no store), PEN_UNAVAILABLE, PEN_NO_MEMORY. A failed call leaves no
 * file. Cost: reads every page, and the copy twice. */
bool pen_store_backup(const char *url, const char *file, bool replace, struct pen_backup *out,
                      struct pen_status *st);

/* Removes the unfinished copy that a killed process has left of this backup. */
void pen_store_backup_remove_left(const char *file);

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
