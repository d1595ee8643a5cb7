/* SPDX-License-Identifier: MIT */
/* The samples of a pixel: where they are, their camera rays, and which values the film holds. */
#ifndef PEN_SHADE_INTERNAL_PIXEL_SAMPLE_H
#define PEN_SHADE_INTERNAL_PIXEL_SAMPLE_H

#include <float.h>

#include "geom/ray_lanes.h"
#include "shade/internal/surface.h"

/* Point i of a pixel's samples: the centre if it has one sample only. */
static ALWAYS_INLINE struct pen_point2 pixel_point(uint64_t hash, int i, int samples)
{
    return samples > 1 ? pen_sobol2(hash, (uint32_t)i) : (struct pen_point2){0.5, 0.5};
}

/* The camera rays through points of the image. Returns the lanes that have one. */
static ALWAYS_INLINE lane_mask camera_rays(const struct pen_pinhole *pinhole, lanes x, lanes y,
                                           struct lanes_ray *rays)
{
    const struct lanes3 middle = lanes3_splat(pinhole->middle);
    const struct lanes3 d =
        lanes3_along(middle, lanes3_splat(pinhole->dx), x - pinhole->half_width);
    return lanes_ray_of(rays, lanes3_splat(pinhole->eye),
                        lanes3_along(d, lanes3_splat(pinhole->dy), y - pinhole->half_height));
}

static ALWAYS_INLINE bool fits_film(struct pen_vec3 c)
{
    return fabs(c.x) <= FLT_MAX && fabs(c.y) <= FLT_MAX && fabs(c.z) <= FLT_MAX;
}

#endif
