/* SPDX-License-Identifier: MIT */
/* One primitive of any kind, by the functions of its kind: the intersections with the ray's line,
 * normal, projection, bounds, rounding bound. */
#include "geom/prims.h"

const struct pen_origin_surface pen_origin_none = {.prim = PEN_NO_PRIM};

void pen_prim_intersect_line(const struct pen_prims *prims, uint32_t prim,
                             const struct pen_ray *ray, struct pen_intersections *out)
{
    out->count = 0;
    pen_prim_row(prims, prim)->fn->intersect_line(pen_prim_self(prims, prim), ray, out);
}

unsigned pen_prim_touches(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p,
                          double bound)
{
    return pen_prim_row(prims, prim)->fn->touches(pen_prim_self(prims, prim), p, bound);
}

struct pen_vec3 pen_prim_normal(const struct pen_prims *prims, struct pen_hit hit,
                                struct pen_vec3 p)
{
    return pen_prim_row(prims, hit.prim)->fn->normal(pen_prim_self(prims, hit.prim), hit.part, p);
}

struct pen_vec3 pen_prim_point(const struct pen_prims *prims, struct pen_hit hit,
                               const struct pen_ray *ray)
{
    struct pen_vec3 p = pen_along(ray->o, ray->d, hit.t);
    return pen_prim_row(prims, hit.prim)->fn->project(pen_prim_self(prims, hit.prim), hit.part, p);
}

struct pen_box pen_prim_bounds(const struct pen_prims *prims, uint32_t prim)
{
    return pen_prim_row(prims, prim)->fn->bounds(pen_prim_self(prims, prim));
}

double pen_prim_scale(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    return pen_prim_row(prims, prim)->fn->scale(pen_prim_self(prims, prim), p);
}

double pen_prim_rounding(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    return 16 * PEN_U * (pen_norm1(p) + pen_prim_scale(prims, prim, p));
}
