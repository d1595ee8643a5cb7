/* SPDX-License-Identifier: MIT */
/* Polygons: the constructor, and the functions of their kind. */
#include "geom/polygon.h"

#include <stdlib.h>

#include "geom/internal/facet.h"
#include "geom/internal/kinds.h"
#include "geom/internal/make.h"
#include "geom/triangulate.h"

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

/* The facet with this normal through the mean of the vertices. It depends neither on the first
 * vertex of the outline nor on its direction. */
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
 *   facet.grazing  INFINITY if a vertex v is farther off the plane than 2^-50 |v|: the polygon must
 *   be
 *                  cut
 *   flat    each vertex v is in the facet's plane, up to 2^-44 of the extent and 2^-50 |v|
 *   convex  the outline turns left at each vertex, up to an area of 2^-46 of the extent squared
 *   scale   the distance of a vertex from the plane counts as rounding of the hit point
 *
 * 2^-50 |v| is 8u |v|, half of the rounding that pen_prim_rounding allows for a hit point near v
 * without any scale. The other half is for t, o + t d and the projection onto the surface. A vertex
 * in the plane is off by its rounding to doubles, u |v|. A group's three products and three sums
 * add some 5u |v|. Both are less than 8u |v|, unless the vertex has later come near the origin. */
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

/* Makes a polygon. `otherwise` is the normal if the area is zero; zero: such a polygon is refused.
 */
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
    /* The error of the normal is a few 2^-104 of this area; below this limit it would be visible.
     */
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

/* Makes piece i. If its corners are on one line, its plane is parallel to the polygon's. */
static bool make_piece(struct pen_triangle *piece, const struct pen_polygon *p,
                       const uint32_t corner[3])
{
    const struct pen_vec3 v[3] = {p->v[corner[0]], p->v[corner[1]], p->v[corner[2]]};
    const struct pen_prim_source from = {.direction = p->facet.n, .count = 3, .vertices = v};
    return pen_triangle_functions.make(piece, &from);
}

bool pen_polygon_cut(struct pen_polygon *p, struct pen_arena *arena)
{
    if (p->facet.grazing < INFINITY || p->count < 4 || p->count > PEN_POLYGON_CUT_MAX)
        return true;
    struct pen_triangle *piece = pen_arena_alloc(arena, p->count - 2, sizeof *piece);
    uint32_t(*corner)[3] = malloc((p->count - 2) * sizeof *corner);
    bool ok = piece && corner && pen_triangulate(p->v, p->count, p->facet.n, corner);
    for (uint32_t i = 0; ok && i + 2 < p->count; i++)
        ok = make_piece(&piece[i], p, corner[i]);
    free(corner);
    if (!ok)
        return false;
    p->piece = piece;
    p->flat = false;
    p->scale = 0; /* as a triangle's */
    return true;
}

static bool cut(void *self, struct pen_arena *arena)
{
    return pen_polygon_cut(self, arena);
}

/* The t at which the ray's line meets a cut polygon; false if it does not. */
static bool cut_root(const struct pen_polygon *p, const struct pen_ray *ray, double *t)
{
    bool met = false;
    double s;
    for (uint32_t i = 0; i + 2 < p->count; i++) {
        if (pen_triangle_root(&p->piece[i], ray, &s)) {
            *t = met ? pen_first_ahead(*t, s) : s;
            met = true;
        }
    }
    return met;
}

/* The square of the distance from q to a segment. */
static double from_segment(struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 q)
{
    struct pen_vec3 e = pen_sub(b, a), f = pen_sub(q, a);
    double ee = pen_dot(e, e), s = ee > 0 ? pen_dot(f, e) / ee : 0;
    struct pen_vec3 off = pen_along(f, e, s < 0 ? 0 : s > 1 ? -1 : -s);
    return pen_dot(off, off);
}

/* The square of the distance from q to a triangle: to its plane, if q is over it, or to an edge. */
static double from_triangle(const struct pen_triangle *tri, struct pen_vec3 q)
{
    double least = INFINITY, above = pen_facet_above(&tri->facet, q);
    bool over = true;
    for (int i = 0; i < 3; i++) {
        struct pen_vec3 a = tri->v[i], b = tri->v[(i + 1) % 3];
        double side = pen_dot(tri->facet.n, pen_cross(pen_sub(b, a), pen_sub(q, a)));
        double s = from_segment(a, b, q);
        over = over && side >= 0;
        least = s < least ? s : least;
    }
    return over ? above * above / pen_dot(tri->facet.g, tri->facet.g) : least;
}

/* How far x is outside the interval of three numbers. */
static double beyond(double a, double b, double c, double x)
{
    double lo = a < b ? a : b, hi = a < b ? b : a;
    lo = lo < c ? lo : c;
    hi = hi > c ? hi : c;
    return x < lo ? lo - x : x > hi ? x - hi : 0;
}

/* A lower bound of the squared distance from q to a triangle: that to its box. */
static double from_box(const struct pen_triangle *tri, struct pen_vec3 q)
{
    const struct pen_vec3 *v = tri->v;
    double x = beyond(v[0].x, v[1].x, v[2].x, q.x), y = beyond(v[0].y, v[1].y, v[2].y, q.y),
           z = beyond(v[0].z, v[1].z, v[2].z, q.z);
    return x * x + y * y + z * z;
}

const struct pen_triangle *pen_polygon_piece(const struct pen_polygon *p, struct pen_vec3 q)
{
    const struct pen_triangle *nearest = p->piece;
    double least = INFINITY;
    for (uint32_t i = 0; i + 2 < p->count; i++) {
        double s = from_box(&p->piece[i], q) < least ? from_triangle(&p->piece[i], q) : INFINITY;
        if (s < least) {
            least = s;
            nearest = &p->piece[i];
        }
    }
    return nearest;
}

/* The facet at a point of the polygon. */
static const struct pen_facet *facet_at(const struct pen_polygon *p, struct pen_vec3 q)
{
    return p->piece ? &pen_polygon_piece(p, q)->facet : &p->facet;
}

static bool make(void *self, const struct pen_prim_source *from)
{
    return make_with(self, from->vertices, from->count, from->direction);
}

static void intersect_line(const void *self, const struct pen_ray *ray,
                           struct pen_intersections *out)
{
    const struct pen_polygon *p = self;
    double t = 0;
    if (p->piece ? cut_root(p, ray, &t) : pen_polygon_root(p, ray, &t))
        pen_intersections_add(out, t, PEN_PART_SIDE);
}

static struct pen_vec3 normal(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part;
    return facet_at(self, p)->n;
}

static struct pen_vec3 project(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part;
    return pen_facet_project(facet_at(self, p), p);
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
    if (polygon->piece)
        return pen_farthest(pen_polygon_piece(polygon, p)->v, 3, n, p);
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
    .cut = cut,
    .intersect_line = intersect_line,
    .normal = normal,
    .project = project,
    .bounds = bounds,
    .scale = scale,
    .reach = reach,
    .outline = outline,
};
