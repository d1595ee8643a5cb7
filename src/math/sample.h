/* SPDX-License-Identifier: MIT */
/* Sampling. A sample is a pure function of its key. There is no generator state, so an effect that
 * a scene does not use changes no other samples. The key of a sample is (seed, x, y, pixel sample,
 * node in the path tree, purpose, light). Its value does not depend on tiles, threads or the number
 * of samples.
 * Source: Burley, "Practical hash-based Owen scrambling", JCGT 9(4), 2020; Sobol' direction numbers
 * of dimensions 1 and 2; Shirley & Chiu, "A low distortion map", JGT 2(3), 1997. */
#ifndef PEN_MATH_SAMPLE_H
#define PEN_MATH_SAMPLE_H

#include <stdbool.h>
#include <stdint.h>

enum pen_purpose {
    PEN_PURPOSE_PIXEL = 1, /* position in the pixel */
    PEN_PURPOSE_LENS = 2,
    PEN_PURPOSE_LIGHT = 3,
    PEN_PURPOSE_REFLECTION = 4,
    PEN_PURPOSE_TRANSMISSION = 5
};

/* The key of a set of samples. Keys must never change: another key changes every picture that uses
 * samples.
 *  - PEN_PURPOSE_PIXEL: point i is where camera ray i intersects the pixel; pixel_sample, node and
 *    light are 0.
 *  - PEN_PURPOSE_LENS: point i, by pen_sobol2 and pen_disk_of_square, is where camera ray i starts
 *    on the lens, along the camera's right and up; pixel_sample, node and light are 0.
 *  - PEN_PURPOSE_LIGHT: the points on the disk of one light as seen from one shaded point. They are
 *    those of pen_sobol2 or pen_random2 from 0 on, mapped to the disk by pen_disk_of_square. Or
 *    they are the cells of pen_grid2, row by row, whose point is in the circle, of the first
 *    drawing of the grid that has any. Here pixel_sample is the index of the camera ray that begins
 *    the path, node the shaded point's node, light the light's place in the document, from 0 on.
 *  - PEN_PURPOSE_REFLECTION, PEN_PURPOSE_TRANSMISSION: point i, by pen_sobol2 and
 *    pen_disk_of_square, is where blurred ray i from a surface intersects the cone (shade/blur.c).
 *    If that is beyond the horizon, it is the first of points 64 i to 64 i + 63 of pen_random2 that
 *    is not. Here pixel_sample is that of the camera ray, node the surface's.
 *
 * With a target error, the camera rays of a pixel are a sequence that can be continued. Then
 * pixel_sample is the same for all of them and for every purpose. The points of camera ray i follow
 * those of the rays before it in one sequence: with n points for each camera ray, those of ray i
 * are n i to n i + n - 1. An audit takes several such sequences, its replicates, each with its own
 * scramblings; pixel_sample distinguishes them.
 *
 * A key must contain nothing else: not the tile, the thread, the accelerator, the number of
 * samples. */
enum { PEN_SAMPLE_REPLICATE = 1 << 30 };

struct pen_sample_key {
    uint64_t seed;
    uint32_t x, y;         /* pixel, from the top left of the view */
    uint32_t pixel_sample; /* index of the camera ray within its pixel; 0 for PIXEL and LENS; for a
                              sequence, PEN_SAMPLE_REPLICATE + its number, which is 0 unless there
                              are several */
    uint32_t node;         /* of the path tree: pen_sample_node; 0 for PIXEL and LENS */
    uint32_t purpose;      /* enum pen_purpose */
    uint32_t light;        /* place of the light in the document, else 0 */
};

/* The nodes of the path tree. The camera ray's hit is 1; the hit of a transmitted ray from node k
 * is 2k, of a reflected one 2k + 1. From 2^32 on, a number is reduced by the CRC-32 polynomial, bit
 * by bit as it grows. The polynomial is primitive, so long paths do not share one number. */
static inline uint32_t pen_sample_node(uint32_t from, bool reflected)
{
    return (from << 1 | reflected) ^ (from >> 31 ? UINT32_C(0x04C11DB7) : 0);
}

/* The node that blurred ray `sample` from a node reaches. Sample 0 reaches the node of the ray that
 * is not blurred. */
static inline uint32_t pen_sample_blurred_node(uint32_t from, bool reflected, uint32_t sample)
{
    return pen_sample_node(from, reflected) ^ sample * UINT32_C(0x9E3779B9);
}

struct pen_point2 {
    double x, y; /* in [0, 1) */
};

/* 64 well-mixed bits of the whole key. */
uint64_t pen_sample_hash(const struct pen_sample_key *key);

/* Point `index` of the Owen-scrambled two-dimensional Sobol' sequence; `hash` seeds its scrambling.
 * Any prefix of 2^k points is a (0, k, 2)-net in base 2. */
struct pen_point2 pen_sobol2(uint64_t hash, uint32_t index);

/* Independent uniform points, for comparison with the other two patterns. */
struct pen_point2 pen_random2(uint64_t hash, uint32_t index);

/* The point of one cell of edge x edge, uniform in the cell. Cells count from 0, row by row; from
 * edge^2 on they belong to further drawings of the same grid. */
struct pen_point2 pen_grid2(uint64_t hash, uint32_t edge, uint32_t cell);

/* The concentric map from the unit square to the unit disk, which preserves areas. */
struct pen_point2 pen_disk_of_square(struct pen_point2 p);

/* A number whose bits look random, different for each n.
 * Source: SplitMix64: Steele, Lea and Flood, "Fast splittable pseudorandom number generators",
 * OOPSLA 2014. */
static inline uint64_t pen_mix64(uint64_t n)
{
    n += UINT64_C(0x9E3779B97F4A7C15);
    n = (n ^ n >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    n = (n ^ n >> 27) * UINT64_C(0x94D049BB133111EB);
    return n ^ n >> 31;
}

#endif
