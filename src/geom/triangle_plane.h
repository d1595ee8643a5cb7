/* SPDX-License-Identifier: MIT */
/* The t at which a line meets a triangle whose facet is not stored. The facet is computed again,
 * with the operations of pen_triangle_make. */
#ifndef PEN_GEOM_TRIANGLE_PLANE_H
#define PEN_GEOM_TRIANGLE_PLANE_H

#include "geom/internal/facet.h"

/* Sets *t to pen_outline_root of a triangle that the line enters. `v` begins with the distinguished
 * vertex. Returns false if the vertices are on one line. */
static inline bool pen_triangle_plane_root(const struct pen_vec3 v[3], const struct pen_ray *ray,
                                           double *t)
{
    struct dd3 normal;
    if (!pen_triangle_normal(v, pen_vec3(0, 0, 0), &normal))
        return false;
    const struct pen_facet facet = pen_facet_plane(v[0], normal);
    *t = pen_outline_root(&facet, v, 3, ray);
    return true;
}

#endif
