/* SPDX-License-Identifier: MIT */
/* Signals between processes that share a store on one host: two counters in a small file that all
 * of them map, and futexes to wait on. Nothing depends on a signal: where the file cannot be made
 * or mapped, a wait is a sleep. The same page has the words in which processes share the faults of
 * the store (store/internal/health.h), and the identity of the store that the file belongs to and
 * of its -shm file (meta.c); without the file every handle has its own. */
#ifndef PEN_STORE_SQLITE_WAKE_H
#define PEN_STORE_SQLITE_WAKE_H

#include <stdatomic.h>
#include <stdint.h>
#include <sys/stat.h>

#include "store/internal/driver.h"

struct pen_wake;

/* Opens the counters in `path`, making the file. Owns: free with pen_wake_close.
 * Fails: NULL when out of memory; a file that cannot be used is not a failure. */
struct pen_wake *pen_wake_open(const char *path);
void pen_wake_close(struct pen_wake *wake);

/* As pen_store_wait and pen_store_wake. */
void pen_wake_wait(struct pen_wake *wake, enum pen_signal signal, uint32_t *seen, int timeout_ms);
void pen_wake_all(struct pen_wake *wake, enum pen_signal signal);

/* The words of health.h, zero in a new file. */
_Atomic uint32_t *pen_wake_words(struct pen_wake *wake);

/* The identity of the store, "" in a new file; PEN_STORE_IDENTITY_BYTES are its own. Setting it
 * writes and syncs the file, if it is another one. */
char *pen_wake_identity(struct pen_wake *wake);
void pen_wake_set_identity(struct pen_wake *wake, const char *identity);

/* The file ending in -shm, through which the handles share what the log has. Noted is which one it
 * was when a handle was opened last; any file is that one while none is noted, as in a new file. */
void pen_wake_note_shm(struct pen_wake *wake, const struct stat *info);
bool pen_wake_is_shm(struct pen_wake *wake, const struct stat *info);

/* The sums of tally.c, zero in a new file. */
_Atomic uint64_t *pen_wake_tallies(struct pen_wake *wake);

/* Takes the lock on the file; returns false if another handle has it. *lock is for pen_wake_unlock.
 * Returns true without a lock if the file cannot be opened. */
bool pen_wake_try_lock(struct pen_wake *wake, int *lock);
void pen_wake_unlock(int lock);

/* Whether another handle, of any process, has the file open. */
bool pen_wake_has_others(struct pen_wake *wake);

/* Makes sure that no other handle, of any process, has the file open. The caller has the lock of
 * pen_wake_try_lock, which is also held while a handle is opened, and calls pen_wake_end_alone
 * before it gives that back. Returns true where there is no such file, and false if it was removed
 * or replaced while it was in use. */
bool pen_wake_be_alone(struct pen_wake *wake);
void pen_wake_end_alone(struct pen_wake *wake);

#endif
