/* SPDX-License-Identifier: MIT */
/* Polygons: how they are made, and the functions of their kind. */
#include "geom/polygon.h"

#include "geom/internal/facet.h"
#include "geom/internal/kinds.h"
#include "geom/internal/make.h"

/* Newell's normal, relative to the first vertex. */
static struct dd3 newell(const struct pen_vec3 *v, uint32_t count)
{
    struct dd3 sum = dd_of3(pen_vec3(0, 0, 0));
    struct dd3 e = dd_sub3(v[1], v[0]);
    for (uint32_t i = 2; i < count; i++) {
        struct dd3 f = dd_sub3(v[i], v[0]);
        sum = dd_add3(sum, dd_cross(e, f));
        e = f;
    }
    return sum;
}

/* The facet with this normal through the mean of the vertices: wherever the outline starts, and
 * whichever way it runs, the same one. */
static struct pen_facet mean_facet(const struct pen_vec3 *v, uint32_t count, struct dd3 normal)
{
    struct pen_facet facet = pen_facet_of(v[0], normal);
    double sum = 0;
    for (uint32_t i = 1; i < count; i++)
        sum -= pen_facet_above(&facet, v[i]);
    struct dd c = dd_add((struct dd){facet.c, facet.c_low}, (struct dd){sum / count, 0});
    facet.c = c.hi;
    facet.c_low = c.lo;
    return facet;
}

/* Sets four members:
 *   facet.grazing  INFINITY if a vertex v is farther off the plane than 2^-50 |v|
 *   flat    each vertex v is in the facet's plane, up to 2^-44 of the extent and 2^-50 |v|
 *   convex  the outline turns left at each vertex, up to an area of 2^-46 of the extent squared
 *   scale   the distance of a vertex from the plane counts as rounding of the hit point */
static void classify_outline(struct pen_polygon *p)
{
    double most = 0, inv_length = 1 / pen_length(p->facet.g);
    p->flat = p->convex = true;
    for (uint32_t i = 0; i < p->count; i++) {
        struct pen_vec3 v = p->v[i], next = p->v[(i + 1) % p->count];
        struct pen_vec3 e = pen_sub(next, v), f = pen_sub(p->v[(i + 2) % p->count], next);
        double off = pen_facet_above(&p->facet, v) * inv_length,
               turn = pen_dot(p->facet.n, pen_cross(e, f));
        if (!(fabs(off) <= 0x1p-44 * p->extent + 0x1p-50 * pen_norm1(v)))
            p->flat = false;
        if (!(fabs(off) <= 0x1p-50 * pen_norm1(v)))
            p->facet.grazing = INFINITY;
        if (!(turn >= -0x1p-46 * p->extent * p->extent))
            p->convex = false;
        most = fabs(off) > most ? fabs(off) : most;
    }
    p->scale = most / (8 * PEN_U);
}

/* `otherwise` is the normal if the area is zero; zero: it must not be. */
static bool make_with(struct pen_polygon *p, const struct pen_vec3 *v, uint32_t count,
                      struct pen_vec3 otherwise)
{
    if (count < 3)
        return false;
    for (uint32_t i = 0; i < count; i++) {
        if (!is_vertex(v[i]))
            return false;
    }
    *p = (struct pen_polygon){.v = v, .count = count};
    struct pen_box b = pen_box_of_points(v, count);
    p->extent = pen_largest3(pen_sub(b.hi, b.lo));
    struct dd3 normal = newell(v, count);
    if (!is_finite3(dd_round3(normal)))
        return false;
    /* The error of the normal is a few 2^-104 of this area: below this it would show. */
    double least = 0x1p-40 * count * p->extent * p->extent;
    if (!pen_exact_enough(&normal, least, v, count, otherwise))
        return false;
    p->facet = mean_facet(v, count, normal);
    classify_outline(p);
    return true;
}

bool pen_polygon_make(struct pen_polygon *p, const struct pen_vec3 *v, uint32_t count)
{
    return make_with(p, v, count, pen_vec3(0, 0, 0));
}

static bool make(void *self, const struct pen_prim_source *from)
{
    return make_with(self, from->vertices, from->count, from->direction);
}

static void intersect_line(const void *self, const struct pen_ray *ray,
                           struct pen_intersections *out)
{
    double t;
    if (pen_polygon_root(self, ray, &t))
        pen_intersections_add(out, t, PEN_PART_SIDE);
}

static struct pen_vec3 normal(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part, (void)p;
    return ((const struct pen_polygon *)self)->facet.n;
}

static struct pen_vec3 project(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part;
    return pen_facet_project(&((const struct pen_polygon *)self)->facet, p);
}

static struct pen_box bounds(const void *self)
{
    const struct pen_polygon *p = self;
    return pen_outline_bounds(p->v, p->count, 8 * PEN_U * p->scale);
}

static double scale(const void *self, struct pen_vec3 p)
{
    (void)p;
    return ((const struct pen_polygon *)self)->scale;
}

static double reach(const void *self, struct pen_vec3 n, struct pen_vec3 p)
{
    const struct pen_polygon *polygon = self;
    return pen_farthest(polygon->v, polygon->count, n, p);
}

static struct pen_outline outline(const void *self)
{
    const struct pen_polygon *polygon = self;
    return (struct pen_outline){polygon->v, polygon->count, polygon->extent};
}

const struct pen_kind_functions pen_polygon_functions = {
    .keeps_vertices = true,
    .make = make,
    .intersect_line = intersect_line,
    .normal = normal,
    .project = project,
    .bounds = bounds,
    .scale = scale,
    .reach = reach,
    .outline = outline,
};
