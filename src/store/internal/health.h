/* SPDX-License-Identifier: MIT */
/* The health of a store: what a call may do after something went wrong, and how a store gets well
 * without a restart. The state is shared by all handles of all processes (words of the page that
 * wake.h maps), since what one of them met holds for the others: for every kind of fault a count
 * of those met and the count up to which they are mended. It is ill while the two differ.
 *
 *   no room   submits are refused (507); what finishes, cancels or deletes jobs is tried. Mended
 *             once about a MiB could be written.
 *   I/O       every handle is closed, without writing, before its next use: a failed fsync is
 *             never asked for again on the descriptor that it failed on (rule R7 of the farm
 *             notes). Writes are refused (503; 507 if the cause was a full disk), reads are tried
 *             on the reopened handle. Mended once the store was reopened, a trial write is synced
 *             and a check of the whole file finds nothing.
 *   damage    reads are refused as well: what is damaged is not served. Mended once a check of the
 *             whole file finds nothing and a trial write is synced.
 *
 * Who needs what is refused tries to mend first: one handle at a time (a lock on the file of the
 * page), at once after the fault, then not before half a second, or four times what the last try
 * took, has passed; a try that ended for want of memory, and soon, is not waited for. So nothing
 * has to be restarted, and an ill store of many gigabytes is not read all the time. A worker asks
 * at least once a second, and so recovery needs no other caller.
 *
 * What a call that failed has done: nothing; or, where its fsync failed and all processes die
 * before the store is mended, perhaps all (the log may hold it, and a recovery finds it there).
 * Commits may be repeated; submits are by their key.
 *
 * Covered by tests, below SQLite for every n-th call (tests/store/test_faults.c) and under a
 * running daemon (tests/faults): no room, short writes, EIO on read, write, truncate, shared memory
 * and open, failed fsync, once, every n-th or until healed; loss of what was not synced at any
 * write; a tmpfs that is really full. Damage of any page, header, length or log, found at the start
 * or in use, and a file that is moved away or replaced while it is in use:
 * tests/store/test_damage.c.
 *
 * Not covered: a disk that says it has synced and has not; a file system that loses a name that
 * was synced; bytes that change inside a text or a number (SQLite has no checksums of pages;
 * scenes, pixels and pictures carry one of their own, and are refused when read); SIGBUS from a
 * mapped page that the file system cannot provide; a disk that hangs without an error: calls hang
 * with it. */
#ifndef PEN_STORE_INTERNAL_HEALTH_H
#define PEN_STORE_INTERNAL_HEALTH_H

#include "store/internal/policy.h"

enum pen_need {
    PEN_NEED_CHECK, /* looks for damage: never refused for it */
    PEN_NEED_READ,
    PEN_NEED_WRITE,
    PEN_NEED_SPACE /* takes on new work */
};

/* For a handle just opened. */
void pen_health_begin(struct pen_store *store);

/* Before a call of the engine: mends or refuses. A call within a call always may go on.
 * Fails: PEN_STORAGE, PEN_STORAGE_FULL, and what reopening fails with; then there must be no
 * pen_health_exit. */
bool pen_health_enter(struct pen_store *store, enum pen_need need, struct pen_status *st);

/* A check has found nothing: whoever needs it may try to mend at once. */
void pen_health_found_whole(struct pen_store *store);

/* After it: takes note of the faults that it met. Returns whether this was the outermost call. */
bool pen_health_exit(struct pen_store *store);

#endif
