/* SPDX-License-Identifier: MIT */
/* The health of a store: which calls are refused after a fault, and how the store recovers without
 * a restart.
 *
 * The state is shared by all handles of all processes, in words that the driver maps (SQLite: the
 * page of wake.h). For each kind of fault there is a count of faults met, and the count up to which
 * the store has recovered. A fault lasts while the two differ.
 *
 *   fault      refused until recovery                    recovered when
 *   no space   submits (507). Calls that cancel or       the log can be copied, a trial write
 *              delete jobs are tried, with the reserve   is synced, the reserve is there again,
 *              of the disk if it must be. Calls that     and a MiB is free, or what a result that
 *              store results are tried until the         was refused needs (pen_health_want).
 *              reserve is given up for those.
 *   I/O        writes (503, or 507 if the cause was a    the store was reopened, a trial write is
 *              full disk). Reads are tried on a          synced, and a check of the whole file
 *              reopened handle.                          finds nothing.
 *   damage     reads and writes.                         a check of the whole file finds nothing,
 *                                                        and a trial write is synced.
 *
 * After an I/O fault or damage every handle is closed, without writing, before its next use. A
 * failed fsync is never repeated on the descriptor on which it failed: the kernel may have dropped
 * the pages and report success (Rebello et al., "Can applications recover from fsync failures?",
 * USENIX ATC 2020).
 *
 * Recovery
 *  1. A call that would be refused first tries to recover the store.
 *  2. One handle does so at a time (the driver's repair_lock).
 *  3. The first try comes at once after the fault. Further tries wait half a second (damage: five
 *     seconds), or four times as long as the last try took, at most a minute. So a faulty store of
 *     many gigabytes is not read all the time.
 *  4. A short try that failed for lack of memory delays nothing.
 *  5. Every worker calls the store at least once a second, so recovery needs no other caller.
 *
 * A failed call has done nothing, with one exception: if its fsync failed and all processes die
 * before the store has recovered, SQLite may find the transaction in the log. pen_store_failure
 * then returned PEN_FAILURE_UNKNOWN. Commits are repeated by claim, submits by id or key.
 *
 * Covered by tests, below SQLite for every n-th call (tests/store/test_faults.c) and under a
 * running daemon (tests/faults): no space, short writes, EIO on read, write, truncate, shared
 * memory and open, failed fsync, once, every n-th time or until healed; loss of all that was not
 * synced, at any write; a tmpfs that is really full. tests/store/test_damage.c: damage of any page,
 * header, length or log, found at the start or in use, and a file that is moved away or replaced in
 * use.
 *
 * Not covered: a disk that reports a sync it has not made; a file system that loses a name that was
 * synced; bytes that change inside a text or a number (SQLite has no checksums of pages; scenes,
 * pixels and pictures carry their own and are refused when read); SIGBUS from a mapped page that
 * the file system cannot provide; a disk that hangs without an error: calls hang with it. */
#ifndef PEN_STORE_INTERNAL_HEALTH_H
#define PEN_STORE_INTERNAL_HEALTH_H

#include "store/internal/policy.h"

/* What a call needs; each includes those before it. */
enum pen_need {
    PEN_NEED_CHECK, /* the call looks for damage, and is never refused */
    PEN_NEED_READ,
    PEN_NEED_WRITE,
    PEN_NEED_GROW, /* the call stores results */
    PEN_NEED_SPACE /* the call accepts new work */
};

/* To be called for a handle that has just been opened. */
void pen_health_begin(struct pen_store *store);

/* Begins a call of the policy: recovers the store if necessary, or refuses the call. A call within
 * a call (from a caller's function) is never refused. Fails: PEN_STORAGE, PEN_STORAGE_FULL, and the
 * failures of the driver's reopen; pen_health_exit must not be called then. */
bool pen_health_enter(struct pen_store *store, enum pen_need need, struct pen_status *st);

/* Notes, within a call, that a result was refused because the disk has less free space than so many
 * bytes: a fault "no space", which lasts until the disk has them, or until no result was refused so
 * for two minutes. 0: the result no longer waits. */
void pen_health_want(struct pen_store *store, int64_t bytes);

/* Notes that a check has found nothing: the next recovery need not wait. */
void pen_health_check_passed(struct pen_store *store);

/* Ends the call and notes the faults that the driver met. Returns whether it was the outermost. */
bool pen_health_exit(struct pen_store *store);

#endif
