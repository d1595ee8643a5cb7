/* SPDX-License-Identifier: MIT */
/* How scene documents and pixels are stored: zstd frames that carry their size and a checksum.
 * Pixels are rearranged first, so that bytes that resemble each other stand together. */
#ifndef PEN_STORE_INTERNAL_COMPRESS_H
#define PEN_STORE_INTERNAL_COMPRESS_H

#include <stddef.h>
#include <stdint.h>

#include "store/pixels.h"

struct pen_compressor;

/* What a call gives back. Owns: the callee's memory, valid until its next call. */
struct pen_bytes {
    const void *data;
    size_t bytes;
};

/* level: of zstd. Owns: free with pen_compressor_free. Fails: NULL when out of memory. */
struct pen_compressor *pen_compressor_new(int level);
void pen_compressor_free(struct pen_compressor *packer);

/* Packs bytes. Fails: PEN_NO_MEMORY. */
bool pen_compress(struct pen_compressor *packer, const void *data, size_t bytes,
                  struct pen_bytes *out, struct pen_status *st);

/* Unpacks. Fails: PEN_STORAGE (damaged), PEN_NO_MEMORY. */
bool pen_decompress(struct pen_compressor *packer, const void *data, size_t bytes,
                    struct pen_bytes *out, struct pen_status *st);

/* The sum of bytes that carry none of their own (checksum.c). It finds damage, not malice: every
 * change within eight bytes and of the length, and other changes except one in 2^64. Cost: that of
 * reading the bytes. */
int64_t pen_checksum(const void *data, size_t bytes);

/* pixels.c: what has been added, as it is stored. Valid until more is added. */
struct pen_bytes pen_pixels_encoded(const struct pen_pixels *pixels);

/* Unpacks stored pixels, of which there must be `count`, into rgb. Fails: PEN_STORAGE (damaged, or
 * of a form that is not known), PEN_NO_MEMORY. */
bool pen_pixels_decode(struct pen_compressor *packer, const struct pen_bytes *in, float *rgb,
                       int64_t count, struct pen_status *st);

#endif
