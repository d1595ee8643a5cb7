/* SPDX-License-Identifier: MIT */
/* Infinite cylinders: the constructor, and the functions of their kind. */
#include "geom/infinite_cylinder.h"

#include "geom/internal/cylinder_side.h"
#include "geom/internal/kinds.h"
#include "geom/internal/make.h"

bool pen_infinite_cylinder_make(struct pen_infinite_cylinder *infinite_cylinder,
                                struct pen_vec3 origin, struct pen_vec3 axis, double r)
{
    struct pen_cylinder_side *s = &infinite_cylinder->round;
    if (!pen_cylinder_side_make(s, origin, axis, r))
        return false;
    /* An error of `along` only moves the point along the axis. */
    double along = pen_dot2(s->a, origin) / pen_dot(s->a, s->a);
    infinite_cylinder->near = pen_vec3(fma(-along, s->a.x, origin.x), fma(-along, s->a.y, origin.y),
                                       fma(-along, s->a.z, origin.z));
    return is_finite3(infinite_cylinder->near);
}

static bool make(void *self, const struct pen_prim_source *from)
{
    return pen_infinite_cylinder_make(self, from->point, from->direction, from->length[PEN_RADIUS]);
}

static void intersect_line(const void *self, const struct pen_ray *ray,
                           struct pen_intersections *out)
{
    const struct pen_infinite_cylinder *c = self;
    double t[2];
    bool parallel;
    if (pen_cylinder_side_roots(&c->round, ray, t, &parallel))
        pen_intersections_pair(out, t[0], t[1]);
}

static struct pen_vec3 normal(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part;
    return pen_cylinder_side_normal(&((const struct pen_infinite_cylinder *)self)->round, p);
}

static struct pen_vec3 project(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part;
    return pen_cylinder_side_project(&((const struct pen_infinite_cylinder *)self)->round, p);
}

static double scale(const void *self, struct pen_vec3 p)
{
    const struct pen_infinite_cylinder *c = self;
    (void)p;
    return c->round.r + pen_norm1(c->near);
}

static double reach(const void *self, struct pen_vec3 n, struct pen_vec3 p)
{
    const struct pen_infinite_cylinder *c = self;
    return pen_cylinder_side_reach(&c->round, c->near, INFINITY, n, p);
}

static double distance(const void *self, struct pen_vec3 p)
{
    const struct pen_cylinder_side *round = &((const struct pen_infinite_cylinder *)self)->round;
    struct pen_vec3 axis = pen_unit_of(round->a), from = pen_sub(p, round->q);
    double to_axis = pen_length(pen_along(from, axis, -pen_dot(from, axis)));
    return fabs(to_axis - round->r);
}

static bool touched(const struct pen_infinite_cylinder *c, struct pen_vec3 p, double bound)
{
    return pen_cylinder_side_touches(&c->round, p, bound + pen_infinite_cylinder_rounding(c));
}

static double curvature(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part, (void)p;
    return 1 / ((const struct pen_infinite_cylinder *)self)->round.r;
}

static unsigned touches(const void *self, struct pen_vec3 p, double bound)
{
    return touched(self, p, bound) ? PEN_ON_SIDE : 0;
}

static void intersect_own(const void *self, const struct pen_ray *ray, uint8_t part,
                          struct pen_intersections *out)
{
    const struct pen_infinite_cylinder *c = self;
    (void)part;
    pen_intersections_own(out, pen_cylinder_side_chord(&c->round, ray));
}

static unsigned intersect_touching(const void *self, const struct pen_ray *ray, double bound,
                                   struct pen_intersections *out)
{
    const struct pen_infinite_cylinder *c = self;
    if (out->count > 0 && touched(c, ray->o, bound))
        pen_intersections_chord(out, pen_cylinder_side_chord(&c->round, ray));
    return 0;
}

const struct pen_kind_functions pen_infinite_cylinder_functions = {
    .make = make,
    .intersect_line = intersect_line,
    .normal = normal,
    .project = project,
    .scale = scale,
    .reach = reach,
    .distance = distance,
    .curvature = curvature,
    .touches = touches,
    .intersect_own = intersect_own,
    .intersect_touching = intersect_touching,
};
