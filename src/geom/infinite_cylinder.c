/* SPDX-License-Identifier: MIT */
/* Tubes: how they are made. */
#include "geom/infinite_cylinder.h"

#include "geom/internal/cylinder_side.h"
#include "geom/internal/make.h"

bool pen_infinite_cylinder_make(struct pen_infinite_cylinder *infinite_cylinder,
                                struct pen_vec3 origin, struct pen_vec3 axis, double r)
{
    struct pen_cylinder_side *s = &infinite_cylinder->round;
    if (!pen_cylinder_side_make(s, origin, axis, r))
        return false;
    /* An error of `along` only slides the point on the axis. */
    double along = pen_dot2(s->a, origin) / pen_dot(s->a, s->a);
    infinite_cylinder->near = pen_vec3(fma(-along, s->a.x, origin.x), fma(-along, s->a.y, origin.y),
                                       fma(-along, s->a.z, origin.z));
    return is_finite3(infinite_cylinder->near);
}
