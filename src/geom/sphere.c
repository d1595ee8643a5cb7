/* SPDX-License-Identifier: MIT */
/* Spheres: the functions that are not hot. */
#include "geom/sphere.h"

#include "geom/internal/double_double.h"
#include "geom/internal/kinds.h"
#include "geom/internal/make.h"

bool pen_sphere_make(struct pen_sphere *s, struct pen_vec3 c, double r)
{
    if (!is_finite3(c) || !is_length(r))
        return false;
    struct dd rr = two_prod(r, r);
    *s = (struct pen_sphere){c, r, rr.hi, rr.lo};
    return true;
}

void pen_sphere_refine(const struct pen_sphere *s, const struct pen_ray *ray, double t[2])
{
    struct dd3 f = dd_sub3(ray->o, s->c), d = dd_of3(ray->d);
    struct dd minus_rr = {-s->rr, -s->rr_low};
    dd_roots(dd_dot(d, d), dd_dot(f, d), dd_add(dd_dot(f, f), minus_rr), t);
}

/* The t of the other intersection of a ray whose origin is on the sphere by identity: -2 b / a,
 * with b exact to the last bits. It is positive if the ray goes inward. */
static double chord(const struct pen_sphere *s, const struct pen_ray *ray)
{
    struct dd b = dd_dot(dd_sub3(ray->o, s->c), dd_of3(ray->d));
    return -2 * b.hi / pen_dot(ray->d, ray->d);
}

static bool make(void *self, const struct pen_prim_source *from)
{
    return pen_sphere_make(self, from->point, from->length[PEN_RADIUS]);
}

static void intersect_line(const void *self, const struct pen_ray *ray,
                           struct pen_intersections *out)
{
    double t[2];
    if (pen_sphere_roots(self, ray, t))
        pen_intersections_pair(out, t[0], t[1]);
}

static struct pen_vec3 normal(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part;
    return pen_sphere_normal(self, p);
}

static struct pen_vec3 project(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part;
    return pen_sphere_project(self, p);
}

static struct pen_box bounds(const void *self)
{
    const struct pen_sphere *s = self;
    struct pen_vec3 r = pen_vec3(s->r, s->r, s->r);
    return pen_box_grow((struct pen_box){pen_sub(s->c, r), pen_add(s->c, r)}, s->r);
}

static double scale(const void *self, struct pen_vec3 p)
{
    (void)p;
    return ((const struct pen_sphere *)self)->r;
}

static double reach(const void *self, struct pen_vec3 n, struct pen_vec3 p)
{
    const struct pen_sphere *s = self;
    return pen_dot(n, pen_sub(s->c, p)) + s->r;
}

static double distance(const void *self, struct pen_vec3 p)
{
    const struct pen_sphere *s = self;
    return fabs(pen_length(pen_sub(p, s->c)) - s->r);
}

static double curvature(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part, (void)p;
    return 1 / ((const struct pen_sphere *)self)->r;
}

static unsigned touches(const void *self, struct pen_vec3 p, double bound)
{
    return pen_sphere_touches(self, p, bound) ? PEN_ON_SIDE : 0;
}

static void intersect_own(const void *self, const struct pen_ray *ray, uint8_t part,
                          struct pen_intersections *out)
{
    (void)part;
    pen_intersections_own(out, chord(self, ray));
}

static unsigned intersect_touching(const void *self, const struct pen_ray *ray, double bound,
                                   struct pen_intersections *out)
{
    if (out->count > 0 && pen_sphere_touches(self, ray->o, bound))
        pen_intersections_chord(out, chord(self, ray));
    return 0;
}

const struct pen_kind_functions pen_sphere_functions = {
    .make = make,
    .intersect_line = intersect_line,
    .normal = normal,
    .project = project,
    .bounds = bounds,
    .scale = scale,
    .reach = reach,
    .distance = distance,
    .curvature = curvature,
    .touches = touches,
    .intersect_own = intersect_own,
    .intersect_touching = intersect_touching,
};
