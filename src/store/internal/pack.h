/* SPDX-License-Identifier: MIT */
/* How scene documents and pixels are stored: zstd frames that carry their size and a checksum.
 * Pixels are rearranged first, so that bytes that resemble each other stand together. */
#ifndef PEN_STORE_INTERNAL_PACK_H
#define PEN_STORE_INTERNAL_PACK_H

#include <stddef.h>
#include <stdint.h>

#include "store/pixels.h"

struct pen_packer;

/* What a call gives back. Owns: the callee's memory, valid until its next call. */
struct pen_packed {
    const void *data;
    size_t bytes;
};

/* level: of zstd. Owns: free with pen_packer_free. Fails: NULL when out of memory. */
struct pen_packer *pen_packer_new(int level);
void pen_packer_free(struct pen_packer *packer);

/* Packs bytes. Fails: PEN_NO_MEMORY. */
bool pen_packer_pack(struct pen_packer *packer, const void *data, size_t bytes,
                     struct pen_packed *out, struct pen_status *st);

/* Unpacks. Fails: PEN_STORAGE (damaged), PEN_NO_MEMORY. */
bool pen_unpack(struct pen_packer *packer, const void *data, size_t bytes, struct pen_packed *out,
                struct pen_status *st);

/* sum.c: of bytes that carry none of their own. Tells damage, not malice: any change within eight
 * bytes, and of the length, and others but for one in 2^64. Cost: as reading them. */
int64_t pen_sum_of(const void *data, size_t bytes);

/* pixels.c: what has been added, as it is stored. Valid until more is added. */
struct pen_packed pen_pixels_packed(const struct pen_pixels *pixels);

/* Unpacks stored pixels, of which there must be `count`, into rgb. Fails: PEN_STORAGE (damaged, or
 * of a form that is not known), PEN_NO_MEMORY. */
bool pen_pixels_unpack(struct pen_packer *packer, const struct pen_packed *in, float *rgb,
                       int64_t count, struct pen_status *st);

#endif
