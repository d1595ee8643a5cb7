/* SPDX-License-Identifier: MIT */
#include "study/audit_seed.h"

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
