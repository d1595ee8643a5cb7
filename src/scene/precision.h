/* SPDX-License-Identifier: MIT */
/* What a scene asks of doubles: how many of their steps, at its largest coordinates, one pixel
 * covers where the nearest primitive may be seen. Coordinates, and what is computed from them, are
 * off by about a step (numerics: an offset of 1e12 leaves steps of 1.2e-4). */
#ifndef PEN_SCENE_PRECISION_H
#define PEN_SCENE_PRECISION_H

#include "scene/scene.h"

/* Fewer steps to a pixel than this may show. An edge that moves by half a step in two axes covers
 * up to sqrt(2)/2 / 256 of a pixel more or less: less than a level of an 8-bit picture between
 * black and white, though with few samples one of them may flip, and count for more. */
#define PEN_PRECISION_ENOUGH 256.0

/* Units: those of the scene, but for `resolution`. */
struct pen_scene_precision {
    double extent;          /* the longest side of the box around the finite primitives */
    double coordinate_max;  /* the largest |x|, |y|, |z| of that box and of the eye */
    double ulp;             /* the distance of neighbouring doubles at coordinate_max */
    double pixel_footprint; /* width or height of a pixel, whichever is less, at the nearest
                               primitive */
    double resolution;      /* pixel_footprint / ulp */
};

/* Measures a view for a picture size. The distance of a primitive from the eye is that of its
 * surface (sphere, plane, infinite cylinder) or of its bounding box, but at least 1/1024 of its
 * size: an eye may touch a floor, or be inside a bounding box, and see nothing that near. Fails:
 * returns false if there are no primitives, or if a figure is no finite number above 0. Cost:
 * O(primitives), some nanoseconds each; nothing per ray. */
bool pen_scene_precision(const struct pen_scene *scene, int view, int width, int height,
                         struct pen_scene_precision *out);

/* If the resolution is below PEN_PRECISION_ENOUGH, writes a sentence that says so and what helps.
 * Returns whether it did. */
bool pen_precision_warning(const struct pen_scene_precision *precision, char *out, size_t bytes);

#endif
