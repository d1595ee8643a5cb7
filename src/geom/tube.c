/* SPDX-License-Identifier: MIT */
/* Tubes: how they are made. */
#include "pen/geom/tube.h"

#include "make.h"
#include "round.h"

bool pen_tube_make(struct pen_tube *tube, struct pen_vec3 origin, struct pen_vec3 axis, double r)
{
    struct pen_round *s = &tube->round;
    if (!pen_round_make(s, origin, axis, r))
        return false;
    /* The point of the axis nearest the coordinate origin, unless the given one, which is exact,
     * is about as near. An error of `along` only slides the point on the axis. */
    double along = pen_dot2(s->a, origin) / pen_dot(s->a, s->a);
    struct pen_vec3 foot = pen_vec3(fma(-along, s->a.x, origin.x), fma(-along, s->a.y, origin.y),
                                    fma(-along, s->a.z, origin.z));
    if (pen_norm1(origin) > 4 * pen_norm1(foot))
        s->q = foot;
    return is_finite3(s->q);
}
