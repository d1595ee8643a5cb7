/* SPDX-License-Identifier: MIT */
/* The seed of an audit depends on every bit of the picture. */
#include <string.h>

#include "study/hash.h"
#include "support/suite.h"

/* The output of sha256sum for "abc" sixteen times begins with these digits. */
START_TEST(test_hash__seeds_of_audits_are_the_first_64_bits_of_sha_256)
{
    float rgb[12];
    const struct pen_film film = {2, 2, rgb};
    for (size_t i = 0; i < sizeof rgb; i += 3)
        memcpy((char *)rgb + i, "abc", 3);
    ck_assert(pen_audit_seed(&film) == UINT64_C(0x64e5925b57a6618d));
}
END_TEST

START_TEST(test_hash__every_bit_of_a_picture_counts)
{
    unsigned char bytes[27 * sizeof(float)] = {0};
    float rgb[27];
    memcpy(rgb, bytes, sizeof rgb);
    const struct pen_film film = {3, 3, rgb};
    const uint64_t black = pen_audit_seed(&film);
    for (size_t bit = 0; bit < 8 * sizeof bytes; bit++) {
        bytes[bit / 8] ^= (unsigned char)(1U << bit % 8);
        memcpy(rgb, bytes, sizeof rgb);
        ck_assert_msg(pen_audit_seed(&film) != black, "bit %zu", bit);
        bytes[bit / 8] ^= (unsigned char)(1U << bit % 8);
    }
}
END_TEST

PEN_SUITE("hash", test_hash__seeds_of_audits_are_the_first_64_bits_of_sha_256,
          test_hash__every_bit_of_a_picture_counts)
