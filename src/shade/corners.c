/* SPDX-License-Identifier: MIT */
#include "shade/internal/corners.h"

#include <math.h>

#include "math/scale.h"

/* The first move is 2^STEP bounds long; every third move doubles the length. */
enum { STEP = 16 };

bool pen_corner_move(struct corner *corner, const struct pen_kernel_input *input,
                     struct pen_ray *ray)
{
    const struct pen_t_interval interval = {pen_after_start, INFINITY};
    const struct pen_vec3 right = pen_normalize(input->pinhole.dx),
                          up = pen_normalize(input->pinhole.dy);
    const double step = pen_scale2(corner->bound, STEP + corner->moves / 3);
    double x = .54 * step, y = .84 * step; /* along no axis of a symmetric scene */
    for (int i = 1; i < corner->moves;
         i++) { /* by 53 degrees, no multiple of which is a full turn */
        const double turned = .6 * x - .8 * y;
        y = .8 * x + .6 * y;
        x = turned;
    }
    const struct pen_vec3 aside = pen_along(pen_scale(right, x), up, y);
    struct pen_ray way;
    struct pen_hit hit;
    if (!pen_ray_make(&way, ray->o, aside) ||
        (input->trace->nearest(input->scene->accel, &way, &pen_origin_none, &interval, &hit) &&
         hit.t <= 2))
        return false;
    corner->met = false;
    return pen_ray_make(ray, pen_add(ray->o, aside), ray->d);
}
