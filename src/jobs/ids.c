/* SPDX-License-Identifier: MIT */
/* Ids and hashes, from libsodium. */
#include <sodium.h>
#include <stdio.h>
#include <string.h>

#include "jobs/internal/ids.h"

bool pen_ids_init(struct pen_status *st)
{
    return sodium_init() >= 0 || pen_fail(st, PEN_INTERNAL, "libsodium does not start");
}

void pen_id_make(int64_t wall_ms, char out[PEN_ID_BYTES])
{
    unsigned char b[16];
    randombytes_buf(b, sizeof b);
    for (int i = 0; i < 6; i++)
        b[i] = (unsigned char)(wall_ms >> (40 - 8 * i));
    b[6] = (unsigned char)(0x70 | (b[6] & 0x0f));
    b[8] = (unsigned char)(0x80 | (b[8] & 0x3f));
    snprintf(out, PEN_ID_BYTES,
             "%02x%02x%02x%02x-%02x%02x-%02x%02x-%02x%02x-%02x%02x%02x%02x%02x%02x", b[0], b[1],
             b[2], b[3], b[4], b[5], b[6], b[7], b[8], b[9], b[10], b[11], b[12], b[13], b[14],
             b[15]);
}

void pen_sha256(const void *data, size_t bytes, unsigned char out[PEN_SHA256_BYTES])
{
    crypto_hash_sha256(out, bytes ? data : (const void *)"", bytes);
}

void pen_etag_make(const void *data, size_t bytes, char out[PEN_ETAG_BYTES])
{
    unsigned char hash[24];
    crypto_generichash(hash, sizeof hash, bytes ? data : (const void *)"", bytes, NULL, 0);
    out[0] = '"';
    sodium_bin2hex(out + 1, 70, hash, sizeof hash);
    strcat(out, "\"");
}
