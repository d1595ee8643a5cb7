/* SPDX-License-Identifier: MIT */
/* Mixes in one word of eight bytes at a time. Each step is invertible, so two inputs that differ in
 * one word end with different sums. The multiplier is that of Fibonacci hashing (Knuth, TAOCP 3,
 * 6.4). Words are read as little-endian, so that a store can be read on any machine. */
#include <endian.h>
#include <string.h>

#include "store/internal/compress.h"

static uint64_t mix(uint64_t sum, uint64_t word)
{
    sum = (sum ^ word) * UINT64_C(0x9E3779B97F4A7C15);
    return sum ^ sum >> 32;
}

static uint64_t word_at(const unsigned char *at, size_t bytes)
{
    uint64_t word = 0;
    memcpy(&word, at, bytes);
    return le64toh(word);
}

int64_t pen_checksum(const void *data, size_t bytes)
{
    const unsigned char *at = data;
    uint64_t sum = mix(0, bytes), left = bytes;
    int64_t out;
    for (; left >= 8; left -= 8, at += 8)
        sum = mix(sum, word_at(at, 8));
    if (left > 0)
        sum = mix(sum, word_at(at, left));
    memcpy(&out, &sum, sizeof out);
    return out;
}
