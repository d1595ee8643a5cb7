/* SPDX-License-Identifier: MIT */
/* Large arrays, and the memory use of this process as the kernel counts it. */
#ifndef PEN_BASE_MEMORY_H
#define PEN_BASE_MEMORY_H

#include <stddef.h>
#include <stdint.h>

/* Allocates memory for an array that will be used whole, such as the pixels of a picture. From a
 * megabyte on it asks the kernel for huge pages. Otherwise the first access to each page of 4 KiB
 * is a fault, which takes some 0.2 us, and more than 10 us on a virtual machine whose own memory is
 * not backed yet.
 * Owns: the caller frees it with free().
 * Fails: NULL when out of memory. */
void *pen_memory_large(size_t bytes);
void *pen_memory_large_zeroed(size_t bytes); /* filled with zeros */

/* Starts a new measurement of the peak. If the kernel does not allow that, the peak remains the one
 * since the process began, which is an upper bound. */
void pen_memory_peak_reset(void);

/* The peak of the resident memory since the last reset.
 * Units: bytes.
 * Fails: 0 if the kernel does not report it. */
int64_t pen_memory_peak_bytes(void);

#endif
