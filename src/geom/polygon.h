/* SPDX-License-Identifier: MIT */
/* Flat polygons of any outline, convex or not. Inside is decided by the half-open winding of
 * geom/triangle.h. The depth is interpolated on the line y = 0 of ray space, between the two edges
 * nearest the ray that cross this line: so it is a mean of the vertices' depths with weights in
 * [0, 1], at any angle, and neighbours that share an edge agree on it. Outward is the side from
 * which the vertices run counter-clockwise. */
#ifndef PEN_GEOM_POLYGON_H
#define PEN_GEOM_POLYGON_H

#include "geom/triangle.h"

struct pen_polygon {
    const struct pen_vec3 *v; /* borrowed */
    uint32_t count;
    struct pen_vec3 n; /* unit */
    double extent;     /* no vertex is farther than this from another, in any axis */
    double scale;      /* pen_prim_scale: extent, and more if rounding put vertices off the plane */
    bool flat, convex; /* up to rounding of the vertices; may be false for others that are */
};

/* Fails: returns false if a coordinate is not finite, or not 0 and below PEN_LEAST, there are fewer
 * than three vertices, the product of two edges overflows, or the sum of signed areas is zero,
 * decided exactly. The scene's reader has checked that the outline is simple and flat. Owns:
 * borrows v. */
bool pen_polygon_make(struct pen_polygon *p, const struct pen_vec3 *v, uint32_t count);

/* One end of the segment of y = 0 that contains the ray: x = s / h, depth z = w / h. */
struct pen_scan_end {
    double s, w, h; /* h > 0; 0 if there is none yet */
};

/* Whether e is farther right than f. Edges that cross y = 0 in the same point are ordered too, so
 * that t depends neither on where the outline starts nor on its direction. */
static inline bool pen_scan_right_of(struct pen_scan_end e, struct pen_scan_end f)
{
    double ef = e.s * f.h, fe = f.s * e.h;
    return ef > fe || (ef == fe && (e.h > f.h || (e.h == f.h && e.w > f.w)));
}

/* The t at which the ray's line meets the polygon; false if it does not. */
static inline bool pen_polygon_root(const struct pen_polygon *p, const struct pen_ray *ray,
                                    double *t)
{
    struct pen_scan_end left = {0, 0, 0}, right = {0, 0, 0};
    int winding = 0;
    struct pen_sheared a = pen_shear(ray, &p->v[p->count - 1]);
    for (uint32_t i = 0; i < p->count; i++) {
        struct pen_sheared b = pen_shear(ray, &p->v[i]);
        if ((a.y <= 0) != (b.y <= 0)) {
            double up = a.y <= 0 ? 1 : -1; /* downward edges are reversed */
            struct pen_scan_end e = {up * pen_edge_even(a, b), up * (a.z * b.y - a.y * b.z),
                                     up * (b.y - a.y)};
            if (e.s > 0) {
                winding += (int)up;
                if (right.h == 0 || pen_scan_right_of(right, e))
                    right = e;
            } else if (left.h == 0 || pen_scan_right_of(e, left)) {
                left = e;
            }
        }
        a = b;
    }
    if (winding == 0)
        return false;
    *t = (left.w * right.s - right.w * left.s) * ray->sz / (right.s * left.h - left.s * right.h);
    return true;
}

static inline struct pen_vec3 pen_polygon_project(const struct pen_polygon *pg, struct pen_vec3 p)
{
    return pen_along(p, pg->n, pen_dot(pg->n, pen_sub(pg->v[0], p)));
}

#endif
