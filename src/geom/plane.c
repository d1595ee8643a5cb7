/* SPDX-License-Identifier: MIT */
/* Planes: the constructor, and the functions of their kind. */
#include "geom/plane.h"

#include "geom/internal/double_double.h"
#include "geom/internal/kinds.h"
#include "geom/internal/make.h"

bool pen_plane_make(struct pen_plane *p, struct pen_vec3 point, struct pen_vec3 normal)
{
    if (!is_finite3(point) || !is_finite3(normal) || pen_largest3(normal) == 0)
        return false;
    p->g = pen_scale_to_one(normal);
    p->n = pen_unit_of(normal);
    /* The point nearest the origin. The given point, which is exact, is used if it is about as
     * near. */
    struct dd3 g = dd_of3(p->g);
    double s = dd_dot(g, dd_of3(point)).hi / dd_dot(g, g).hi;
    struct pen_vec3 foot = pen_scale(p->g, s);
    p->q = pen_norm1(point) <= 4 * pen_norm1(foot) ? point : foot;
    return is_finite3(p->q);
}

static bool make(void *self, const struct pen_prim_source *from)
{
    return pen_plane_make(self, from->point, from->direction);
}

static void intersect_line(const void *self, const struct pen_ray *ray,
                           struct pen_intersections *out)
{
    double t;
    if (pen_plane_root(self, ray, &t))
        pen_intersections_add(out, t, PEN_PART_SIDE);
}

static struct pen_vec3 normal(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part, (void)p;
    return ((const struct pen_plane *)self)->n;
}

static struct pen_vec3 project(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part;
    return pen_plane_project(self, p);
}

static double scale(const void *self, struct pen_vec3 p)
{
    return pen_norm1(pen_sub(p, ((const struct pen_plane *)self)->q));
}

/* Without end unless n is the normal, within the rounding of both. */
static double reach(const void *self, struct pen_vec3 n, struct pen_vec3 p)
{
    const struct pen_plane *plane = self;
    if (pen_norm1(pen_cross(n, plane->n)) > 16 * PEN_U)
        return INFINITY;
    return pen_dot(n, pen_sub(plane->q, p));
}

static double distance(const void *self, struct pen_vec3 p)
{
    const struct pen_plane *plane = self;
    return fabs(pen_dot(plane->n, pen_sub(p, plane->q)));
}

const struct pen_kind_functions pen_plane_functions = {
    .make = make,
    .intersect_line = intersect_line,
    .normal = normal,
    .project = project,
    .scale = scale,
    .reach = reach,
    .distance = distance,
};
