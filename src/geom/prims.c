/* SPDX-License-Identifier: MIT */
/* One primitive of any kind: its intersections without regard to what the ray leaves, normal,
 * projection, bounds, rounding bound. */
#include "geom/prims.h"

#include "geom/internal/kinds.h"

const struct pen_origin_surface pen_origin_none = {.prim = PEN_NO_PRIM};

static void add(struct pen_intersections *out, double t, uint8_t part)
{
    out->t[out->count] = t;
    out->part[out->count] = part;
    out->count++;
}

static void add_pair(struct pen_intersections *out, bool crossed, const double t[2])
{
    if (crossed) {
        add(out, t[0], PEN_PART_SIDE);
        add(out, t[1], PEN_PART_SIDE);
    }
}

void pen_interval_ends(const struct pen_cylinder *c, const struct pen_interval *in,
                       struct pen_intersections *out)
{
    if (c->caps || in->lo_part == PEN_PART_SIDE)
        add(out, in->lo, in->lo_part);
    if (c->caps || in->hi_part == PEN_PART_SIDE)
        add(out, in->hi, in->hi_part);
}

void pen_prim_intersect_line(const struct pen_prims *prims, uint32_t prim,
                             const struct pen_ray *ray, struct pen_intersections *out)
{
    const struct pen_prim_ref ref = prims->ref[prim];
    double t[2];
    bool parallel;
    struct pen_interval in;
    out->count = 0;
    switch ((enum pen_prim_kind)ref.kind) {
    case PEN_PRIM_SPHERE:
        add_pair(out, pen_sphere_roots(&prims->sphere[ref.index], ray, t), t);
        break;
    case PEN_PRIM_INFINITE_CYLINDER:
        add_pair(
            out,
            pen_cylinder_side_roots(&prims->infinite_cylinder[ref.index].round, ray, t, &parallel),
            t);
        break;
    case PEN_PRIM_CYLINDER:
        if (pen_cylinder_interval(&prims->cylinder[ref.index], ray, &in))
            pen_interval_ends(&prims->cylinder[ref.index], &in, out);
        break;
    case PEN_PRIM_PLANE:
        if (pen_plane_root(&prims->plane[ref.index], ray, t))
            add(out, t[0], PEN_PART_SIDE);
        break;
    case PEN_PRIM_TRIANGLE:
        if (pen_triangle_root(&prims->triangle[ref.index], ray, t))
            add(out, t[0], PEN_PART_SIDE);
        break;
    case PEN_PRIM_POLYGON:
        if (pen_polygon_root(&prims->polygon[ref.index], ray, t))
            add(out, t[0], PEN_PART_SIDE);
        break;
    case PEN_PRIM_KIND_COUNT:
        break;
    }
}

struct pen_vec3 pen_prim_normal(const struct pen_prims *prims, struct pen_hit hit,
                                struct pen_vec3 p)
{
    const struct pen_prim_ref ref = prims->ref[hit.prim];
    switch ((enum pen_prim_kind)ref.kind) {
    case PEN_PRIM_SPHERE:
        return pen_sphere_normal(&prims->sphere[ref.index], p);
    case PEN_PRIM_INFINITE_CYLINDER:
        return pen_cylinder_side_normal(&prims->infinite_cylinder[ref.index].round, p);
    case PEN_PRIM_CYLINDER:
        return pen_cylinder_normal(&prims->cylinder[ref.index], hit.part, p);
    case PEN_PRIM_PLANE:
        return prims->plane[ref.index].n;
    case PEN_PRIM_TRIANGLE:
        return prims->triangle[ref.index].n;
    case PEN_PRIM_POLYGON:
        return prims->polygon[ref.index].n;
    case PEN_PRIM_KIND_COUNT:
        break;
    }
    return pen_vec3(0, 0, 0);
}

struct pen_vec3 pen_prim_point(const struct pen_prims *prims, struct pen_hit hit,
                               const struct pen_ray *ray)
{
    const struct pen_prim_ref ref = prims->ref[hit.prim];
    struct pen_vec3 p = pen_along(ray->o, ray->d, hit.t);
    switch ((enum pen_prim_kind)ref.kind) {
    case PEN_PRIM_SPHERE:
        return pen_sphere_project(&prims->sphere[ref.index], p);
    case PEN_PRIM_INFINITE_CYLINDER:
        return pen_cylinder_side_project(&prims->infinite_cylinder[ref.index].round, p);
    case PEN_PRIM_CYLINDER:
        return pen_cylinder_project(&prims->cylinder[ref.index], hit.part, p);
    case PEN_PRIM_PLANE:
        return pen_plane_project(&prims->plane[ref.index], p);
    case PEN_PRIM_TRIANGLE:
        return pen_triangle_project(&prims->triangle[ref.index], p);
    case PEN_PRIM_POLYGON:
        return pen_polygon_project(&prims->polygon[ref.index], p);
    case PEN_PRIM_KIND_COUNT:
        break;
    }
    return p;
}

struct pen_box pen_prim_bounds(const struct pen_prims *prims, uint32_t prim)
{
    const struct pen_prim_ref ref = prims->ref[prim];
    switch ((enum pen_prim_kind)ref.kind) {
    case PEN_PRIM_SPHERE:
        return pen_sphere_bounds(&prims->sphere[ref.index]);
    case PEN_PRIM_CYLINDER:
        return pen_cylinder_bounds(&prims->cylinder[ref.index]);
    case PEN_PRIM_TRIANGLE:
        return pen_triangle_bounds(&prims->triangle[ref.index]);
    case PEN_PRIM_POLYGON:
        return pen_polygon_bounds(&prims->polygon[ref.index]);
    case PEN_PRIM_INFINITE_CYLINDER:
    case PEN_PRIM_PLANE:
    case PEN_PRIM_KIND_COUNT:
        break;
    }
    return pen_box_empty();
}

double pen_prim_scale(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    const struct pen_prim_ref ref = prims->ref[prim];
    switch ((enum pen_prim_kind)ref.kind) {
    case PEN_PRIM_SPHERE:
        return prims->sphere[ref.index].r;
    case PEN_PRIM_INFINITE_CYLINDER:
        return prims->infinite_cylinder[ref.index].round.r +
               pen_norm1(prims->infinite_cylinder[ref.index].near);
    case PEN_PRIM_CYLINDER:
        return prims->cylinder[ref.index].round.r + prims->cylinder[ref.index].h;
    case PEN_PRIM_PLANE:
        return pen_norm1(pen_sub(p, prims->plane[ref.index].q));
    case PEN_PRIM_TRIANGLE:
        return pen_triangle_extent(&prims->triangle[ref.index]);
    case PEN_PRIM_POLYGON:
        return prims->polygon[ref.index].scale;
    case PEN_PRIM_KIND_COUNT:
        break;
    }
    return 0;
}

double pen_prim_rounding(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    return 16 * PEN_U * (pen_norm1(p) + pen_prim_scale(prims, prim, p));
}
