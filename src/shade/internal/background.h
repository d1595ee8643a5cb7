/* SPDX-License-Identifier: MIT */
/* The radiance of a ray that misses everything: the background, or the sky. */
#ifndef PEN_SHADE_INTERNAL_BACKGROUND_H
#define PEN_SHADE_INTERNAL_BACKGROUND_H

#include "shade/internal/surface.h"

/* Linear in the sine of the ray's elevation, from the horizon's colour to that of the zenith or
 * nadir. Exactly the horizon's colour if all are equal. */
static ALWAYS_INLINE struct pen_vec3 background_seen(const struct pen_scene *scene,
                                                     const struct pen_ray *ray, const unsigned fx)
{
    const struct pen_vec3 horizon = scene->background;
    if (!(fx & PEN_FX_SKY))
        return horizon;
    const struct pen_sky *sky = &scene->sky;
    const double sine = pen_dot(ray->d, sky->up) / pen_length(ray->d);
    const struct pen_vec3 pole = sine < 0 ? sky->nadir : sky->zenith;
    const double share = fabs(sine) < 1 ? fabs(sine) : 1;
    return pen_along(horizon, pen_sub(pole, horizon), share);
}

#endif
