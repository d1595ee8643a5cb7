/* SPDX-License-Identifier: MIT */
/* Random numbers for property tests: splitmix64 (Steele, Lea, Flood, OOPSLA 2014). A test prints
 * its seed with its failures, and PEN_SEED in the environment repeats it. With PEN_CASES=all, tests
 * try all their cases, as `make check-all` does; `make check` tries a part. PEN_FEWER=10 makes
 * heavy tests try a tenth of them. Builds with sanitizers use that, because they look for undefined
 * behaviour, which needs no rare numbers. */
#ifndef TESTS_SUPPORT_RANDOM_H
#define TESTS_SUPPORT_RANDOM_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "math/vec3.h"

struct random {
    uint64_t state, seed;
};

/* PEN_SEED of the environment if it is set, else the given seed. */
static inline struct random random_begin(uint64_t seed)
{
    const char *given = getenv("PEN_SEED");
    seed = given ? strtoull(given, NULL, 0) : seed;
    return (struct random){seed, seed};
}

/* Returns true if all cases are asked for. */
static inline bool random_all(void)
{
    const char *cases = getenv("PEN_CASES");
    return cases && strcmp(cases, "all") == 0;
}

/* The divisor of the number of cases in heavy tests: PEN_FEWER of the environment, 1 if not set. */
static inline int random_fewer(void)
{
    const char *given = getenv("PEN_FEWER");
    int fewer = given ? atoi(given) : 1;
    return fewer > 1 ? fewer : 1;
}

/* Returns the number of cases to try, out of `count`. */
static inline int random_cases(int count)
{
    return (count + random_fewer() - 1) / random_fewer();
}

/* Returns the number of cases to try, out of `all`. `few` cases must still find the mutants of the
 * subject (tests/property/mutants.sh), or differ in more than their random numbers. */
static inline int random_some(int all, int few)
{
    return random_cases(random_all() ? all : few);
}

/* Returns the step from one n to the next, for tests that would try every n. */
static inline int random_stride(void)
{
    return 1 + (random_fewer() - 1) / 3;
}

static inline uint64_t random_bits(struct random *r)
{
    uint64_t z = (r->state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* Uniform in [0, 1). */
static inline double random_unit(struct random *r)
{
    return (double)(random_bits(r) >> 11) * 0x1p-53;
}

/* Uniform in [lo, hi). */
static inline double random_in(struct random *r, double lo, double hi)
{
    return lo + (hi - lo) * random_unit(r);
}

/* 0 ... count - 1. */
static inline uint32_t random_below(struct random *r, uint32_t count)
{
    return (uint32_t)(random_bits(r) % count);
}

/* Uniform in the cube of that half-width. */
static inline struct pen_vec3 random_vec(struct random *r, double half)
{
    double x = random_in(r, -half, half), y = random_in(r, -half, half);
    return pen_vec3(x, y, random_in(r, -half, half));
}

/* Uniform on the unit sphere. */
static inline struct pen_vec3 random_direction(struct random *r)
{
    for (;;) {
        struct pen_vec3 v = random_vec(r, 1);
        double square = pen_dot(v, v);
        if (square <= 1 && square > 0.01)
            return pen_normalize(v);
    }
}

/* x moved by n ulps. */
static inline double random_nudge(double x, int n)
{
    for (; n > 0; n--)
        x = nextafter(x, INFINITY);
    for (; n < 0; n++)
        x = nextafter(x, -INFINITY);
    return x;
}

#endif
