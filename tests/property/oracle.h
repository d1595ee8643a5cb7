/* SPDX-License-Identifier: MIT */
/* The geometry written down once more, from its definitions, in more digits than the renderer
 * has: roots in 113 bits (oracle_quad.c), signs exactly (oracle_exact.c), roots in 400 bits to
 * check the first (oracle_mpfr.c). Nothing here is taken from the code under test, and nothing of
 * what these files use crosses this header, so that any compiler can build what includes it.
 *
 * Classes. A decision (hit or miss) may differ from the exact one only if moving the inputs by
 * k units u = 2^-53 of their own size makes it the other one: BE(k). Here that is decided by
 * growing and shrinking the primitive by k u (size of primitive + distance to it). */
#ifndef TESTS_PROPERTY_ORACLE_H
#define TESTS_PROPERTY_ORACLE_H

#include <stdbool.h>

#include "math/vec3.h"

/* A number to 106 bits: hi is it rounded, lo what is left. */
struct truth {
    double hi, lo;
};

/* |x - truth|; in units in the last place of the truth; in units of 2^-53 of the truth. */
double truth_error(double x, struct truth t);
double truth_ulps(double x, struct truth t);
double truth_units(double x, struct truth t);

enum oracle_part { ORACLE_SIDE, ORACLE_BASE, ORACLE_TOP };

/* Where the line o + t d crosses a primitive, t[0] < t[1]. */
struct oracle_roots {
    int count;
    struct truth t[2];
    enum oracle_part part[2];
};

struct oracle_ray {
    struct pen_vec3 o, d;
};

struct oracle_round { /* a sphere has a = 0; an infinite cylinder has h = 0 */
    struct pen_vec3 c, a;
    double r, h;
};

/* The name of the arithmetic behind it, for the report. */
const char *oracle_arithmetic(void);

/* Intersections of a sphere, an infinite cylinder through c along a, a capped cylinder from c along
 * a.
 */
void oracle_sphere(const struct oracle_round *b, struct oracle_ray ray, struct oracle_roots *out);
void oracle_tube(const struct oracle_round *b, struct oracle_ray ray, struct oracle_roots *out);
void oracle_cylinder(const struct oracle_round *b, struct oracle_ray ray, struct oracle_roots *out);

/* +1: hit, -1: missed, 0: either may be said, by BE(k). */
int oracle_sphere_class(const struct oracle_round *b, struct oracle_ray ray, double k);
int oracle_tube_class(const struct oracle_round *b, struct oracle_ray ray, double k);
int oracle_cylinder_class(const struct oracle_round *b, struct oracle_ray ray, double k);

/* The distance between the ray's line and the sphere's centre or the infinite cylinder's axis, over
 * r; the distance from o to the centre or axis, over r. */
double oracle_passing(const struct oracle_round *b, struct oracle_ray ray);
double oracle_distance(const struct oracle_round *b, struct oracle_ray ray);

/* A cone from q along a, of radius r[0] there and r[1] at the height h (oracle_cone.c): crossings
 * and class as above; and the largest p.n of its points, n unit. */
struct oracle_cone {
    struct pen_vec3 q, a;
    double r[2], h;
};
void oracle_cone(const struct oracle_cone *b, struct oracle_ray ray, struct oracle_roots *out);
int oracle_cone_class(const struct oracle_cone *b, struct oracle_ray ray, double k);
double oracle_cone_reach(const struct oracle_cone *b, struct pen_vec3 n);

/* How far o + t d is from the sphere's or the infinite cylinder's surface, in u (|f| + r + |t d|),
 * f = o - c. */
double oracle_round_residual(const struct oracle_round *b, struct oracle_ray ray, double t);

/* The other intersection of a ray that starts on the primitive by decree: -2 b / a for a sphere or
 * an infinite cylinder. Positive: inward. */
struct truth oracle_chord(const struct oracle_round *b, struct oracle_ray ray);

/* The way out of a capped cylinder for a ray that starts on `part` by decree; false if it goes
 * outward. */
bool oracle_way_out(const struct oracle_round *b, enum oracle_part part, struct oracle_ray ray,
                    struct truth *t, enum oracle_part *at);

/* The same roots in 400 bits; false where MPFR was not there at build time. */
bool oracle_mpfr_roots(const struct oracle_round *b, struct oracle_ray ray,
                       struct oracle_roots *out);

/* Where the line meets the plane of three points; false if it is parallel. */
bool oracle_plane(const struct pen_vec3 v[3], struct oracle_ray ray, struct truth *t);

/* Where the line meets the plane through p across n. */
bool oracle_plane_at(struct pen_vec3 p, struct pen_vec3 n, struct oracle_ray ray, struct truth *t);

/* How far o + t d is from the plane of three points, in u of the farthest of them from o and of
 * |t d|: by how much the points must move, relatively, for t to be exact. */
double oracle_flat_residual(const struct pen_vec3 v[3], struct oracle_ray ray, double t);

/* |cos| of the angle between the ray and the normal of the plane of three points. */
double oracle_flat_cosine(const struct pen_vec3 v[3], struct oracle_ray ray);

/* Whether o + t d lies between the depths of the vertices, up to k u of the depths. */
bool oracle_depth_between(const struct pen_vec3 *v, int count, struct oracle_ray ray, double t,
                          double k);

/* On which side of edge PQ the ray passes: the sign of det [d, P - o, Q - o], exactly. */
int oracle_side(struct oracle_ray ray, struct pen_vec3 p, struct pen_vec3 q);

/* How often the outline winds around the ray, exactly; *unsure: whether some edge is so near that
 * BE(k) may decide otherwise. */
int oracle_winding(const struct pen_vec3 *v, int count, struct oracle_ray ray, double k,
                   bool *unsure);

/* Whether the ray meets the closed box at some 0 <= t <= tmax, exactly; tmax may be infinite. */
bool oracle_slab(struct pen_vec3 lo, struct pen_vec3 hi, struct oracle_ray ray, double tmax);

/* The side of the plane through a, b, c that p is on, exactly: +1 where they run counter-clockwise
 * as seen from p, -1 behind, 0 in the plane. */
int oracle_above(struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 c, struct pen_vec3 p);

/* The unit normal of three points, or of four in one plane, each component within 4u of the exact
 * one; false if they have no area, exactly. */
bool oracle_normal(const struct pen_vec3 *v, int count, struct pen_vec3 *n);

/* The unit vector along the cofactor matrix of these rows times n, as oracle_normal; false if it is
 * zero. */
bool oracle_moved_normal(const struct pen_vec3 row[3], struct pen_vec3 n, struct pen_vec3 *out);

/* Whether the three lie on one line, exactly. */
bool oracle_collinear(struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 c);

#endif
