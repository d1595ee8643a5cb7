/* SPDX-License-Identifier: MIT */
/* Whether double precision is enough for a view. Two numbers are measured:
 *  - The width of a pixel at the nearest primitive, in ulps: the distance of neighbouring doubles
 *    at the scene's largest coordinates. Coordinates, and numbers computed from them, have errors
 *    of about an ulp. With an offset of 1e12 an ulp is 1.2e-4.
 *  - The width of the narrowest primitive over its length. A thin closed body contains such a
 *    primitive: a side wall, or the body itself. */
#ifndef PEN_SCENE_PRECISION_H
#define PEN_SCENE_PRECISION_H

#include "scene/scene.h"

/* With fewer ulps per pixel than this, rounding may be visible. At 256, an edge that moves by half
 * an ulp in two axes changes its cover of a pixel by at most sqrt(2)/2 / 256. That is less than one
 * level of an 8-bit picture between black and white. With few samples per pixel, one sample may
 * still change sides, which is a larger error. */
#define PEN_PRECISION_ENOUGH 256.0

/* Down to this width relative to their length, closed rooms are dark inside and solids cast no
 * false shadows (row rooms_thin of the stability suite). Narrower bodies may leak light. */
#define PEN_PRECISION_THIN 0x1p-30

/* Measures of a view.
 * Units: scene units, except `resolution` and `thinness`. */
struct pen_scene_precision {
    double extent;          /* the longest side of the bounding box of the finite primitives */
    double coordinate_max;  /* the largest |x|, |y|, |z| of that box and of the eye */
    double ulp;             /* the distance of neighbouring doubles at coordinate_max */
    double pixel_footprint; /* the smaller of a pixel's width and height at the nearest primitive */
    double resolution;      /* pixel_footprint / ulp */
    double thinness;        /* the least width / length of a finite primitive; 1 if there is none */
    uint32_t thin_prim;     /* the number of the first such primitive, and its measures: */
    double thin_width, thin_length;
};

/* Measures a view for a picture size. The distance of a primitive from the eye is that of its
 * surface (sphere, plane, infinite cylinder) or of its bounding box. It is at least 1/1024 of the
 * primitive's size, because an eye may stand on a floor, or inside a bounding box, and see nothing
 * that near.
 * Fails: returns false if there are no primitives, or if a value is not finite or not above 0.
 * Cost: O(primitives), some nanoseconds each; nothing per ray. */
bool pen_scene_precision(const struct pen_scene *scene, int view, int width, int height,
                         struct pen_scene_precision *out);

/* Writes a warning with a remedy to `out` if the resolution is below PEN_PRECISION_ENOUGH. Returns
 * whether it is below. */
bool pen_precision_warning(const struct pen_scene_precision *precision, char *out, size_t bytes);

/* The same for a primitive narrower than PEN_PRECISION_THIN of its length: "is 1e-12 wide ...". */
bool pen_thinness_warning(const struct pen_scene_precision *precision, char *out, size_t bytes);

#endif
