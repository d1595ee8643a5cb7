/* SPDX-License-Identifier: MIT */
/* Ids, hashes and entity tags, from libsodium. */
#ifndef PEN_JOBS_INTERNAL_IDS_H
#define PEN_JOBS_INTERNAL_IDS_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "store/store.h"

enum { PEN_SHA256_BYTES = 32, PEN_ETAG_BYTES = 72 };

/* Starts libsodium; call it before the other functions.
 * Fails: PEN_INTERNAL. */
bool pen_ids_init(struct pen_status *st);

/* Makes a new UUIDv7 (RFC 9562): its first 48 bits are the time, the rest is random. */
void pen_id_make(int64_t wall_ms, char out[PEN_ID_BYTES]);

void pen_sha256(const void *data, size_t bytes, unsigned char out[PEN_SHA256_BYTES]);

/* Makes a strong entity tag, quoted: a hash of the bytes. */
void pen_etag_make(const void *data, size_t bytes, char out[PEN_ETAG_BYTES]);

#endif
