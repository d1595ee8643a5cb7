/* SPDX-License-Identifier: MIT */
/* The hashes in tests/golden/hashes.txt, for all tests that compare films with them. */
#ifndef TESTS_SUPPORT_GOLDEN_H
#define TESTS_SUPPORT_GOLDEN_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "scene/scene.h"

/* FNV-1a with 64 bits: start with this value, and add the bytes of a number from the lowest on. */
#define GOLDEN_HASH_BEGIN UINT64_C(14695981039346656037)

static inline uint64_t golden_hash_add(uint64_t h, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        h = (h ^ (value >> (8 * i) & 0xFF)) * UINT64_C(1099511628211);
    return h;
}

/* The hash of a film's floats. */
static inline uint64_t golden_hash(const float *film, size_t count)
{
    uint64_t h = GOLDEN_HASH_BEGIN;
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &film[i], sizeof bits);
        h = golden_hash_add(h, bits, 4);
    }
    return h;
}

/* Reduces the size of the picture, but not its shape, and the number of samples, so that all scenes
 * together take seconds. */
static inline void golden_shrink(struct pen_settings *s)
{
    enum { LONGEST_EDGE = 96 };
    if (s->light_samples > 32)
        s->light_samples = 8;
    if (s->lens_samples > 32)
        s->lens_samples = 8;
    int longest = s->width > s->height ? s->width : s->height;
    if (longest <= LONGEST_EDGE)
        return;
    s->width = s->width * LONGEST_EDGE / longest;
    s->height = s->height * LONGEST_EDGE / longest;
    s->width += s->width == 0;
    s->height += s->height == 0;
}

#endif
