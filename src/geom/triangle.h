/* SPDX-License-Identifier: MIT */
/* Triangles, and the rule by which every flat primitive owns its border: half-open winding in
 * sheared ray space. Seen along the ray, an edge counts if it passes from y <= 0 to y > 0 (or back)
 * on the right of the ray. An edge shared by two primitives takes the same decision in both,
 * because the difference of products has an exact sign. So a ray through an edge or a vertex of a
 * closed surface meets exactly one of the faces there. Outward is the side from which the vertices
 * run counter-clockwise.
 *
 * t does not depend on the order that the vertices come in, on where the triangle is if all sums
 * are exact, nor on the signs of the axes: the extents of the edges along the axes distinguish one
 * vertex, and the sums treat the other two alike.
 * Source: Woop, Benthin, Wald, "Watertight ray/triangle intersection", JCGT 2(1), 2013, with the
 * differences of products of math/exact.h in place of its fallback. */
#ifndef PEN_GEOM_TRIANGLE_H
#define PEN_GEOM_TRIANGLE_H

#include "geom/ray.h"
#include "math/box.h"

struct pen_triangle {
    struct pen_vec3 v[3]; /* in the order given, beginning with the distinguished one */
    struct pen_vec3 n;    /* unit */
};

/* n is within 2 ulp of the exact normal, however narrow the triangle. Fails: returns false if a
 * coordinate is not finite, or not 0 and below PEN_LEAST, if the product of two edges overflows, or
 * if the vertices are on one line, decided exactly. */
bool pen_triangle_make(struct pen_triangle *tri, struct pen_vec3 a, struct pen_vec3 b,
                       struct pen_vec3 c);

/* A point in ray space: the ray is the z axis, its origin is 0; z is not yet divided by d[kz]. */
struct pen_sheared {
    double x, y, z;
};

static inline struct pen_sheared pen_shear(const struct pen_ray *ray, const struct pen_vec3 *v)
{
    struct pen_vec3 f = pen_sub(pen_permuted(ray, v), ray->permuted_o);
    return (struct pen_sheared){f.x - ray->sx * f.z, f.y - ray->sy * f.z, f.z};
}

/* Twice the area of (ray, P, Q) seen along the ray; its sign is exact. */
static inline double pen_edge(struct pen_sheared p, struct pen_sheared q)
{
    return pen_dop(p.x, q.y, p.y, q.x);
}

/* The same, with equal magnitude for PQ and QP.
 * Source: Jeannerod, "A radix-independent error analysis of the Cornea-Harrison-Tang method",
 * ACM TOMS 42(3), 2016. */
static inline double pen_edge_even(struct pen_sheared p, struct pen_sheared q)
{
    double a = p.x * q.y, b = p.y * q.x;
    return (a - b) + (fma(p.x, q.y, -a) - fma(p.y, q.x, -b));
}

/* What edge PQ, with s = pen_edge(p, q), adds to the winding number: +1, -1 or 0. */
static inline int pen_edge_counts(struct pen_sheared p, struct pen_sheared q, double s)
{
    return (p.y <= 0 && q.y > 0 && s > 0) - (p.y > 0 && q.y <= 0 && s < 0);
}

/* Whether the depth of an intersection, as a mean of the vertices' depths, loses digits: their
 * spread along the ray is more than twice the triangle's width across it, area / size. Gives the
 * same answer for a, b, c as for a, c, b. */
static inline bool pen_triangle_grazed(struct pen_sheared a, struct pen_sheared b,
                                       struct pen_sheared c, double area)
{
    double size = (fabs(b.x - a.x) + fabs(b.y - a.y)) + (fabs(c.x - a.x) + fabs(c.y - a.y));
    double spread = fabs(b.z - a.z) + fabs(c.z - a.z);
    return size * spread > 8 * fabs(area);
}

/* Replaces *t by the intersection with the triangle's plane in double-double, clamped to the range
 * of the vertices' depths. */
void pen_triangle_refine(const struct pen_triangle *tri, const struct pen_ray *ray, double *t);

/* The t at which the ray's line meets the triangle; false if it does not. *t lies in the range of
 * the vertices' depths. */
static inline bool pen_triangle_root(const struct pen_triangle *tri, const struct pen_ray *ray,
                                     double *t)
{
    struct pen_sheared a = pen_shear(ray, &tri->v[0]);
    struct pen_sheared b = pen_shear(ray, &tri->v[1]);
    struct pen_sheared c = pen_shear(ray, &tri->v[2]);
    double w = pen_edge(a, b), u = pen_edge(b, c), v = -pen_edge(a, c);
    if (pen_edge_counts(a, b, w) + pen_edge_counts(b, c, u) + pen_edge_counts(c, a, v) == 0)
        return false;
    u = pen_edge_even(b, c); /* symmetric in b and c, as the sum below */
    double area = u + (v + w);
    *t = (u * a.z + (v * b.z + w * c.z)) * ray->sz / area;
    if (pen_triangle_grazed(a, b, c, area))
        pen_triangle_refine(tri, ray, t);
    return true;
}

static inline struct pen_vec3 pen_triangle_project(const struct pen_triangle *tri,
                                                   struct pen_vec3 p)
{
    return pen_along(p, tri->n, pen_dot(tri->n, pen_sub(tri->v[0], p)));
}

/* Whether the point of the ray at t is within 2^10 b of its origin. */
static inline bool pen_flat_near(const struct pen_ray *ray, double t, double b)
{
    return t * t <= (0x1p20 * b * b) * ray->inv_dd;
}

/* Whether an intersection at t of a flat primitive with unit normal n is the ray's origin itself,
 * up to `bound` and the primitive's own rounding, which is proportional to `scale`. What lies
 * behind the origin must be within 2^10 bounds of it: farther away it is merely seen edge-on. */
static inline bool pen_flat_touches(struct pen_vec3 n, double scale, const struct pen_ray *ray,
                                    double t, double bound)
{
    double b = bound + 8 * PEN_U * scale;
    return fabs(t * pen_dot(ray->d, n)) <= b && (t > 0 || pen_flat_near(ray, t, b));
}

#endif
