/* SPDX-License-Identifier: MIT */
/* Flat polygons of any outline, convex or not. Inside is decided by the half-open winding of
 * geom/triangle.h. Outward is the side from which the vertices run counter-clockwise. */
#ifndef PEN_GEOM_POLYGON_H
#define PEN_GEOM_POLYGON_H

#include "geom/triangle.h"

struct pen_polygon {
    const struct pen_vec3 *v; /* borrowed */
    uint32_t count;
    struct pen_facet facet;
    double extent;     /* no vertex is farther than this from another, in any axis */
    double scale;      /* pen_prim_scale: from how far vertices are off the facet */
    bool flat, convex; /* up to rounding of the vertices; may be false for others that are */
};

/* Fails: returns false if a coordinate is not finite, or not 0 and below PEN_LEAST, there are fewer
 * than three vertices, the product of two edges overflows, or the sum of signed areas is zero,
 * decided exactly. The scene's reader has checked that the outline is simple and flat. Owns:
 * borrows v. */
bool pen_polygon_make(struct pen_polygon *p, const struct pen_vec3 *v, uint32_t count);

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

/* The t at which the ray's line meets the polygon; false if it does not. */
static inline bool pen_polygon_root(const struct pen_polygon *p, const struct pen_ray *ray,
                                    double *t)
{
    if (!pen_polygon_entered(p, ray))
        return false;
    *t = pen_outline_root(&p->facet, p->v, p->count, ray);
    return true;
}

#endif
