/* SPDX-License-Identifier: MIT */
/* The durable store, and the only connection between the api process and the workers. It keeps jobs
 * and their scene documents, batches and their leases, results (pixels, pictures, layers, reports),
 * idempotency keys, and workers. Its rules are in src/store/README.md.
 *
 * What the store promises
 *   - A call that returned true has its effect on disk.
 *   - A commit is one transaction: it stores pixels, statistics, artefact and state together. It
 *     fails with PEN_STALE unless the batch is still leased under the same attempt.
 *   - Some calls may be repeated. A commit repeated with the same claim succeeds and changes
 *     nothing, and so does a submit repeated with the same id. A claim repeated with the same
 *     serial number returns the same batch.
 *   - After a failed call, pen_store_failure says whether the call had no effect or its outcome is
 *     unknown.
 *   - PEN_STORAGE is an I/O error or damage. The process should end, so that the next one recovers.
 *     PEN_STORAGE_FULL passes when there is space again.
 *   - All times are of the store's clock (pen_store_now), never of a caller's.
 *   - Some reads call a function of the caller for each row. This function must not use the handle.
 *
 * jobs.h, claims.h and results.h are parts of this header.
 *
 * Threads: one thread at a time uses a handle, so each thread opens its own. Several processes may
 * have the same store open. */
#ifndef PEN_STORE_STORE_H
#define PEN_STORE_STORE_H

#include <stdatomic.h>

#include "store/claims.h"
#include "store/jobs.h"
#include "store/results.h"

/* Returns true if the address is that of a PostgreSQL database: a libpq URL, which begins with
 * postgresql:// or postgres://. Any other address is the path of a file. */
bool pen_store_is_postgres(const char *url);

/* Returns true if this build can use PostgreSQL. */
bool pen_store_has_postgres(void);

/* Writes the address for logs and messages, without password and parameters. */
enum { PEN_STORE_LABEL_BYTES = 256 };
void pen_store_label(const char *url, char label[PEN_STORE_LABEL_BYTES]);

/* Returns true if the address has a password. */
bool pen_store_has_password(const char *url);

/* Opens a store. `url` is the path of its file, or the address of a PostgreSQL database that
 * exists. With `make`, a missing file and its folders, or missing tables, are made.
 * Owns: close with pen_store_close.
 * Fails: PEN_NOT_FOUND (no store), PEN_STORAGE (not a Penumbra store; damaged; no permission;
 * another schema version, and the message names both versions; a database that cannot be used, and
 * the message says what to do), PEN_UNSUPPORTED (a build without PostgreSQL), PEN_USAGE (no path,
 * or too long), PEN_STORAGE_FULL, PEN_UNAVAILABLE (busy), PEN_NO_MEMORY. */
struct pen_store *pen_store_open(const char *url, bool make, struct pen_status *st);
void pen_store_close(struct pen_store *store);

/* Looks for damage, for at most limit_ms (0: no limit). *finished says whether everything was
 * checked.
 * Fails: PEN_STORAGE with the first damage found. */
bool pen_store_check(struct pen_store *store, int limit_ms, bool *finished, struct pen_status *st);

/* Returns true if a new job would be accepted now: the disk has space, the store is below
 * keep_bytes, and a write reaches the disk.
 * Fails: as pen_store_submit.
 * Cost: a synced write. */
bool pen_store_intake(struct pen_store *store, struct pen_status *st);

/* Makes a handle use another clock, for tests. */
void pen_store_set_clock(struct pen_store *store, int64_t (*now_ms)(void *user), void *user);

/* Reads the store's clock.
 * Units: ms since 1970.
 * Fails: as any read. */
bool pen_store_now(struct pen_store *store, int64_t *now_ms, struct pen_status *st);

/* The effect of a failed call. */
enum pen_failure {
    PEN_FAILURE_REFUSED, /* no effect; the same call would be refused again */
    PEN_FAILURE_RETRY,   /* no effect; the same call may succeed later */
    PEN_FAILURE_UNKNOWN  /* full effect or none. A submit or a commit may be repeated: the store
                            recognises an effect that it had */
};

/* Returns true if a call on this handle failed by an I/O error or by damage of the database itself,
 * not of a single value. The process should end. *why (may be NULL) is the first such failure. */
bool pen_store_is_broken(const struct pen_store *store, struct pen_status *why);

/* Classifies the failure of the last call on this handle. `st` is the status that this call
 * filled. */
enum pen_failure pen_store_failure(const struct pen_store *store, const struct pen_status *st);

/* What the store keeps. Ended jobs beyond these limits are removed, the earliest end first.
 * Unfinished jobs are never removed. The limits are stored; 0 means no limit. */
struct pen_retention {
    int64_t keep_ms;    /* since the job's end */
    int64_t keep_bytes; /* used in its file, without log and reserve; a new job is accepted if its
                           expected results fit */
    int64_t keep_jobs;  /* the number of ended jobs */
};
bool pen_store_set_retention(struct pen_store *store, const struct pen_retention *retention,
                             struct pen_status *st);

/* Finds the next job that retention removes: the job with the earliest end. The caller makes its
 * statistics and deletes it. */
bool pen_store_expired(struct pen_store *store, char id[PEN_ID_BYTES], bool *found,
                       struct pen_status *st);

/* Does a part of the housekeeping, in a short transaction. It removes parts of removed jobs and of
 * unused objects, scenes without a job, and old keys, statistics and workers. It also gives free
 * space back to the file system. *more is false if there was nothing to do. One process at a time
 * calls it, and pauses between calls. */
bool pen_store_purge(struct pen_store *store, bool *more, struct pen_status *st);

struct pen_backup {
    const atomic_bool *stop; /* the call ends when it becomes true; NULL: never */
    int64_t jobs, bytes;     /* of the copy */
};

/* Copies a store to a file. The store may be in use. The copy is of one moment, and has everything
 * that was acknowledged before the call. It is written as FILE.part-new, checked, synced, and then
 * renamed. A symbolic link FILE is itself replaced. An unfinished copy that a killed process left
 * is overwritten.
 * Fails: PEN_TIMEOUT (stopped), PEN_CONFLICT (the file exists, and `replace` is false; or another
 * backup to it is being made). PEN_USAGE (the name is a folder, the store itself, or too long),
 * PEN_IO, PEN_STORAGE_FULL (the copy cannot be written). PEN_STORAGE (the store is damaged or
 * cannot be read), PEN_NOT_FOUND (no store), PEN_UNAVAILABLE, PEN_NO_MEMORY. A failed call leaves
 * no file.
 * Cost: reads every page, and the copy twice. */
bool pen_store_backup(const char *url, const char *file, bool replace, struct pen_backup *out,
                      struct pen_status *st);

/* Removes the unfinished copy that a killed process left of this backup. */
void pen_store_backup_remove_left(const char *file);

/* Returns a counter that grows when a process may have changed the store. It counts each change of
 * this process, and those changes of others that a thread in pen_store_wait has noticed.
 * Threads: any. */
uint32_t pen_store_changes(void);

/* Waits until the counter differs from *seen or the time is up, and sets *seen to its value.
 * Signals are only hints. So a caller reads the counter first and the store afterwards, and reads
 * the store from time to time without a signal too.
 * Threads: may run while another thread uses the handle; so may pen_store_wake. */
void pen_store_wait(struct pen_store *store, uint32_t *seen, int timeout_ms);

/* Raises the counters of all processes, which ends their waits. */
void pen_store_wake(struct pen_store *store);

/* Sets up signals between processes. A supervisor calls pen_store_signals_make once, before its
 * first child, with the number of processes. Each child names its slot by pen_store_signals_join
 * before it opens a store. Without signals, a wait looks at the store every 250 ms. */
bool pen_store_signals_make(int slots, struct pen_status *st);
void pen_store_signals_join(int slot);

#endif
