/* SPDX-License-Identifier: MIT */
/* The memory use of this process, as the kernel counts it. */
#ifndef PEN_BASE_MEMORY_H
#define PEN_BASE_MEMORY_H

#include <stdint.h>

/* Starts a new measurement of the peak. If the kernel does not allow that, the peak remains the one
 * since the process began, which is an upper bound. */
void pen_memory_peak_reset(void);

/* The peak of the resident memory since the last reset.
 * Units: bytes. Fails: 0 if the kernel does not state it. */
int64_t pen_memory_peak_bytes(void);

#endif
