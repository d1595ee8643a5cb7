/* SPDX-License-Identifier: MIT */
/* Counts the box and primitive tests of one thread. The thread's kernels get the counter's input
 * instead of the shared one. */
#ifndef PEN_RENDER_INTERNAL_COUNTER_H
#define PEN_RENDER_INTERNAL_COUNTER_H

#include "shade/kernel.h"

struct pen_counter;

/* Makes a counter.
 * Owns: free with pen_counter_free; borrows everything that `input` borrows.
 * Fails: NULL when out of memory. */
struct pen_counter *pen_counter_new(const struct pen_kernel_input *input);
void pen_counter_free(struct pen_counter *counter);

/* The input for the thread's kernels.
 * Owns: it belongs to the counter. */
const struct pen_kernel_input *pen_counter_input(const struct pen_counter *counter);

/* Adds the counts to *sum. */
void pen_counter_add(const struct pen_counter *counter, struct pen_test_counts *sum);

#endif
