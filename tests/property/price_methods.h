/* SPDX-License-Identifier: MIT */
/* The methods whose cost is measured. Each tests one ray against the same few primitives of a kind
 * and keeps the nearest. The file with the primitives is compiled twice: for the baseline and, as
 * price_avx2.c, with AVX2 and FMA. */
#ifndef TESTS_PROPERTY_PRICE_METHODS_H
#define TESTS_PROPERTY_PRICE_METHODS_H

#include "support/world.h"

enum { PRICE_PRIMS = 64, PRICE_RAYS = 64 };

#define PRICE_HEIGHT .5 /* of the cylinders */

/* A plain ray and plain primitives, in float. */
struct plain3 {
    float x, y, z;
};

/* The targets: the same primitives for the robust tests, in double and in float. */
struct price_set {
    struct world world[PEN_PRIM_KIND_COUNT];
    struct pen_vec3 triangle[PRICE_PRIMS][3], center[PRICE_PRIMS], axis[PRICE_PRIMS];
    struct plain3 triangle_f[PRICE_PRIMS][3], center_f[PRICE_PRIMS], axis_f[PRICE_PRIMS];
    double radius[PRICE_PRIMS];
    float radius_f[PRICE_PRIMS];
    struct pen_ray ray[PRICE_RAYS];
    /* Coordinate by coordinate, for tests of several primitives at a time. */
    _Alignas(32) double triangle_soa[9][PRICE_PRIMS], sphere_soa[4][PRICE_PRIMS];
    _Alignas(32) float triangle_soa_f[9][PRICE_PRIMS], sphere_soa_f[4][PRICE_PRIMS];
};

/* Returns the nearest t in front of the ray, or infinity. */
typedef double price_fn(const struct price_set *set, const struct pen_ray *ray);

struct price_method {
    const char *primitive, *name;
    price_fn *run;
};

/* Return the methods of a variant, one by one; NULL after the last. */
const struct price_method *price_method_base(int i);
const struct price_method *price_method_avx2(int i);

#endif
