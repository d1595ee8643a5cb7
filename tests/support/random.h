/* SPDX-License-Identifier: MIT */
/* Random numbers for property tests: SplitMix64, so that a seed printed on failure repeats it. */
#ifndef TESTS_SUPPORT_RANDOM_H
#define TESTS_SUPPORT_RANDOM_H

#include <stdint.h>
#include <stdlib.h>

struct random {
    uint64_t seed, state;
};

/* The seed given, or that of the environment variable PEN_SEED. */
static inline struct random random_begin(uint64_t seed)
{
    const char *given = getenv("PEN_SEED");
    seed = given ? strtoull(given, NULL, 0) : seed;
    return (struct random){seed, seed};
}

static inline uint64_t random_bits(struct random *r)
{
    uint64_t z = r->state += UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return z ^ z >> 31;
}

/* 0 to count - 1. */
static inline uint32_t random_below(struct random *r, uint32_t count)
{
    return (uint32_t)((random_bits(r) >> 32) * count >> 32);
}

static inline double random_uniform(struct random *r, double lo, double hi)
{
    return lo + (hi - lo) * ((double)(random_bits(r) >> 11) * 0x1p-53);
}

#endif
