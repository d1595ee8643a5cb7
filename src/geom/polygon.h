/* SPDX-License-Identifier: MIT */
/* Flat polygons of any outline, convex or not. Inside is decided by the half-open winding of
 * geom/triangle.h. Outward is the side from which the vertices run counter-clockwise. */
#ifndef PEN_GEOM_POLYGON_H
#define PEN_GEOM_POLYGON_H

#include "base/arena.h"
#include "geom/triangle.h"

/* A polygon with more corners is not cut, because cutting takes the square of their number in
 * steps. */
enum { PEN_POLYGON_CUT_MAX = 10000 };

struct pen_polygon {
    const struct pen_vec3 *v; /* borrowed */
    uint32_t count;
    struct pen_facet facet;
    double extent;     /* no two vertices are farther apart along an axis */
    double scale;      /* pen_prim_scale: from the distance of the vertices from the facet */
    bool flat, convex; /* true only if it is so up to rounding of the vertices; may be false for a
                          polygon that is so */
    /* Its count - 2 triangles, borrowed; NULL: the polygon is not cut. */
    const struct pen_triangle *piece;
};

/* Makes a polygon. The scene's reader has checked that the outline is simple and flat.
 * Owns: borrows v.
 * Fails: returns false if a coordinate is not finite, or is not 0 and below PEN_LEAST, there are
 * fewer than three vertices, the product of two edges overflows, or the sum of signed areas is
 * exactly zero. */
bool pen_polygon_make(struct pen_polygon *p, const struct pen_vec3 *v, uint32_t count);

/* Cuts a polygon into triangles if its vertices are farther from one plane than the rounding of hit
 * points. The triangles are then its surface.
 * Owns: the arena owns the triangles.
 * Fails: returns false when out of memory. */
bool pen_polygon_cut(struct pen_polygon *p, struct pen_arena *arena);

/* The triangle of a cut polygon that is nearest to q; the first of several. */
const struct pen_triangle *pen_polygon_piece(const struct pen_polygon *p, struct pen_vec3 q);

/* The one of two intersections with a polygon that counts: the first ahead of the ray's origin,
 * else the last behind it. */
static inline double pen_first_ahead(double s, double t)
{
    return (s > 0) != (t > 0) ? (s > 0 ? s : t) : (s > 0) == (s < t) ? s : t;
}

/* Whether the ray's line passes inside the outline. */
static inline bool pen_polygon_entered(const struct pen_polygon *p, const struct pen_ray *ray)
{
    int winding = 0;
    struct pen_sheared a = pen_shear(ray, &p->v[p->count - 1]);
    for (uint32_t i = 0; i < p->count; i++) {
        struct pen_sheared b = pen_shear(ray, &p->v[i]);
        if ((a.y <= 0) != (b.y <= 0))
            winding += pen_edge_counts(a, b, pen_edge(a, b));
        a = b;
    }
    return winding != 0;
}

/* The t at which the ray's line meets a polygon that is not cut; false if it does not. */
static inline bool pen_polygon_root(const struct pen_polygon *p, const struct pen_ray *ray,
                                    double *t)
{
    if (!pen_polygon_entered(p, ray))
        return false;
    *t = pen_outline_root(&p->facet, p->v, p->count, ray);
    return true;
}

#endif
