/* SPDX-License-Identifier: MIT */
/* Tests of one primitive against the rays of a group, LANES at a time, in binary64. Every lane does
 * the operations of the primitive's header in geom in the same order, so t has the same bits; the
 * comment of a small function names the scalar function that it computes. A lane in which the
 * quick operations may not be those that the scalar test ends with (it refines, the
 * self-intersection rule decides, the light may be on the primitive, two products tie) is *asked*
 * of the scalar test instead. Asking one lane too many costs time and changes nothing. */
#ifndef PEN_ACCEL_INTERNAL_RAY_GROUP_TEST_H
#define PEN_ACCEL_INTERNAL_RAY_GROUP_TEST_H

#include "accel/internal/ray_group_outline.h"

/* pen_difference_error3 */
static inline struct lanes3 lanes3_difference_error(struct lanes3 a, struct lanes3 b,
                                                    struct lanes3 diff)
{
    const struct lanes3 part = lanes3_sub(diff, a);
    return (struct lanes3){(a.x - (diff.x - part.x)) - (b.x + part.x),
                           (a.y - (diff.y - part.y)) - (b.y + part.y),
                           (a.z - (diff.z - part.z)) - (b.z + part.z)};
}

/* Lanes that surely go outward from a round side that they start on, so that they do not meet it
 * again: f is what the side has outward at the origin, not normalised. */
static inline unsigned lanes_outward(lanes outward, struct lanes3 f, struct lanes3 d)
{
    return lane_mask_bits(
        lanes_less(lanes_splat(0x1p-38) * (lanes3_norm1(f) * lanes3_norm1(d)), outward));
}

/* Lanes whose roots the scalar function refines. */
static inline unsigned lanes_refined(const struct ray_group *g, int i, lanes tp, lanes h,
                                     lanes disc, lanes rr)
{
    const lanes near = lanes_load(g->near + i);
    return lane_mask_bits(lanes_less(lanes_abs(lanes_abs(tp) - h), near * h) |
                          lanes_less(lanes_abs(disc), lanes_splat(PEN_GRAZING) * rr));
}

/* pen_sphere_roots, for rays i to i + LANES - 1. */
static inline void group_test_sphere_at(struct ray_group *g, int i, const struct pen_sphere *s,
                                        const struct group_prim *q)
{
    unsigned live = group_live(g, i), ask = 0;
    const struct lanes3 o = group_origin(g, i), d = group_direction(g, i), c = group_splat(g, s->c),
                        f = lanes3_sub(o, c), low = lanes3_difference_error(o, c, f);
    const lanes rr = lanes_splat(s->rr), inv_dd = lanes_load(g->inv_dd + i);
    const lanes tp = -lanes3_dot(f, d) * inv_dd;
    const struct lanes3 l = lanes3_add(lanes3_along_once(f, d, tp), low);
    const lanes disc = (rr - lanes3_dot(l, l)) + lanes_splat(s->rr_low);
    live &= lane_mask_bits(lanes_less(lanes_splat(-PEN_GRAZING) * rr, disc));
    if (!live)
        return;
    const lanes rest = -lanes3_dot(l, d) * inv_dd, h = lanes_sqrt(disc * inv_dd);
    const lanes t0 = tp + (rest - h), t1 = tp + (rest + h);
    if (q->near) {
        const unsigned own = live & group_starts_on(i, q);
        const lanes bound = lanes_load(g->bound + i), r = lanes_splat(s->r);
        const lanes slack = lanes_splat(4) * r * (bound + lanes_splat(8 * PEN_U) * r);
        live &= ~(own & lanes_outward(lanes3_dot(f, d), f, d));
        ask = own | lane_mask_bits(lanes_at_most(lanes_abs(lanes3_dot(f, f) - rr), slack));
    }
    ask = live & (ask | lanes_refined(g, i, tp, h, disc, rr));
    live &= ~ask & lane_mask_bits(lanes_less(t0, t1));
    group_offer(g, i, live, t0, q->prim, PEN_PART_SIDE, q->see_through);
    group_offer(g, i, live, t1, q->prim, PEN_PART_SIDE, q->see_through);
    group_ask_all(g, i, ask, q->prim, true);
}

/* pen_plane_root with pen_dot_guarded, where that keeps its digits. */
static inline void group_test_plane_at(struct ray_group *g, int i, const struct pen_plane *p,
                                       const struct group_prim *q)
{
    const unsigned live = group_live(g, i) & ~group_starts_on(i, q);
    if (!live)
        return;
    const struct lanes3 n = group_splat(g, p->g), d = group_direction(g, i);
    const struct lanes3 f = lanes3_sub(group_splat(g, p->q), group_origin(g, i));
    const lanes gd = lanes3_dot(n, d), t = lanes3_dot(n, f) / gd;
    unsigned sure =
        lane_mask_bits(lanes_at_most(lanes3_dot_size(n, d), lanes_splat(8) * lanes_abs(gd)) &
                       lanes_less(lanes_load(g->near + i), lanes_splat(INFINITY)) &
                       lane_mask_not(lanes_equal(gd, lanes_splat(0))));
    if (g->from_surface) {
        /* A superset of the lanes that the ray's origin touches; |g| < 2. */
        const lanes bound = lanes_load(g->bound + i) + lanes_splat(8 * PEN_U) * lanes3_norm1(f);
        sure &= lane_mask_bits(lanes_less(lanes_splat(4) * bound, lanes_abs(t * gd)) &
                               lanes_less(lanes_load(g->near_sq + i), t * t));
    }
    group_offer(g, i, live & sure, t, q->prim, PEN_PART_SIDE, q->see_through);
    group_ask_all(g, i, live & ~sure, q->prim, q->near);
}

/* The intersections of lines with a cylinder, continued without end, and with its slab. */
struct lanes_cylinder {
    lanes t0, t1;      /* pen_cylinder_side_roots */
    lanes lo, hi;      /* pen_cylinder_slab */
    lanes nn, fa;      /* squared distance from the axis times |a|^2; height times |a| */
    unsigned up;       /* from the base to the top */
    unsigned maybe;    /* the others surely miss the side */
    unsigned special;  /* parallel to the side or the caps, or pen_dot_guarded compensates */
    unsigned refined;  /* lanes whose side the scalar function refines */
    unsigned loses;    /* lanes whose slab it refines */
    lanes least, most; /* bounds of the refined interval inside the side */
    lanes pad;         /* more than the rounding of lo and hi */
};

static inline void group_cylinder_side(const struct ray_group *g, int i,
                                       const struct pen_cylinder *c, struct lanes_cylinder *out)
{
    const struct lanes3 o = group_origin(g, i), d = group_direction(g, i),
                        q = group_splat(g, c->round.q), a = group_splat(g, c->round.a),
                        f = lanes3_sub(o, q), low = lanes3_difference_error(o, q, f);
    const struct lanes3 rest3 = {low.y * a.z - low.z * a.y, low.z * a.x - low.x * a.z,
                                 low.x * a.y - low.y * a.x};
    const struct lanes3 m = lanes3_cross(d, a), n = lanes3_add(lanes3_cross(f, a), rest3);
    const lanes mm = lanes3_dot(m, m), inv = lanes_splat(1) / mm, rr = lanes_splat(c->round.rr);
    const lanes tp = -lanes3_dot(m, n) * inv;
    const struct lanes3 l = lanes3_along_once(n, m, tp);
    const lanes disc = (rr - lanes3_dot(l, l)) + lanes_splat(c->round.rr_low);
    const lanes rest = -lanes3_dot(l, m) * inv, h = lanes_sqrt(disc * inv);
    const unsigned parallel = lane_mask_bits(lanes_equal(mm, lanes_splat(0)));
    out->maybe = parallel | lane_mask_bits(lanes_less(lanes_splat(-PEN_GRAZING) * rr, disc));
    out->t0 = tp + (rest - h);
    out->t1 = tp + (rest + h);
    out->nn = lanes3_dot(n, n);
    out->refined = lanes_refined(g, i, tp, h, disc, rr);
    /* The half chord is at most r / |m|. */
    const lanes reach = lanes_sqrt(lanes_splat(2) * rr * inv);
    out->least = tp - reach;
    out->most = tp + reach;
    out->special = parallel;
}

static inline void group_cylinder_slab(const struct ray_group *g, int i,
                                       const struct pen_cylinder *c, struct lanes_cylinder *out)
{
    const struct lanes3 d = group_direction(g, i), a = group_splat(g, c->round.a),
                        f = lanes3_sub(group_origin(g, i), group_splat(g, c->round.q));
    const lanes da = lanes3_dot(d, a), fa = lanes3_dot(f, a), inv = lanes_splat(1) / da;
    const lanes base = (lanes_splat(c->slab_base) - fa) * inv;
    const lanes top = (lanes_splat(c->slab_top) - fa) * inv, four = lanes_splat(4);
    const lane_mask up = lanes_less(lanes_splat(0), da);
    const lanes d_size = lanes3_dot_size(d, a), f_size = lanes3_dot_size(f, a);
    const lanes rest = lanes_abs(lanes_splat(c->slab_top) - fa);
    const lanes least = lanes_min(rest, lanes_abs(fa)), steep = lanes_abs(da);
    out->fa = fa;
    out->up = lane_mask_bits(up);
    out->lo = lanes_select(up, base, top);
    out->hi = lanes_select(up, top, base);
    out->special |= lane_mask_bits(lanes_equal(da, lanes_splat(0))) |
                    (LANES_ALL & ~lane_mask_bits(lanes_at_most(d_size, lanes_splat(8) * steep)));
    out->loses =
        lane_mask_bits(lanes_less(four * least, f_size) |
                       lanes_less(four * rest, lanes_splat(c->slab_top)) |
                       lanes_less(four * steep, d_size)) |
        (LANES_ALL & ~lane_mask_bits(lanes_less(lanes_load(g->near + i), lanes_splat(INFINITY))));
    out->pad = lanes_splat(0x1p-40) * (f_size + lanes_splat(c->slab_top)) * lanes_abs(inv);
}

/* Lanes whose interval may overlap the query's. Ends may be NaN where there is no bound. */
static inline unsigned group_overlaps(const struct ray_group *g, int i, lanes t0, lanes t1)
{
    return LANES_ALL &
           ~lane_mask_bits(lanes_less(t1, t0) | lanes_less(lanes_load(g->tmax + i), t0) |
                           lanes_less(t1, lanes_load(g->after_t + i)));
}

/* A superset of the lanes whose origin is on the cylinder, or that may pass its open rim near
 * their origin: pen_cylinder_touches, with |a| < 2; may_pass_rim. */
static inline unsigned group_at_cylinder(const struct ray_group *g, int i,
                                         const struct pen_cylinder *c,
                                         const struct lanes_cylinder *x)
{
    const double size = c->round.r + c->h + c->rim / (8 * PEN_U);
    const lanes bound = lanes_load(g->bound + i) + lanes_splat(8 * PEN_U * size);
    const lanes off = lanes_abs(x->nn - lanes_splat(c->round.rr)), twice = lanes_splat(2) * bound;
    const lanes least = lanes_min(x->t0 * x->t0, x->t1 * x->t1);
    const lanes off_base = lanes_abs(lanes_splat(c->slab_base) - x->fa);
    const lanes off_top = lanes_abs(lanes_splat(c->slab_top) - x->fa);
    unsigned at = lane_mask_bits(lanes_at_most(off, lanes_splat(16 * size) * bound) |
                                 lanes_at_most(off_base, twice) | lanes_at_most(off_top, twice));
    if (!c->caps)
        at |= LANES_ALL & ~lane_mask_bits(lanes_less(lanes_load(g->near_sq + i), least));
    return at;
}

/* The ends of the rays' intervals inside: pen_interval_clip, one ray at a time. */
static inline void group_offer_inside(struct ray_group *g, int i, unsigned at,
                                      const struct pen_cylinder *c, const struct lanes_cylinder *x,
                                      const struct group_prim *q)
{
    const lane_mask enters = lanes_less(x->lo, x->t0), leaves = lanes_less(x->t1, x->hi);
    const lanes t0 = lanes_select(enters, x->t0, x->lo), t1 = lanes_select(leaves, x->t1, x->hi);
    const unsigned side0 = lane_mask_bits(enters), side1 = lane_mask_bits(leaves);
    group_offer(g, i, at & side0, t0, q->prim, PEN_PART_SIDE, q->see_through);
    group_offer(g, i, at & side1, t1, q->prim, PEN_PART_SIDE, q->see_through);
    if (!c->caps)
        return;
    group_offer(g, i, at & ~side0 & x->up, t0, q->prim, PEN_PART_BASE, q->see_through);
    group_offer(g, i, at & ~side0 & ~x->up, t0, q->prim, PEN_PART_TOP, q->see_through);
    group_offer(g, i, at & ~side1 & x->up, t1, q->prim, PEN_PART_TOP, q->see_through);
    group_offer(g, i, at & ~side1 & ~x->up, t1, q->prim, PEN_PART_BASE, q->see_through);
}

/* Of the lanes that start on the cylinder, those that surely leave it: outward from the side, as
 * pen_cylinder_side_outward, or from a cap. */
static inline unsigned group_leaves_cylinder(const struct ray_group *g, int i,
                                             const struct pen_cylinder *c, unsigned own)
{
    const struct lanes3 d = group_direction(g, i), a = group_splat(g, c->round.a),
                        f = lanes3_sub(group_origin(g, i), group_splat(g, c->round.q));
    const lanes da = lanes3_dot(d, a), least = lanes_splat(0x1p-38) * lanes3_norm1(d);
    unsigned on[3] = {0, 0, 0};
    for (unsigned m = own; m; m &= m - 1) {
        const int lane = __builtin_ctz(m);
        on[g->origin[i + lane]->part] |= 1u << lane;
    }
    unsigned out = on[PEN_PART_BASE] & lane_mask_bits(lanes_less(da, -least));
    out |= on[PEN_PART_TOP] & lane_mask_bits(lanes_less(least, da));
    if (on[PEN_PART_SIDE])
        out |= on[PEN_PART_SIDE] &
               lanes_outward(lanes3_dot(d, f) * lanes3_dot(a, a) - da * lanes3_dot(f, a), f, d);
    return out;
}

static inline void group_test_cylinder_at(struct ray_group *g, int i, const struct pen_cylinder *c,
                                          const struct group_prim *q)
{
    struct lanes_cylinder x;
    unsigned live = group_live(g, i), ask = 0;
    if (!live)
        return;
    if (q->near) {
        ask = live & group_starts_on(i, q);
        live &= ~ask;
        if (ask)
            ask &= ~group_leaves_cylinder(g, i, c, ask);
    }
    group_cylinder_side(g, i, c, &x);
    live &= x.maybe;
    if (live) {
        group_cylinder_slab(g, i, c, &x);
        const lanes t0 = lanes_max(x.t0, x.lo), t1 = lanes_min(x.t1, x.hi);
        const unsigned met = lane_mask_bits(lanes_less(x.t0, x.t1) & lanes_less(t0, t1));
        unsigned unsure = x.special;
        if (q->near)
            unsure |= group_at_cylinder(g, i, c, &x);
        if (live & x.refined)
            unsure |= x.refined & group_overlaps(g, i, lanes_max(x.least, x.lo - x.pad),
                                                 lanes_min(x.most, x.hi + x.pad));
        if (live & x.loses)
            unsure |= x.loses & met & group_overlaps(g, i, t0 - x.pad, t1 + x.pad);
        ask |= live & unsure;
        group_offer_inside(g, i, live & met & ~unsure & ~x.refined, c, &x, q);
    }
    group_ask_all(g, i, ask, q->prim, true);
}

/* Tests a primitive against rays i to i + LANES - 1. */
static inline void group_test_at(struct ray_group *g, int i, struct pen_prim_ref ref,
                                 const struct group_prim *q)
{
    const struct pen_prims *prims = g->accel->prims;
    switch (pen_block_of(ref.kind)) {
    case PEN_BLOCK_SPHERES:
        group_test_sphere_at(g, i, &prims->sphere[ref.index], q);
        break;
    case PEN_BLOCK_CYLINDERS:
        group_test_cylinder_at(g, i, &prims->cylinder[ref.index], q);
        break;
    case PEN_BLOCK_PLANES:
        group_test_plane_at(g, i, &prims->plane[ref.index], q);
        break;
    case PEN_BLOCK_TRIANGLES:
    case PEN_BLOCK_POLYGONS:
    case PEN_BLOCK_INFINITE_CYLINDERS:
    case PEN_BLOCK_GENERIC:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        group_ask_all(g, i, group_live(g, i), q->prim, true);
        break;
    }
}

/* Tests a primitive against all live rays. */
static inline void group_test(struct ray_group *g, const struct group_prim *q)
{
    const struct pen_prims *prims = g->accel->prims;
    const struct pen_prim_ref ref = prims->ref[q->prim];
    if (ref.kind == PEN_PRIM_TRIANGLE) {
        const struct pen_triangle *t = &prims->triangle[ref.index];
        const struct group_outline outline = {t->v, 3, &t->facet, true, 0};
        group_test_outline(g, &outline, q);
    } else if (ref.kind == PEN_PRIM_POLYGON && !prims->polygon[ref.index].piece) {
        const struct pen_polygon *p = &prims->polygon[ref.index];
        const struct group_outline outline = {p->v, p->count, &p->facet, g->accel->convex[q->prim],
                                              p->extent};
        group_test_outline(g, &outline, q);
    } else {
        for (int i = 0; i < g->count; i += LANES)
            if (group_waits(g, i, q))
                group_test_at(g, i, ref, q);
    }
    g->live &= ~g->blocked;
}

#endif
