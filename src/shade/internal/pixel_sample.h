/* SPDX-License-Identifier: MIT */
/* The samples of a pixel: where they are, their camera rays, and which values the film holds. */
#ifndef PEN_SHADE_INTERNAL_PIXEL_SAMPLE_H
#define PEN_SHADE_INTERNAL_PIXEL_SAMPLE_H

#include <float.h>

#include "shade/internal/surface.h"

/* Point i of a pixel's samples: the centre if it has one sample only. */
static ALWAYS_INLINE struct pen_point2 pixel_point(uint64_t hash, int i, int samples)
{
    return samples > 1 ? pen_sobol2(hash, (uint32_t)i) : (struct pen_point2){0.5, 0.5};
}

/* The camera ray through a point of the image. */
static ALWAYS_INLINE bool camera_ray(const struct pen_pinhole *pinhole, struct pen_point2 at,
                                     struct pen_ray *ray)
{
    struct pen_vec3 d = pen_along(pinhole->middle, pinhole->dx, at.x - pinhole->half_width);
    return pen_ray_make(ray, pinhole->eye, pen_along(d, pinhole->dy, at.y - pinhole->half_height));
}

static ALWAYS_INLINE bool fits_film(struct pen_vec3 c)
{
    return fabs(c.x) <= FLT_MAX && fabs(c.y) <= FLT_MAX && fabs(c.z) <= FLT_MAX;
}

#endif
