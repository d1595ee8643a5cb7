/* SPDX-License-Identifier: MIT */
/* Sample points without state. A key is hashed to 64 bits, which give the seeds of three Owen
 * scramblings: of the order of the points, and of both coordinates. Shuffling the order matters
 * as soon as one path uses several sets: unshuffled, point i of one and point i of another would
 * lie in the same cells of their first coordinates.
 *
 * Owen scrambling flips each bit of a coordinate depending on the bits above it. Read backwards,
 * that is a function in which information flows only upwards, as it does in adding and in
 * multiplying by an odd number, and so a hash of such steps does it (Laine and Karras, EGSR 2011;
 * Burley, JCGT 9(4), 2020). The sequence of steps and constants used here: Vegdahl, "Building a
 * better LK hash", psychopath.io, 2021. */
#include "math/sample.h"

#include <math.h>

/* The finalizer of SplitMix64: Steele, Lea, Flood, OOPSLA 2014. */
static uint64_t mix(uint64_t z)
{
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return z ^ z >> 31;
}

static const uint64_t GOLDEN = UINT64_C(0x9E3779B97F4A7C15); /* 2^64 over the golden ratio */

static uint64_t pair(uint32_t low, uint32_t high)
{
    return (uint64_t)high << 32 | low;
}

uint64_t pen_sample_hash(const struct pen_sample_key *key)
{
    uint64_t h = mix(key->seed + GOLDEN);
    h = mix((h ^ pair(key->x, key->y)) + GOLDEN);
    h = mix((h ^ pair(key->pixel_sample, key->node)) + GOLDEN);
    return mix((h ^ pair(key->purpose, key->light)) + GOLDEN);
}

static uint32_t reverse_bits(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = (x >> 4 & 0x0F0F0F0F) | (x & 0x0F0F0F0F) << 4;
    x = (x >> 2 & 0x33333333) | (x & 0x33333333) << 2;
    return (x >> 1 & 0x55555555) | (x & 0x55555555) << 1;
}

/* Owen's scrambling of a number given and returned with its bits reversed. */
static uint32_t scramble_reversed(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3D20ADEAu;
    x += seed;
    x *= seed >> 16 | 1u;
    x ^= x * 0x05526C56u;
    return x ^ x * 0x53A22864u;
}

/* The bits of Sobol's second coordinate, reversed. His direction numbers are v_1 = 1/2,
 * v_(j+1) = v_j xor v_j / 2; reversed and read as polynomials over GF(2) they are the powers of
 * 1 + z. So the coordinate of an index read as P(z) is P(1 + z), and since
 * (1 + z)^16 = 1 + z^16 and so on, that takes five steps. */
static uint32_t second_reversed(uint32_t index)
{
    uint32_t p = index;
    p ^= p >> 16;
    p ^= p >> 8 & 0x00FF00FF;
    p ^= p >> 4 & 0x0F0F0F0F;
    p ^= p >> 2 & 0x33333333;
    return p ^ (p >> 1 & 0x55555555);
}

/* The middle of one of 2^32 cells: never 0, never 1. */
static double unit_interval(uint32_t cell)
{
    return ((double)cell + 0.5) * 0x1p-32;
}

struct pen_point2 pen_sobol2(uint64_t hash, uint32_t index)
{
    uint32_t order_seed = (uint32_t)(hash * GOLDEN >> 32);
    uint32_t shuffled = reverse_bits(scramble_reversed(reverse_bits(index), order_seed));
    uint32_t x = scramble_reversed(shuffled, (uint32_t)hash);
    uint32_t y = scramble_reversed(second_reversed(shuffled), (uint32_t)(hash >> 32));
    return (struct pen_point2){unit_interval(reverse_bits(x)), unit_interval(reverse_bits(y))};
}

struct pen_point2 pen_random2(uint64_t hash, uint32_t index)
{
    uint64_t bits = mix(hash + ((uint64_t)index + 1) * GOLDEN);
    return (struct pen_point2){unit_interval((uint32_t)bits),
                               unit_interval((uint32_t)(bits >> 32))};
}

struct pen_point2 pen_grid2(uint64_t hash, uint32_t edge, uint32_t cell)
{
    struct pen_point2 within = pen_random2(hash, cell);
    return (struct pen_point2){(cell % edge + within.x) / edge,
                               (cell / edge % edge + within.y) / edge};
}

/* Sine and cosine of t pi/4, |t| <= 1, by Taylor's series: within 3 ulp, and without a reduction
 * of the angle, since this is called for every point on a light or a lens. */
static void eighth_turn(double t, double *sine, double *cosine)
{
    double a = 0x1.921fb54442d18p-1 * t, z = a * a;
    double s = 1. / 6227020800 + z * (-1. / 1307674368000);
    s = 1. / 362880 + z * (-1. / 39916800 + z * s);
    s = -1. / 6 + z * (1. / 120 + z * (-1. / 5040 + z * s));
    double c = -1. / 87178291200 + z * (1. / 20922789888000);
    c = 1. / 40320 + z * (-1. / 3628800 + z * (1. / 479001600 + z * c));
    c = -0.5 + z * (1. / 24 + z * (-1. / 720 + z * c));
    *sine = a + a * z * s;
    *cosine = 1 + z * c;
}

struct pen_point2 pen_disk_of_square(struct pen_point2 p)
{
    double a = 2 * p.x - 1, b = 2 * p.y - 1, sine, cosine;
    if (fabs(a) > fabs(b)) {
        eighth_turn(b / a, &sine, &cosine);
        return (struct pen_point2){a * cosine, a * sine};
    }
    if (b == 0)
        return (struct pen_point2){0, 0};
    eighth_turn(a / b, &sine, &cosine);
    return (struct pen_point2){b * sine, b * cosine};
}
