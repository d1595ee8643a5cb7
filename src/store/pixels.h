/* SPDX-License-Identifier: MIT */
/* Pixels of a batch on their way into the store. Packing them takes longer than storing them, so
 * whoever renders packs what is done while the rest is still being rendered, and commits the
 * packed bytes (struct pen_result). */
#ifndef PEN_STORE_PIXELS_H
#define PEN_STORE_PIXELS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

struct pen_pixels;

/* Owns: free with pen_pixels_free. Fails: NULL when out of memory. */
struct pen_pixels *pen_pixels_new(void);
void pen_pixels_free(struct pen_pixels *pixels);

/* Begins anew; memory is kept for what comes. */
void pen_pixels_begin(struct pen_pixels *pixels);

/* How many pixels are worth packing at once: fewer make more bytes. */
enum { PEN_PIXELS_SLICE = 65536 };

/* Adds the next pixels of the batch, 3 values each. Fails: PEN_NO_MEMORY; then nothing more can be
 * added until pen_pixels_begin. Threads: one at a time. */
bool pen_pixels_add(struct pen_pixels *pixels, const float *rgb, int64_t count,
                    struct pen_status *st);

/* Pixels added since pen_pixels_begin. */
int64_t pen_pixels_count(const struct pen_pixels *pixels);

#endif
