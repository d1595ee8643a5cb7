/* SPDX-License-Identifier: MIT */
/* The geometry once more, from its definitions, with more digits than the renderer: roots in 113
 * bits (oracle_quad.c), exact signs (oracle_exact.c), and roots in 400 bits to check the first
 * (oracle_mpfr.c). It takes no code from the renderer. Its arithmetic does not appear in this
 * header, so any compiler can build files that include it.
 *
 * Classes: BE(k). A decision (hit or miss) may differ from the exact decision only under one
 * condition. Moving the inputs by k units u = 2^-53 of their own size must change the exact
 * decision. This is decided by growing and shrinking the primitive by k u (size of primitive +
 * distance to it). */
#ifndef TESTS_PROPERTY_ORACLE_H
#define TESTS_PROPERTY_ORACLE_H

#include <stdbool.h>

#include "math/vec3.h"

/* A number to 106 bits: hi is the rounded number, lo the remainder. */
struct truth {
    double hi, lo;
};

/* Return |x - truth|: as a number; in units in the last place of the truth; in units of 2^-53 of
 * the truth. */
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

/* Returns +1: hit, -1: miss, 0: BE(k) allows both. */
int oracle_sphere_class(const struct oracle_round *b, struct oracle_ray ray, double k);
int oracle_tube_class(const struct oracle_round *b, struct oracle_ray ray, double k);
int oracle_cylinder_class(const struct oracle_round *b, struct oracle_ray ray, double k);

/* Return distances over r: between the ray's line and the sphere's centre or the infinite
 * cylinder's axis; from o to this centre or axis. */
double oracle_passing(const struct oracle_round *b, struct oracle_ray ray);
double oracle_distance(const struct oracle_round *b, struct oracle_ray ray);

/* A cone from q along a, of radius r[0] at q and r[1] at the height h (oracle_cone.c): crossings
 * and class as above, and the largest p.n of its points, n unit. */
struct oracle_cone {
    struct pen_vec3 q, a;
    double r[2], h;
};
void oracle_cone(const struct oracle_cone *b, struct oracle_ray ray, struct oracle_roots *out);
int oracle_cone_class(const struct oracle_cone *b, struct oracle_ray ray, double k);
double oracle_cone_reach(const struct oracle_cone *b, struct pen_vec3 n);

/* Returns the distance of o + t d from the surface of the sphere or the infinite cylinder, in u
 * (|f| + r + |t d|), f = o - c. */
double oracle_round_residual(const struct oracle_round *b, struct oracle_ray ray, double t);

/* Returns the other intersection of a ray that starts on the primitive by definition: -2 b / a for
 * a sphere or an infinite cylinder. Positive: inward. */
struct truth oracle_chord(const struct oracle_round *b, struct oracle_ray ray);

/* Finds the exit from a capped cylinder of a ray that starts on `part` by definition. Returns false
 * if the ray goes outward. */
bool oracle_way_out(const struct oracle_round *b, enum oracle_part part, struct oracle_ray ray,
                    struct truth *t, enum oracle_part *at);

/* Finds the same roots in 400 bits; returns false if MPFR was missing at build time. */
bool oracle_mpfr_roots(const struct oracle_round *b, struct oracle_ray ray,
                       struct oracle_roots *out);

/* Where the line meets the plane of three points; false if it is parallel. */
bool oracle_plane(const struct pen_vec3 v[3], struct oracle_ray ray, struct truth *t);

/* Where the line meets the plane through p across n. */
bool oracle_plane_at(struct pen_vec3 p, struct pen_vec3 n, struct oracle_ray ray, struct truth *t);

/* Returns the distance of o + t d from the plane of three points. It is relative, in u of the
 * farthest point's distance from o and of |t d|: t is exact if the points move by it. */
double oracle_flat_residual(const struct pen_vec3 v[3], struct oracle_ray ray, double t);

/* |cos| of the angle between the ray and the normal of the plane of three points. */
double oracle_flat_cosine(const struct pen_vec3 v[3], struct oracle_ray ray);

/* Returns true if o + t d is between the depths of the vertices, within k u of the depths. */
bool oracle_depth_between(const struct pen_vec3 *v, int count, struct oracle_ray ray, double t,
                          double k);

/* Returns the side of edge PQ on which the ray passes: the exact sign of det [d, P - o, Q - o]. */
int oracle_side(struct oracle_ray ray, struct pen_vec3 p, struct pen_vec3 q);

/* Returns how often the outline winds around the ray, exactly. *unsure: an edge is so near that
 * BE(k) allows another answer. */
int oracle_winding(const struct pen_vec3 *v, int count, struct oracle_ray ray, double k,
                   bool *unsure);

/* Returns true if the ray meets the closed box at some 0 <= t <= tmax, exactly; tmax may be
 * infinite. */
bool oracle_slab(struct pen_vec3 lo, struct pen_vec3 hi, struct oracle_ray ray, double tmax);

/* Returns the exact side of p at the plane through a, b, c: +1 if they run counter-clockwise as
 * seen from p, -1 behind, 0 in the plane. */
int oracle_above(struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 c, struct pen_vec3 p);

/* Finds the unit normal of three points, or of four points in a plane. Each component is within 4u
 * of the exact one. Returns false if they have exactly no area. */
bool oracle_normal(const struct pen_vec3 *v, int count, struct pen_vec3 *n);

/* Finds the unit vector along the cofactor matrix of these rows times n, as precise as
 * oracle_normal. Returns false if it is zero. */
bool oracle_moved_normal(const struct pen_vec3 row[3], struct pen_vec3 n, struct pen_vec3 *out);

/* Returns true if the three points are exactly on a line. */
bool oracle_collinear(struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 c);

#endif
