/* SPDX-License-Identifier: MIT */
/* How scene documents and pixels are stored: zstd frames that carry their size and a checksum.
 * Pixels are rearranged first, so that bytes that resemble each other stand together. */
#ifndef PEN_STORE_PACK_H
#define PEN_STORE_PACK_H

#include <stddef.h>

#include "pen/base/status.h"

struct pen_packer;

/* What a call gives back. Owns: the packer's memory, valid until its next call. */
struct pen_packed {
    const void *data;
    size_t bytes;
};

/* Owns: free with pen_packer_free. Fails: NULL when out of memory. */
struct pen_packer *pen_packer_new(void);
void pen_packer_free(struct pen_packer *packer);

/* Packs bytes. Fails: PEN_NO_MEMORY. */
bool pen_packer_pack(struct pen_packer *packer, const void *data, size_t bytes,
                     struct pen_packed *out, struct pen_status *st);

/* Packs pixels of 3 values each. */
bool pen_pack_rgb(struct pen_packer *packer, const float *rgb, size_t pixels,
                  struct pen_packed *out, struct pen_status *st);

/* Unpacks; the result of pen_unpack_rgb is an array of float. Fails: PEN_STORAGE (damaged),
 * PEN_NO_MEMORY. */
bool pen_unpack(struct pen_packer *packer, const void *data, size_t bytes, struct pen_packed *out,
                struct pen_status *st);
bool pen_unpack_rgb(struct pen_packer *packer, const void *data, size_t bytes,
                    struct pen_packed *out, struct pen_status *st);

#endif
