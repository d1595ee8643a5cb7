/* SPDX-License-Identifier: MIT */
/* Sampling: a pure function of its key, no generator state, so an effect that a scene does not
 * call for consumes nothing. The key of a sample is (seed, x, y, pixel sample, node in the path
 * tree, purpose, light); its value does not depend on tiles, threads or the number of samples.
 * Sources: Burley, "Practical hash-based Owen scrambling", JCGT 9(4), 2020; Sobol' direction
 * numbers of dimensions 1 and 2; Shirley & Chiu, "A low distortion map", JGT 2(3), 1997. */
#ifndef PEN_MATH_SAMPLE_H
#define PEN_MATH_SAMPLE_H

#include <stdint.h>

enum pen_purpose {
    PEN_PURPOSE_PIXEL = 1, /* position in the pixel */
    PEN_PURPOSE_LENS = 2,
    PEN_PURPOSE_LIGHT = 3,
    PEN_PURPOSE_REFLECTION = 4,
    PEN_PURPOSE_TRANSMISSION = 5
};

/* What a set of samples is for. `node` numbers the nodes of the path tree: the camera ray's hit
 * is 1, the hit of a transmitted ray from node k is 2k, of a reflected one 2k + 1. */
struct pen_sample_key {
    uint64_t seed;
    uint32_t x, y;         /* pixel */
    uint32_t pixel_sample; /* index of the camera ray within its pixel; 0 for PEN_PURPOSE_PIXEL */
    uint32_t node;
    uint32_t purpose; /* enum pen_purpose */
    uint32_t light;   /* index of the light, else 0 */
};

struct pen_point2 {
    double x, y; /* in [0, 1) */
};

/* 64 well-mixed bits of the whole key. */
uint64_t pen_sample_hash(const struct pen_sample_key *key);

/* Point `index` of the Owen-scrambled two-dimensional Sobol' sequence whose scrambling is drawn
 * from `hash`. Any prefix of 2^k points is a (0, k, 2)-net in base 2. */
struct pen_point2 pen_sobol2(uint64_t hash, uint32_t index);

/* Independent uniform points: the baseline that studies compare with. */
struct pen_point2 pen_random2(uint64_t hash, uint32_t index);

/* The concentric map from the unit square to the unit disk: keeps areas. */
struct pen_point2 pen_disk_of_square(struct pen_point2 p);

#endif
