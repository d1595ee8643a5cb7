/* SPDX-License-Identifier: MIT */
/* Signals between the processes of one host that use a store: one eventfd a process, made by the
 * supervisor before its first child, so that they stay when children are started again. A signal
 * writes all of them. Without them (a command beside the daemon), a wait looks every quarter of a
 * second; threads of one process always reach each other.
 *
 * Threads: any. */
#ifndef PEN_STORE_INTERNAL_SIGNALS_H
#define PEN_STORE_INTERNAL_SIGNALS_H

#include <stdint.h>

/* As pen_store_changes, pen_store_wait and pen_store_wake. */
uint32_t pen_signals_count(void);
void pen_signals_wait(uint32_t *seen, int timeout_ms);
void pen_signals_wake(void);

#endif
