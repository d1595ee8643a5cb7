/* SPDX-License-Identifier: MIT */
/* The place of a primitive in an image: a convex polygon around its projection, in pixels from the
 * top left corner. A pinhole sees the primitive only inside the polygon. With a lens the polygon is
 * a rectangle that moves with the point of the lens: see pen_shear. */
#ifndef PEN_RENDER_INTERNAL_PROJECTION_H
#define PEN_RENDER_INTERNAL_PROJECTION_H

#include "shade/kernel.h"

enum { PEN_HULL_MAX = 128 };

/* A convex polygon with its corners in order. */
struct pen_hull {
    int count;
    struct pen_point2 p[PEN_HULL_MAX + 4]; /* each side of a pixel may add a corner */
};

/* The movement of the rectangle, in pixels per unit of the lens's coordinates. */
struct pen_shear {
    double x, y;
};

/* Sets the polygon of a finite primitive. Returns false if some of it is not in front of the eye:
 * then it may be anywhere. */
bool pen_project(const struct pen_kernel_input *input, uint32_t prim, struct pen_hull *hull,
                 struct pen_shear *shear);

/* The same for a sphere. */
bool pen_project_sphere(const struct pen_kernel_input *input, const struct pen_sphere *sphere,
                        struct pen_hull *hull, struct pen_shear *shear);

/* The same for a box around `center`; `half` are the vectors from there to the middles of its
 * sides. */
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
