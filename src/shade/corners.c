/* SPDX-License-Identifier: MIT */
#include "shade/internal/corners.h"

#include <math.h>

/* The first move is 2^STEP bounds long; it doubles with every third one. */
enum { STEP = 16 };

void pen_corner_move(struct corner *corner, const struct pen_pinhole *pinhole, struct pen_ray *ray)
{
    corner->step = ldexp(corner->bound, STEP + corner->moves / 3);
    double x = .54 * corner->step, y = .84 * corner->step; /* along no axis of a symmetric scene */
    for (int i = 1; i < corner->moves; i++) { /* by 53 degrees, which never comes to a full turn */
        const double turned = .6 * x - .8 * y;
        y = .8 * x + .6 * y;
        x = turned;
    }
    const struct pen_vec3 right = pen_normalize(pinhole->dx), up = pen_normalize(pinhole->dy);
    pen_ray_make(ray, pen_along(pen_along(ray->o, right, x), up, y), ray->d);
}
