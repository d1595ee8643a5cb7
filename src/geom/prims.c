/* SPDX-License-Identifier: MIT */
/* One primitive of any kind, by the functions of its kind: the intersections with the ray's line,
 * normal, projection, bounds, rounding bound. */
#include "geom/prims.h"

const struct pen_origin_surface pen_origin_none = {.prim = PEN_NO_PRIM};

void pen_prim_intersect_line(const struct pen_prims *prims, uint32_t prim,
                             const struct pen_ray *ray, struct pen_intersections *out)
{
    struct pen_triangle room;
    out->count = 0;
    pen_prim_row(prims, prim)->fn->intersect_line(pen_prim_self(prims, prim, &room), ray, out);
}

unsigned pen_prim_touches(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p,
                          double bound)
{
    struct pen_triangle room;
    return pen_prim_row(prims, prim)->fn->touches(pen_prim_self(prims, prim, &room), p, bound);
}

struct pen_vec3 pen_prim_normal(const struct pen_prims *prims, struct pen_hit hit,
                                struct pen_vec3 p)
{
    struct pen_triangle room;
    return pen_prim_row(prims, hit.prim)
        ->fn->normal(pen_prim_self(prims, hit.prim, &room), hit.part, p);
}

struct pen_vec3 pen_prim_normal_seen(const struct pen_prims *prims, struct pen_hit hit,
                                     struct pen_vec3 p, struct pen_vec3 d)
{
    const struct pen_prim_ref ref = pen_prim_ref(prims, hit.prim);
    struct pen_vec3 n;
    if (ref.kind == PEN_PRIM_CONE && hit.part == PEN_PART_SIDE &&
        pen_cone_apex_normal(&prims->cone[ref.index], p, d, &n))
        return n;
    return pen_prim_normal(prims, hit, p);
}

/* The point of an outline's edges that is nearest p, and the square of its distance. */
static struct pen_vec3 nearest_of_border(const struct pen_outline *line, struct pen_vec3 p,
                                         double *square)
{
    struct pen_vec3 nearest = p;
    *square = INFINITY;
    for (uint32_t i = 0; i < line->count; i++) {
        struct pen_vec3 a = line->v[i], e = pen_sub(line->v[i + 1 < line->count ? i + 1 : 0], a);
        double ee = pen_dot(e, e), s = ee > 0 ? pen_dot(pen_sub(p, a), e) / ee : 0;
        struct pen_vec3 x = pen_along(a, e, s < 0 ? 0 : s > 1 ? 1 : s), off = pen_sub(p, x);
        double here = pen_dot(off, off);
        if (here < *square) {
            *square = here;
            nearest = x;
        }
    }
    return nearest;
}

struct pen_vec3 pen_prim_point(const struct pen_prims *prims, struct pen_hit hit,
                               const struct pen_ray *ray)
{
    struct pen_triangle room;
    struct pen_vec3 p = pen_along(ray->o, ray->d, hit.t);
    return pen_prim_row(prims, hit.prim)
        ->fn->project(pen_prim_self(prims, hit.prim, &room), hit.part, p);
}

struct pen_vec3 pen_prim_point_in_outline(const struct pen_prims *prims, struct pen_hit hit,
                                          struct pen_vec3 o, struct pen_vec3 p, double sine)
{
    struct pen_triangle room;
    const struct pen_outline line = pen_prim_outline(prims, hit.prim, &room);
    double square, far = 16 * PEN_U * (pen_norm1(p) + pen_norm1(o)) / fabs(sine);
    struct pen_vec3 nearest = nearest_of_border(&line, p, &square);
    struct pen_ray across;
    struct pen_intersections c;
    if (line.count == 0 || square > far * far ||
        !pen_ray_make(&across, p, pen_prim_normal(prims, hit, p)))
        return p;
    pen_prim_intersect_line(prims, hit.prim, &across, &c);
    if (c.count > 0)
        return p;
    return pen_prim_row(prims, hit.prim)
        ->fn->project(pen_prim_self(prims, hit.prim, &room), hit.part, nearest);
}

struct pen_box pen_prim_bounds(const struct pen_prims *prims, uint32_t prim)
{
    const struct pen_mesh *mesh = pen_prim_mesh(prims, prim);
    if (mesh)
        return pen_mesh_bounds(mesh, prim - mesh->first);
    struct pen_triangle room;
    return pen_prim_row(prims, prim)->fn->bounds(pen_prim_self(prims, prim, &room));
}

double pen_prim_scale(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    if (pen_prim_mesh(prims, prim))
        return 0;
    struct pen_triangle room;
    return pen_prim_row(prims, prim)->fn->scale(pen_prim_self(prims, prim, &room), p);
}

double pen_prim_rounding(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    return 16 * PEN_U * (pen_norm1(p) + pen_prim_scale(prims, prim, p));
}
