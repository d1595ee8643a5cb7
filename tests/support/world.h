/* SPDX-License-Identifier: MIT */
/* Primitives that a test makes one by one, and rays through them, without a scene. */
#ifndef TESTS_SUPPORT_WORLD_H
#define TESTS_SUPPORT_WORLD_H

#include "accel/accel.h"
#include "support/random.h"

enum { WORLD_MAX = 2048 };

/* Primitives in its own arrays. It is large, so tests keep it static. Primitives are numbered in
 * the order in which they are added. */
struct world {
    struct pen_prims prims;
    struct pen_prim_ref ref[WORLD_MAX];
    struct pen_sphere sphere[WORLD_MAX];
    struct pen_plane plane[WORLD_MAX];
    struct pen_triangle triangle[WORLD_MAX];
    struct pen_polygon polygon[WORLD_MAX];
    struct pen_infinite_cylinder infinite_cylinder[WORLD_MAX];
    struct pen_cylinder cylinder[WORLD_MAX];
    struct pen_cone cone[WORLD_MAX];
    struct pen_vec3 corner[8 * WORLD_MAX];
    uint32_t corners;
    struct pen_arena *arena; /* of polygons that are cut; lives as long as the program */
};

void world_clear(struct world *w);

/* Each adds one primitive and returns its number; they fail the test if the primitive cannot be
 * made. */
uint32_t world_sphere(struct world *w, struct pen_vec3 c, double r);
uint32_t world_plane(struct world *w, struct pen_vec3 point, struct pen_vec3 normal);
uint32_t world_triangle(struct world *w, struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 c);
uint32_t world_polygon(struct world *w, const struct pen_vec3 *v, uint32_t count);
uint32_t world_infinite_cylinder(struct world *w, struct pen_vec3 origin, struct pen_vec3 axis,
                                 double r);
uint32_t world_cylinder(struct world *w, struct pen_vec3 base, struct pen_vec3 axis, double r,
                        double h, bool caps);
uint32_t world_cone(struct world *w, struct pen_vec3 base, struct pen_vec3 axis,
                    const double radius[2], double h, bool caps); /* of the base, of the top */

/* Makes a world of 420 triangles that form a closed surface: a sphere of 16 x 14 patches whose
 * vertices have random radii of 1 to 6, as in pbrt's test of watertight triangles. */
void world_bumpy(struct world *w, struct random *random, struct pen_vec3 middle);

/* Adds a box of six polygons that face outwards. */
void world_box(struct world *w, struct pen_vec3 lo, struct pen_vec3 hi);

/* Adds `count` primitives of all kinds, with sizes up to `size`, in a cube of half-width 1. */
void world_random(struct world *w, struct random *random, uint32_t count, double size);

/* Adds polygons of that size with corners off their plane, also concave ones, in a cube of
 * half-width 1. */
void world_bent(struct world *w, struct random *random, uint32_t count, double size);

/* Makes a ray, and fails the test if that is impossible. */
struct pen_ray world_ray(struct pen_vec3 o, struct pen_vec3 d);

/* The origin surface of a ray that starts at a hit p, which was reached along v. */
struct pen_origin_surface world_origin_surface(const struct world *w, struct pen_hit hit,
                                               struct pen_vec3 p, struct pen_vec3 v, bool through);

/* Finds the first intersection after `after` with t <= tmax, by testing all primitives. prim is
 * PEN_NO_PRIM if there is none. */
struct pen_hit world_nearest(const struct world *w, const struct pen_ray *ray,
                             const struct pen_origin_surface *origin,
                             const struct pen_t_interval *interval);

/* Returns the number of intersections with 0 < t <= tmax. The first `room` of them are stored in
 * hit[], in order. */
int world_intersections(const struct world *w, const struct pen_ray *ray,
                        const struct pen_origin_surface *origin, double tmax, struct pen_hit *hit,
                        int room);

/* Returns the number of intersections with t > 0 of a ray that starts in free space. */
int world_count(const struct world *w, struct pen_vec3 o, struct pen_vec3 d);

#endif
