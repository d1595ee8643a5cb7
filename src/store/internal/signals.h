/* SPDX-License-Identifier: MIT */
/* Signals between the processes of one supervisor, and between their threads. */
#ifndef PEN_STORE_INTERNAL_SIGNALS_H
#define PEN_STORE_INTERNAL_SIGNALS_H

#include <stdint.h>

/* As pen_store_wait and pen_store_wake. */
void pen_signals_wait(uint32_t *seen, int timeout_ms);
void pen_signals_raise(void);

#endif
