/* SPDX-License-Identifier: MIT */
/* Where a primitive is in an image: a convex polygon around its projection, in pixels from the top
 * left corner. A pinhole sees the primitive in the polygon alone. With a lens the polygon is a
 * rectangle, which moves with the point of the lens: see pen_shear. */
#ifndef PEN_RENDER_INTERNAL_PROJECTION_H
#define PEN_RENDER_INTERNAL_PROJECTION_H

#include "shade/kernel.h"

enum { PEN_HULL_MAX = 128 };

/* A convex polygon, its corners in order. */
struct pen_hull {
    int count;
    struct pen_point2 p[PEN_HULL_MAX + 4]; /* each side of a pixel may add a corner */
};

/* By how much the rectangle moves, in pixels, for each unit of the lens's coordinates. */
struct pen_shear {
    double x, y;
};

/* Sets the polygon of a finite primitive. False if some of it is not before the eye: then it may be
 * anywhere. */
bool pen_project(const struct pen_kernel_input *input, uint32_t prim, struct pen_hull *hull,
                 struct pen_shear *shear);

/* The same of a sphere. */
bool pen_project_sphere(const struct pen_kernel_input *input, const struct pen_sphere *sphere,
                        struct pen_hull *hull, struct pen_shear *shear);

/* The same of a box around `center`, which `half` goes to the middles of its sides from. */
bool pen_project_box(const struct pen_kernel_input *input, struct pen_vec3 center,
                     const struct pen_vec3 half[3], struct pen_hull *hull, struct pen_shear *shear);

/* The part of a polygon between lo and hi along x, or y. */
void pen_hull_clip(const struct pen_hull *hull, bool along_y, double lo, double hi,
                   struct pen_hull *part);

/* The least and largest coordinates of a polygon that has corners. */
struct pen_point2 pen_hull_least(const struct pen_hull *hull);
struct pen_point2 pen_hull_largest(const struct pen_hull *hull);

double pen_hull_area(const struct pen_hull *hull);

#endif
