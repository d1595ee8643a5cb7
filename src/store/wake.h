/* SPDX-License-Identifier: MIT */
/* Wake-up hints between processes that share a store on one host: two counters in a small file
 * mapped by all of them, and futexes to wait on. Nothing depends on a hint: where the file cannot
 * be made or mapped, waiting is just sleeping. */
#ifndef PEN_STORE_WAKE_H
#define PEN_STORE_WAKE_H

#include <stdint.h>

#include "pen/store/store.h"

struct pen_wake;

/* Opens the counters in `path`, making the file. Owns: free with pen_wake_close.
 * Fails: NULL when out of memory; a file that cannot be used is not a failure. */
struct pen_wake *pen_wake_open(const char *path);
void pen_wake_close(struct pen_wake *wake);

/* As pen_store_wait and pen_store_wake. */
void pen_wake_wait(struct pen_wake *wake, enum pen_signal signal, uint32_t *seen, int timeout_ms);
void pen_wake_all(struct pen_wake *wake, enum pen_signal signal);

#endif
