/* SPDX-License-Identifier: MIT */
/* The functions of math/sample.h in lanes: points of LANES consecutive indices. sample.c is their
 * instance with one lane.
 *
 * A hash of 64 bits gives the seeds of three Owen scramblings: of the order of the points, and of
 * both coordinates. The order must be shuffled if one path uses several sets. Otherwise point i of
 * one set and point i of another would lie in the same cells of their first coordinates.
 *
 * Owen scrambling flips each bit of a coordinate depending on the bits above it. In reversed bit
 * order, this is a function in which each bit depends only on itself and lower bits. Addition and
 * multiplication by an odd number are such functions, so a hash of such steps does it (Laine and
 * Karras, EGSR 2011; Burley, JCGT 9(4), 2020). The sequence of steps and constants used here:
 * Vegdahl, "Building a better LK hash", psychopath.io, 2021. */
#ifndef PEN_MATH_SAMPLE_LANES_H
#define PEN_MATH_SAMPLE_LANES_H

#include "math/lanes.h"
#include "math/sample.h"

#define LANES_GOLDEN UINT64_C(0x9E3779B97F4A7C15) /* 2^64 over the golden ratio */

struct lanes_point2 {
    lanes x, y;
};

/* The finalizer of SplitMix64: Steele, Lea, Flood, OOPSLA 2014. */
static inline lane_words lanes_mix(lane_words z)
{
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return z ^ z >> 31;
}

/* The middles of 2^32 cells of [0, 1): never 0, never 1. */
static inline lanes lanes_unit_interval(lane_words cell)
{
    return (lanes_of_small(cell) + 0.5) * 0x1p-32;
}

/* pen_random2 of index, index + 1 and so on. */
static inline struct lanes_point2 lanes_random2(uint64_t hash, uint32_t index)
{
    const lane_words number = index + lane_words_count() + 1;
    const lane_words bits = lanes_mix(hash + number * LANES_GOLDEN);
    return (struct lanes_point2){lanes_unit_interval(bits & UINT32_MAX),
                                 lanes_unit_interval(bits >> 32)};
}

static inline lane_halves lanes_reverse_bits(lane_halves x)
{
    x = x >> 16 | x << 16;
    x = (x >> 8 & 0x00FF00FF) | (x & 0x00FF00FF) << 8;
    x = (x >> 4 & 0x0F0F0F0F) | (x & 0x0F0F0F0F) << 4;
    x = (x >> 2 & 0x33333333) | (x & 0x33333333) << 2;
    return (x >> 1 & 0x55555555) | (x & 0x55555555) << 1;
}

/* Owen's scrambling of numbers with reversed bits, each with its seed. The results have reversed
 * bits too. */
static inline lane_halves lanes_scramble_reversed(lane_halves x, lane_halves seed)
{
    x ^= x * 0x3D20ADEAu;
    x += seed;
    x *= seed >> 16 | 1u;
    x ^= x * 0x05526C56u;
    return x ^ x * 0x53A22864u;
}

/* The bits of Sobol's second coordinate, reversed. His direction numbers are v_1 = 1/2, v_(j+1) =
 * v_j xor v_j / 2. Reversed and read as polynomials over GF(2), they are the powers of 1 + z. So
 * the coordinate of an index that is read as P(z) is P(1 + z). Since (1 + z)^16 = 1 + z^16 and so
 * on, it takes five steps. */
static inline lane_halves lanes_second_reversed(lane_halves x)
{
    x ^= x >> 16;
    x ^= x >> 8 & 0x00FF00FF;
    x ^= x >> 4 & 0x0F0F0F0F;
    x ^= x >> 2 & 0x33333333;
    return x ^ (x >> 1 & 0x55555555);
}

/* The seeds of the scramblings of a sequence: of its order, and of both coordinates. */
struct lanes_seeds {
    lane_halves order, x, y;
};

static inline struct lanes_point2 lanes_sobol2_of(struct lanes_seeds seed, lane_halves index)
{
    const lane_halves s =
        lanes_reverse_bits(lanes_scramble_reversed(lanes_reverse_bits(index), seed.order));
    const lane_halves x = lanes_scramble_reversed(s, seed.x);
    const lane_halves y = lanes_scramble_reversed(lanes_second_reversed(s), seed.y);
    return (struct lanes_point2){
        lanes_unit_interval(lane_words_of_halves(lanes_reverse_bits(x))),
        lanes_unit_interval(lane_words_of_halves(lanes_reverse_bits(y))),
    };
}

/* pen_sobol2 of index, index + 1 and so on. */
static inline struct lanes_point2 lanes_sobol2(uint64_t hash, uint32_t index)
{
    const lane_halves zero = lane_halves_count() - lane_halves_count();
    const struct lanes_seeds seed = {zero + (uint32_t)(hash * LANES_GOLDEN >> 32),
                                     zero + (uint32_t)hash, zero + (uint32_t)(hash >> 32)};
    return lanes_sobol2_of(seed, index + lane_halves_count());
}

/* pen_sobol2 with an index and a hash in each lane. */
static inline struct lanes_point2 lanes_sobol2_each(lane_words hash, lane_halves index)
{
    const struct lanes_seeds seed = {lane_halves_of_words(hash * LANES_GOLDEN >> 32),
                                     lane_halves_of_words(hash), lane_halves_of_words(hash >> 32)};
    return lanes_sobol2_of(seed, index);
}

/* pen_sample_hash in two steps, for keys with one seed that differ in their purpose. This is the
 * common step: pixel has y above x, sequence has the node above the pixel sample. The next function
 * adds a purpose, for light 0. */
static inline lane_words lanes_sample_hash(uint64_t seed, lane_words pixel, lane_words sequence)
{
    const lane_words h = lanes_mix((pen_mix64(seed) ^ pixel) + LANES_GOLDEN);
    return lanes_mix((h ^ sequence) + LANES_GOLDEN);
}

static inline lane_words lanes_sample_purpose(lane_words shared, uint32_t purpose)
{
    return lanes_mix((shared ^ purpose) + LANES_GOLDEN);
}

/* pen_disk_of_square, without its case for the square's centre, which lanes_unit_interval never
 * returns. Sine and cosine of at most an eighth of a turn are Taylor's series, within 3 ulp. They
 * need no reduction of the angle, which matters because every point on a light or a lens needs
 * them. */
static inline struct lanes_point2 lanes_disk_of_square(struct lanes_point2 p)
{
    const lanes a = 2 * p.x - 1, b = 2 * p.y - 1;
    const lane_mask wide = lanes_less(lanes_abs(b), lanes_abs(a));
    const lanes longer = lanes_select(wide, a, b), shorter = lanes_select(wide, b, a);
    const lanes angle = 0x1.921fb54442d18p-1 * (shorter / longer), z = angle * angle;
    lanes s = 1. / 6227020800 + z * (-1. / 1307674368000);
    s = 1. / 362880 + z * (-1. / 39916800 + z * s);
    s = -1. / 6 + z * (1. / 120 + z * (-1. / 5040 + z * s));
    lanes c = -1. / 87178291200 + z * (1. / 20922789888000);
    c = 1. / 40320 + z * (-1. / 3628800 + z * (1. / 479001600 + z * c));
    c = -0.5 + z * (1. / 24 + z * (-1. / 720 + z * c));
    const lanes sine = longer * (angle + angle * z * s), cosine = longer * (1 + z * c);
    return (struct lanes_point2){lanes_select(wide, cosine, sine),
                                 lanes_select(wide, sine, cosine)};
}

#endif
