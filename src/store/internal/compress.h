/* SPDX-License-Identifier: MIT */
/* The stored form of scene documents and pixels: zstd frames that contain their size and a
 * checksum. Pixels are first rearranged, so that similar bytes are neighbours (pixels.c). */
#ifndef PEN_STORE_INTERNAL_COMPRESS_H
#define PEN_STORE_INTERNAL_COMPRESS_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct pen_compressor;

/* The bytes that a call returns.
 * Owns: they belong to the called object, and are valid until its next call. */
struct pen_bytes {
    const void *data;
    size_t bytes;
};

/* `level` is zstd's compression level.
 * Owns: free with pen_compressor_free.
 * Fails: NULL when out of memory.
 * Threads: one at a time. */
struct pen_compressor *pen_compressor_new(int level);
void pen_compressor_free(struct pen_compressor *compressor);

/* Compresses into one frame.
 * Fails: PEN_NO_MEMORY. */
bool pen_compress(struct pen_compressor *compressor, const void *data, size_t bytes,
                  struct pen_bytes *out, struct pen_status *st);

/* Decompresses one frame.
 * Fails: PEN_STORAGE (damaged), PEN_NO_MEMORY. */
bool pen_decompress(struct pen_compressor *compressor, const void *data, size_t bytes,
                    struct pen_bytes *out, struct pen_status *st);

/* Encodes pixels (pixels.c).
 * Owns: free with pen_pixels_free.
 * Fails: NULL when out of memory. */
struct pen_pixels;
struct pen_pixels *pen_pixels_new(void);
void pen_pixels_free(struct pen_pixels *pixels);

/* The number of pixels that are compressed together. */
enum { PEN_PIXELS_SLICE = 65536 };

/* Encodes the pixels of a batch into their stored form.
 * Shape: rgb has 3 * count values.
 * Owns: *out is valid until the next call.
 * Fails: PEN_NO_MEMORY. */
bool pen_pixels_encode(struct pen_pixels *pixels, const float *rgb, int64_t count,
                       struct pen_bytes *out, struct pen_status *st);

/* Decodes stored pixels into rgb.
 * Shape: rgb takes 3 * count values.
 * Fails: PEN_STORAGE (damaged, not `count` pixels, or of an unknown form), PEN_NO_MEMORY. */
bool pen_pixels_decode(struct pen_compressor *compressor, const struct pen_bytes *in, float *rgb,
                       int64_t count, struct pen_status *st);

#endif
