/* SPDX-License-Identifier: MIT */
/* Generators: random numbers aimed at where tests fail. Random rays prove little: every flat test
 * that leaks at the edges which G1 and G5 aim at leaks nowhere else.
 *
 * Every drawn number is kept in the case, and the frame makes cases smaller, so generators do not
 * shrink. Rows of leaving do G7 (rays that start on a primitive, from an earlier hit). The frame
 * does G10 (mutations of stored cases). */
#ifndef TESTS_PROPERTY_GEN_H
#define TESTS_PROPERTY_GEN_H

#include "support/random.h"

/* G1: moves a point by 0, 1, 2 or 64 ulp per axis, often by none. Zeros stay, because subnormals
 * are next to them, where products vanish and signs are not exact. */
struct pen_vec3 gen_nudged(struct random *r, struct pen_vec3 p);

/* A point of the edge from a to b: its beginning, somewhere, exactly so if the ends allow (a
 * multiple of 1/16 of the way), or nudged. */
struct pen_vec3 gen_on_edge(struct random *r, struct pen_vec3 a, struct pen_vec3 b);

/* G2: makes a direction from o to a target: as computed, of unit length, or scaled by 2^-40 ...
 * 2^40. */
struct pen_vec3 gen_toward(struct random *r, struct pen_vec3 o, struct pen_vec3 to);

/* G3: draws how a ray passes a primitive, as closest approach over radius: 1 +- 10^-k, k = 1 ...
 * 16, or a value from 0 to 1.1. */
double gen_passing(struct random *r);

/* G3: makes a ray that starts `far` radii from c and passes c at about `passing` radii. */
void gen_grazing(struct random *r, struct pen_vec3 c, double radius, double far, double passing,
                 struct pen_vec3 *o, struct pen_vec3 *d);

/* G4: a unit vector at 10^-k rad to a, k in [0, most]. */
struct pen_vec3 gen_near_parallel(struct random *r, struct pen_vec3 a, double most);

/* G5: draws a multiple of 1/16 in [-half, half]; draws such a point. */
double gen_dyadic(struct random *r, int half);
struct pen_vec3 gen_dyadic3(struct random *r, int half);

/* G6: draws coordinates whose exponents are uniform in [-most, most]. */
double gen_wide(struct random *r, int most);
struct pen_vec3 gen_wide3(struct random *r, int most);

/* G8: draws a direction along an axis or a diagonal, with zeros of both signs, never all zero. */
struct pen_vec3 gen_axial(struct random *r);

/* G9: a translation by 0, 1e3, 1e6 or 1e9, in a direction that is not an axis. */
double gen_offset(struct random *r);
struct pen_vec3 gen_offset3(double size);

/* 10 to a power uniform in [lo, hi]. */
double gen_power(struct random *r, double lo, double hi);

/* Two unit vectors that make a right-handed frame with n (unit). */
void gen_frame(struct random *r, struct pen_vec3 n, struct pen_vec3 *x, struct pen_vec3 *y);

#endif
