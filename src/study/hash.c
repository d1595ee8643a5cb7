/* SPDX-License-Identifier: MIT */
#include "study/hash.h"

#include <sodium.h>

uint64_t pen_audit_seed(const struct pen_film *film)
{
    const size_t values = 3 * (size_t)film->width * (size_t)film->height;
    unsigned char hash[crypto_hash_sha256_BYTES];
    uint64_t seed = 0;
    crypto_hash_sha256(hash, (const unsigned char *)film->rgb, values * sizeof *film->rgb);
    for (int i = 0; i < 8; i++)
        seed = seed << 8 | hash[i];
    return seed;
}

void pen_hash_text(const void *text, size_t bytes, char out[PEN_HASH_TEXT_BYTES])
{
    unsigned char hash[crypto_hash_sha256_BYTES];
    crypto_hash_sha256(hash, bytes ? text : (const void *)"", bytes);
    sodium_bin2hex(out, PEN_HASH_TEXT_BYTES, hash, sizeof hash);
}
