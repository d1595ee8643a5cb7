/* SPDX-License-Identifier: MIT */
/* The hit points of LANES rays on one primitive, projected onto its surface, and the normals there.
 * Each lane does the operations of a scalar function in the same order; the comment names it. */
#ifndef PEN_GEOM_SURFACE_LANES_H
#define PEN_GEOM_SURFACE_LANES_H

#include "geom/prims.h"
#include "math/lanes.h"

/* pen_facet_project */
static inline struct lanes3 lanes_facet_project(const struct pen_facet *facet, struct lanes3 p)
{
    const struct lanes3 g = lanes3_splat(facet->g);
    const lanes low = facet->c_low - lanes3_dot(lanes3_splat(facet->g_low), p);
    const lanes above = lanes3_dot2_plus(lanes_splat(facet->c), lanes3_neg(g), p, low);
    return lanes3_along(p, g, above / lanes_splat(pen_dot(facet->g, facet->g)));
}

/* pen_plane_project */
static inline struct lanes3 lanes_plane_project(const struct pen_plane *plane, struct lanes3 p)
{
    const struct lanes3 n = lanes3_splat(plane->n);
    return lanes3_along(p, n, lanes3_dot(n, lanes3_sub(lanes3_splat(plane->q), p)));
}

/* pen_sphere_normal */
static inline struct lanes3 lanes_sphere_normal(const struct pen_sphere *s, struct lanes3 p)
{
    return lanes3_normalize(lanes3_sub(p, lanes3_splat(s->c)));
}

/* pen_sphere_project */
static inline struct lanes3 lanes_sphere_project(const struct pen_sphere *s, struct lanes3 p)
{
    return lanes3_along(lanes3_splat(s->c), lanes_sphere_normal(s, p), lanes_splat(s->r));
}

/* pen_cylinder_side_across */
static inline struct lanes3 lanes_cylinder_side_across(const struct pen_cylinder_side *s,
                                                       struct lanes3 p)
{
    const struct lanes3 q = lanes3_splat(s->q), a = lanes3_splat(s->a), f = lanes3_sub(p, q),
                        low = lanes3_difference_error(p, q, f);
    const struct lanes3 rest = {low.y * a.z - low.z * a.y, low.z * a.x - low.x * a.z,
                                low.x * a.y - low.y * a.x};
    return lanes3_add(lanes3_cross(f, a), rest);
}

/* pen_unit_of. *usual: the lanes in which it is valid, those whose largest component is between
 * 2^-500 and 2^500. */
static inline struct lanes3 lanes_unit_of(struct lanes3 v, lane_mask *usual)
{
    const lanes m = lanes_max(lanes_max(lanes_abs(v.x), lanes_abs(v.y)), lanes_abs(v.z));
    *usual = lanes_less(lanes_splat(0x1p-500), m) & lanes_less(m, lanes_splat(0x1p500));
    /* In two's complement; half of it is rounded towards 0, as in C. */
    const lane_words exponent = (lanes_words(m) >> 52) - 1022;
    const lane_words half = ((exponent + (exponent >> 63) + 1024) >> 1) - 512;
    const lanes first = lanes_of_words((1023 - half) << 52);
    const lanes second = lanes_of_words((1023 - (exponent - half)) << 52);
    const struct lanes3 s = lanes3_scale(lanes3_scale(v, first), second);
    const lanes length = lanes3_length(s);
    return (struct lanes3){s.x / length, s.y / length, s.z / length};
}

/* pen_cylinder_side_normal at a point for which pen_cylinder_side_across is `across`; valid in the
 * lanes of *usual. */
static inline struct lanes3 lanes_cylinder_side_normal(const struct pen_cylinder_side *s,
                                                       struct lanes3 across, lane_mask *usual)
{
    return lanes_unit_of(lanes3_cross(lanes3_splat(s->a), across), usual);
}

/* Projects *p as pen_cylinder_side_project, and sets *n to the normal there. Returns false if a
 * lane of `wanted` needs the scalar functions. */
static inline bool lanes_cylinder_side_surface(const struct pen_cylinder_side *s, unsigned wanted,
                                               struct lanes3 *p, struct lanes3 *n)
{
    lane_mask usual, still_usual;
    const struct lanes3 across = lanes_cylinder_side_across(s, *p);
    const lanes distance = lanes3_length(across) / lanes_splat(s->length);
    *n = lanes_cylinder_side_normal(s, across, &usual);
    *p = lanes3_along(*p, *n, s->r - distance);
    *n = lanes_cylinder_side_normal(s, lanes_cylinder_side_across(s, *p), &still_usual);
    return (wanted & ~lane_mask_bits(usual & still_usual)) == 0;
}

/* pen_cylinder_project and pen_cylinder_normal on a cap */
static inline void lanes_cylinder_cap_surface(const struct pen_cylinder *c, uint8_t part,
                                              struct lanes3 *p, struct lanes3 *n)
{
    const lanes zero = lanes_splat(0);
    const struct lanes3 axis = lanes3_splat(pen_cylinder_normal(c, PEN_PART_TOP, c->round.q));
    const struct lanes3 f = lanes3_sub(*p, lanes3_splat(c->round.q));
    const lanes height = lanes3_dot2_plus(zero, axis, f, zero);
    *p = lanes3_along(*p, axis, (part == PEN_PART_TOP ? c->h : 0) - height);
    *n = part == PEN_PART_TOP ? axis : lanes3_neg(axis);
}

/* Points of one part of a primitive. */
struct lanes_prim_point {
    struct lanes3 p, n;
    lanes scale, curvature; /* pen_prim_scale, pen_prim_curvature */
};

/* Projects at->p, where rays meet a part of a primitive, as pen_prim_point, and sets the other
 * members; n is pen_prim_normal there. `wanted` has one bit per lane. Returns false, with *at
 * undefined, if one of these lanes needs the scalar functions. */
static inline bool lanes_prim_surface(const struct pen_prims *prims, uint32_t prim, uint8_t part,
                                      unsigned wanted, struct lanes_prim_point *at)
{
    struct pen_triangle room;
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    const struct pen_facet *facet = NULL;
    at->scale = at->curvature = lanes_splat(0);
    switch ((enum pen_prim_kind)ref.kind) {
    case PEN_PRIM_SPHERE: {
        const struct pen_sphere *s = &prims->sphere[ref.index];
        at->p = lanes_sphere_project(s, at->p);
        at->n = lanes_sphere_normal(s, at->p);
        at->scale = lanes_splat(s->r);
        at->curvature = lanes_splat(1 / s->r);
        return true;
    }
    case PEN_PRIM_PLANE: {
        const struct pen_plane *plane = &prims->plane[ref.index];
        at->p = lanes_plane_project(plane, at->p);
        at->n = lanes3_splat(plane->n);
        at->scale = lanes3_norm1(lanes3_sub(at->p, lanes3_splat(plane->q)));
        return true;
    }
    case PEN_PRIM_TRIANGLE:
        facet = &pen_prim_triangle(prims, ref.index, &room)->facet;
        break;
    case PEN_PRIM_POLYGON:
        if (prims->polygon[ref.index].piece)
            return false;
        facet = &prims->polygon[ref.index].facet;
        at->scale = lanes_splat(prims->polygon[ref.index].scale);
        break;
    case PEN_PRIM_INFINITE_CYLINDER: {
        const struct pen_infinite_cylinder *c = &prims->infinite_cylinder[ref.index];
        at->scale = lanes_splat(c->round.r + pen_norm1(c->near));
        at->curvature = lanes_splat(1 / c->round.r);
        return lanes_cylinder_side_surface(&c->round, wanted, &at->p, &at->n);
    }
    case PEN_PRIM_CYLINDER: {
        const struct pen_cylinder *c = &prims->cylinder[ref.index];
        at->scale = lanes_splat(c->round.r + c->h);
        if (part == PEN_PART_SIDE) {
            at->curvature = lanes_splat(1 / c->round.r);
            return lanes_cylinder_side_surface(&c->round, wanted, &at->p, &at->n);
        }
        lanes_cylinder_cap_surface(c, part, &at->p, &at->n);
        return true;
    }
    case PEN_PRIM_CONE:
    case PEN_PRIM_KIND_COUNT:
        return false;
    }
    at->p = lanes_facet_project(facet, at->p);
    at->n = lanes3_splat(facet->n);
    return true;
}

/* Rays that have met surfaces, with the members of struct pen_origin_surface of their starts. */
struct lanes_origin {
    struct lanes3 toward, before;
    lanes bound, toward_bound, before_bound;
};
struct lanes_arrived {
    struct lanes3 o;
    lanes t, inv_dd;
    struct lanes_origin left;
};

/* pen_origin_at, for p, the points that the rays have met, at surfaces of this scale. */
static inline struct lanes_origin lanes_origin_at(const struct lanes_arrived *ray, struct lanes3 p,
                                                  lanes scale)
{
    const struct lanes_origin *left = &ray->left;
    const lanes nearby = PEN_NEARBY * left->bound, toward = lanes3_norm1(left->toward);
    const lane_mask hardly_moved = lanes_at_most(ray->t * ray->t, nearby * nearby * ray->inv_dd);
    const lane_mask moved = lanes_less(lanes_splat(PEN_LAST_LAYER_T), ray->t);
    const lane_mask tells =
        moved & (lanes_less(nearby, toward) | lanes_less(lanes3_norm1(left->before), toward));
    const struct lanes3 back = lanes3_sub(ray->o, p);
    const struct lanes3 toward_back = lanes3_add(left->toward, back);
    const lanes bound = 16 * PEN_U * (lanes3_norm1(p) + scale) + 16 * PEN_U * lanes3_norm1(ray->o);
    return (struct lanes_origin){
        .toward = lanes3_select(moved, back, toward_back),
        .before = lanes3_select(tells, toward_back, lanes3_add(left->before, back)),
        .bound = lanes_select(hardly_moved, bound + left->bound, bound),
        .toward_bound = lanes_select(moved, left->bound, left->toward_bound),
        .before_bound = lanes_select(tells, left->toward_bound, left->before_bound)};
}

#endif
