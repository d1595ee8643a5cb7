/* SPDX-License-Identifier: MIT */
/* Tubes: how they are made. */
#include "geom/tube.h"

#include "geom/internal/make.h"
#include "geom/internal/round.h"

bool pen_tube_make(struct pen_tube *tube, struct pen_vec3 origin, struct pen_vec3 axis, double r)
{
    struct pen_round *s = &tube->round;
    if (!pen_round_make(s, origin, axis, r))
        return false;
    /* An error of `along` only slides the point on the axis. */
    double along = pen_dot2(s->a, origin) / pen_dot(s->a, s->a);
    tube->near = pen_vec3(fma(-along, s->a.x, origin.x), fma(-along, s->a.y, origin.y),
                          fma(-along, s->a.z, origin.z));
    return is_finite3(tube->near);
}
