/* SPDX-License-Identifier: MIT */
/* Tests of one primitive against the rays of a group, LANES at a time, in binary64. Every lane does
 * the operations of the primitive's header in geom in the same order, so t has the same bits. The
 * comment of a small function names the scalar function that it computes. A lane falls back to the
 * scalar test if that may use other operations: it refines, the self-intersection rule decides, the
 * light may be on the primitive, or two products tie. One fallback too many costs time and changes
 * nothing. */
#ifndef PEN_ACCEL_INTERNAL_RAY_GROUP_TEST_H
#define PEN_ACCEL_INTERNAL_RAY_GROUP_TEST_H

#include "accel/internal/ray_group_outline.h"
#include "accel/internal/ray_group_round.h"

/* pen_plane_root with pen_dot_guarded, if the latter keeps its digits. */
static inline void group_test_plane_at(struct ray_group *g, int i, const struct pen_plane *p,
                                       unsigned live, const struct group_prim *q)
{
    const struct lanes3 n = group_splat(g, p->g), d = group_direction(g, i);
    const struct lanes3 f = lanes3_sub(group_splat(g, p->q), group_origin(g, i));
    const lanes gd = lanes3_dot(n, d), t = lanes3_dot(n, f) / gd;
    unsigned sure =
        lane_mask_bits(lanes_at_most(lanes3_dot_size(n, d), lanes_splat(8) * lanes_abs(gd)) &
                       lanes_less(lanes_load(g->rays->near + i), lanes_splat(INFINITY)) &
                       lane_mask_not(lanes_equal(gd, lanes_splat(0))));
    if (g->from_surface) {
        /* A superset of the lanes that the ray's origin touches; |g| < 2. */
        const lanes bound = lanes_load(g->bound + i) + lanes_splat(8 * PEN_U) * lanes3_norm1(f);
        sure &= lane_mask_bits(lanes_less(lanes_splat(4) * bound, lanes_abs(t * gd)) &
                               lanes_less(lanes_load(g->near_sq + i), t * t));
    }
    group_offer(g, i, live & sure, t, q);
    group_fall_back_all(g, i, live & ~sure, q->prim, q->near);
}

static inline void group_test_plane(struct ray_group *g, const struct pen_plane *p,
                                    const struct group_prim *q)
{
    for (int i = 0; i < g->end; i += LANES) {
        const unsigned live = group_waits(g, i, q) & ~group_starts_on(i, q);
        if (live)
            group_test_plane_at(g, i, p, live, q);
    }
}

/* Tests all live rays one by one with the scalar test. */
static inline void group_test_one_by_one(struct ray_group *g, const struct group_prim *q)
{
    for (int i = 0; i < g->end; i += LANES)
        group_fall_back_all(g, i, group_waits(g, i, q), q->prim, true);
}

/* Tests a primitive against all live rays. */
static inline void group_test(struct ray_group *g, const struct group_prim *q)
{
    struct pen_triangle room;
    const struct pen_prims *prims = g->accel->prims;
    const struct pen_prim_ref ref = pen_prim_ref(prims, q->prim);
    switch (pen_block_of(ref.kind)) {
    case PEN_BLOCK_SPHERES:
        group_test_sphere(g, &prims->sphere[ref.index], q);
        break;
    case PEN_BLOCK_CYLINDERS:
        group_test_cylinder(g, &prims->cylinder[ref.index], q);
        break;
    case PEN_BLOCK_PLANES:
        group_test_plane(g, &prims->plane[ref.index], q);
        break;
    case PEN_BLOCK_TRIANGLES: {
        const struct pen_triangle *t = pen_prim_triangle(prims, ref.index, &room);
        const struct group_outline outline = {t->v, 3, &t->facet, true, 0};
        group_test_outline(g, &outline, q);
        break;
    }
    case PEN_BLOCK_POLYGONS: {
        const struct pen_polygon *p = &prims->polygon[ref.index];
        const struct group_outline outline = {
            p->v, p->count, &p->facet, g->accel->convex[pen_prim_slot(prims, q->prim)], p->extent};
        if (p->piece)
            group_test_one_by_one(g, q);
        else
            group_test_outline(g, &outline, q);
        break;
    }
    case PEN_BLOCK_INFINITE_CYLINDERS:
    case PEN_BLOCK_GENERIC:
    case PEN_BLOCK_MESH:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        group_test_one_by_one(g, q);
        break;
    }
    g->live &= ~g->blocked;
}

#endif
