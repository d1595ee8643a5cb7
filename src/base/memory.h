/* SPDX-License-Identifier: MIT */
/* The memory of this process, as the kernel counts it. */
#ifndef PEN_BASE_MEMORY_H
#define PEN_BASE_MEMORY_H

#include <stdint.h>

/* Begins a new measurement of the peak. Where the kernel does not allow that, the peak stays the
 * one since the process began, which is an upper bound. */
void pen_memory_peak_reset(void);

/* The peak of the resident memory since the last reset.
 * Units: bytes. Fails: 0 if the kernel tells nothing. */
int64_t pen_memory_peak_bytes(void);

#endif
