/* SPDX-License-Identifier: MIT */
/* Affine maps of space, 3x4 row-major: p' = M p + t. */
#ifndef PEN_MATH_TRANSFORM_H
#define PEN_MATH_TRANSFORM_H

#include <stdbool.h>

#include "math/vec3.h"

struct pen_transform {
    double m[3][4];
};

struct pen_transform pen_transform_identity(void);

/* The map that scales, then rotates about an axis (any length, not zero) by degrees, then
 * translates. */
struct pen_transform pen_transform_make(double scale, struct pen_vec3 axis, double degrees,
                                        struct pen_vec3 translate);

/* The map that applies `inner` first and `outer` after it. */
struct pen_transform pen_transform_compose(const struct pen_transform *outer,
                                           const struct pen_transform *inner);

/* Rotation of v about the axis through the origin, by the right-hand rule. */
struct pen_vec3 pen_rotate(struct pen_vec3 v, struct pen_vec3 axis, double degrees);

struct pen_vec3 pen_transform_point(const struct pen_transform *f, struct pen_vec3 p);
struct pen_vec3 pen_transform_vector(const struct pen_transform *f, struct pen_vec3 v);

/* A plane's normal, by the inverse transpose, up to a positive factor. So the outside is mapped to
 * the outside. Each component is within 1 ulp of the exact one. */
struct pen_vec3 pen_transform_normal(const struct pen_transform *f, struct pen_vec3 n);

/* The sign of the determinant of the linear part, exactly: -1 if the map mirrors, 0 if it flattens
 * space. All entries are finite. */
int pen_transform_orientation(const struct pen_transform *f);

/* Whether the columns have equal lengths and vanishing dot products within 1e-6 of the squared
 * length; then *scale = cbrt |det|. */
bool pen_transform_similarity(const struct pen_transform *f, double *scale);

/* Whether the linear part can be inverted: its entries are finite, and its determinant is not
 * exactly 0. A map that nearly flattens space can be inverted, because it moves points and normals
 * as exactly as any other map. The constructors of primitives test whether it puts points on one
 * line or one point. */
bool pen_transform_invertible(const struct pen_transform *f);

#endif
