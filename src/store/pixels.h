/* SPDX-License-Identifier: MIT */
/* Encodes the pixels of a batch for the store. Encoding takes longer than storing, so the renderer
 * encodes finished pixels while it renders the others, and commits the result (the member `encoded`
 * of struct pen_result). The encoding is lossless: every float comes back bit for bit. */
#ifndef PEN_STORE_PIXELS_H
#define PEN_STORE_PIXELS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

struct pen_pixels;

/* Owns: free with pen_pixels_free. Fails: NULL when out of memory. */
struct pen_pixels *pen_pixels_new(void);
void pen_pixels_free(struct pen_pixels *pixels);

/* Forgets the pixels added so far, and keeps the memory for the next batch. */
void pen_pixels_begin(struct pen_pixels *pixels);

/* The pixels that are compressed together. A caller that adds fewer at a time gets more bytes. */
enum { PEN_PIXELS_SLICE = 65536 };

/* Adds the next `count` pixels of the batch.
 * Shape: rgb has 3 * count values. Fails: PEN_NO_MEMORY; then nothing more can be added until
 * pen_pixels_begin. Threads: one at a time. */
bool pen_pixels_add(struct pen_pixels *pixels, const float *rgb, int64_t count,
                    struct pen_status *st);

/* The number of pixels added since pen_pixels_begin. */
int64_t pen_pixels_count(const struct pen_pixels *pixels);

#endif
