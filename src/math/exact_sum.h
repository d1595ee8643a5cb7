/* SPDX-License-Identifier: MIT */
/* Sums of products of doubles without any rounding, for decisions made once while a scene is
 * loaded: whether points are on one line, whether a matrix can be inverted. A sum is a number in
 * fixed point. It covers the lowest to the highest bit of a product of three doubles. */
#ifndef PEN_MATH_EXACT_SUM_H
#define PEN_MATH_EXACT_SUM_H

#include <stdint.h>

#include "math/vec3.h"

/* Limbs have 32 bits each. They begin at 2^-3222, the lowest bit of a product of three subnormals.
 * Products of three doubles end below 2^3072, and the rest is space for carries. */
enum { PEN_EXACT_LIMBS = 200 };

/* A sum; all zero: the sum is 0. Up to 2^29 products may be added. */
struct pen_exact_sum {
    int64_t limb[PEN_EXACT_LIMBS]; /* carries are propagated when the sum is read */
};

/* Adds a b c, finite numbers. */
void pen_exact_add(struct pen_exact_sum *sum, double a, double b, double c);

/* The sign of the sum: -1, 0 or 1. */
int pen_exact_sign(struct pen_exact_sum *sum);

/* The sum within 1 ulp, as value * 2^exponent, 1/2 <= |value| < 1; 0 and 0 for zero. */
double pen_exact_value(struct pen_exact_sum *sum, int *exponent);

/* The vector of three sums times the power of two that brings its largest component into [1/2, 1);
 * zero if all sums are 0. Each component is within 1 ulp, unless it is below 2^-1022. */
struct pen_vec3 pen_exact_direction(struct pen_exact_sum sum[3]);

/* Newell's normal of a loop of finite points, as by pen_exact_direction. For three points it is the
 * direction of (v1 - v0) x (v2 - v0). It is zero if and only if the signed areas add up to exactly
 * zero. */
struct pen_vec3 pen_exact_normal(const struct pen_vec3 *v, uint32_t count);

/* The same. *low gets the rounding error of each component, within 1 ulp. Coordinates are in 2^-500
 * ... 2^500, or 0. */
struct pen_vec3 pen_exact_normal_low(const struct pen_vec3 *v, uint32_t count,
                                     struct pen_vec3 *low);

#endif
