/* SPDX-License-Identifier: MIT */
/* Triangles, and the rule by which every flat primitive owns its border: half-open winding in
 * sheared ray space. Seen along the ray, an edge counts if it passes from y <= 0 to y > 0 (or back)
 * on the right of the ray. The difference of products has an exact sign, so two primitives that
 * share an edge decide alike. So a ray through an edge or a vertex of a closed surface meets
 * exactly one of the faces there. Outward is the side from which the vertices run
 * counter-clockwise.
 *
 * t depends neither on the order of the vertices nor on the signs of the axes. If all sums are
 * exact, it does not depend on the place of the triangle either. The extents of the edges along the
 * axes distinguish one vertex, and the sums treat the other two alike.
 * Source: Woop, Benthin, Wald, "Watertight ray/triangle intersection", JCGT 2(1), 2013, with the
 * differences of products of math/exact.h in place of its fallback. */
#ifndef PEN_GEOM_TRIANGLE_H
#define PEN_GEOM_TRIANGLE_H

#include "geom/facet.h"
#include "math/box.h"

struct pen_triangle {
    struct pen_vec3 v[3]; /* in the given order, from the distinguished vertex on */
    struct pen_facet facet;
};

/* Makes a triangle. n is within 2 ulp of the exact normal, however narrow the triangle.
 * Fails: returns false if a coordinate is not finite, or is not 0 and below PEN_LEAST, if the
 * product of two edges overflows, or if the vertices are exactly on one line. */
bool pen_triangle_make(struct pen_triangle *tri, struct pen_vec3 a, struct pen_vec3 b,
                       struct pen_vec3 c);

/* Makes a triangle whose vertices rounding has put on one line. Its normal is some vector across
 * that line. If they are one point, it is one along z. */
void pen_triangle_make_thin(struct pen_triangle *tri, const struct pen_vec3 v[3]);

/* The number of the distinguished vertex. */
int pen_triangle_first_corner(const struct pen_vec3 v[3]);

/* Whether the ray's line passes inside the triangle. */
static inline bool pen_triangle_entered(const struct pen_triangle *tri, const struct pen_ray *ray)
{
    struct pen_sheared a = pen_shear(ray, &tri->v[0]);
    struct pen_sheared b = pen_shear(ray, &tri->v[1]);
    struct pen_sheared c = pen_shear(ray, &tri->v[2]);
    double w = pen_edge(a, b), u = pen_edge(b, c), v = pen_edge(c, a);
    return pen_edge_counts(a, b, w) + pen_edge_counts(b, c, u) + pen_edge_counts(c, a, v) != 0;
}

/* The t at which the ray's line meets the triangle; false if it does not. */
static inline bool pen_triangle_root(const struct pen_triangle *tri, const struct pen_ray *ray,
                                     double *t)
{
    if (!pen_triangle_entered(tri, ray))
        return false;
    *t = pen_outline_root(&tri->facet, tri->v, 3, ray);
    return true;
}

/* Whether the point of the ray at t is within 2^10 b of its origin. */
static inline bool pen_flat_near(const struct pen_ray *ray, double t, double b)
{
    return t * t <= (0x1p20 * b * b) * ray->inv_dd;
}

/* Whether an intersection at t with a flat primitive of unit normal n is the ray's origin itself,
 * up to `bound` and the primitive's own rounding, which is proportional to `scale`. A point behind
 * the origin must be within 2^10 bounds of it: farther away, the primitive is only seen edge-on. */
static inline bool pen_flat_touches(struct pen_vec3 n, double scale, const struct pen_ray *ray,
                                    double t, double bound)
{
    double b = bound + 8 * PEN_U * scale;
    return fabs(t * pen_dot(ray->d, n)) <= b && (t > 0 || pen_flat_near(ray, t, b));
}

#endif
