/* SPDX-License-Identifier: MIT */
/* Tests of one primitive against the rays of a group, LANES at a time, in binary64. Every lane does
 * the operations of the primitive's header in geom in the same order, so t has the same bits; the
 * comment of a small function names the scalar function that it computes. A lane in which the
 * quick operations may not be those that the scalar test ends with (it refines, the
 * self-intersection rule decides, the light may be on the primitive, two products tie) is *asked*
 * of the scalar test instead. Asking one lane too many costs time and changes nothing. */
#ifndef PEN_ACCEL_INTERNAL_RAY_GROUP_TEST_H
#define PEN_ACCEL_INTERNAL_RAY_GROUP_TEST_H

#include "accel/internal/ray_group.h"

/* What a test knows of its primitive. */
struct group_prim {
    uint32_t prim;
    uint64_t rays;    /* the others surely miss it */
    bool near;        /* the origin of some ray may be on it, or on its border */
    bool see_through; /* a shadow ray passes through it */
    float depth;      /* no ray meets it at a smaller depth: beam_enters */
};

/* Of the rays from i on, those that start on the primitive. */
static inline unsigned group_starts_on(const struct ray_group *g, int i, const struct group_prim *q)
{
    return q->near ? group_own(g, i, q->prim) : 0;
}

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
        const unsigned own = live & group_own(g, i, q->prim);
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

/* pen_shear */
static inline struct lanes3 group_shear(const struct ray_group *g, int i, struct pen_vec3 v)
{
    struct lanes3 f = lanes3_sub(group_splat(g, v), group_origin(g, i));
    f.x = f.x - lanes_load(g->sx + i) * f.z;
    f.y = f.y - lanes_load(g->sy + i) * f.z;
    return f;
}

/* What a line is to an outline. */
struct lanes_winding {
    unsigned inside; /* right except in `ties` */
    unsigned ties;   /* two products round to the same number: their order is not known */
    unsigned border; /* a superset of those whose origin is on the border */
};

/* A superset of the lanes whose edge from a to b passes within `slack` of the ray's origin. In ray
 * space the shear at most doubles distances across the ray. An edge that is a single point there
 * has a neighbour that is not, and that passes as near. */
static inline unsigned edge_passes_origins(const struct ray_group *g, int i, struct lanes3 a,
                                           struct lanes3 b)
{
    const lanes size = lanes_abs(b.x - a.x) + lanes_abs(b.y - a.y);
    const lanes slack = lanes_splat(16) * lanes_load(g->slack + i);
    return lane_mask_bits(lanes_less(lanes_abs(a.x * b.y - a.y * b.x), slack * size));
}

/* pen_polygon_entered, pen_triangle_entered. Two products that round to different numbers are in
 * that order too before rounding. */
static inline struct lanes_winding
group_winding(const struct ray_group *g, int i, const struct pen_vec3 *v, uint32_t count, bool near)
{
    const lanes zero = lanes_splat(0), one = lanes_splat(1);
    struct lanes_winding w = {0, 0, 0};
    lanes winding = zero;
    struct lanes3 a = group_shear(g, i, v[count - 1]);
    lane_mask a_low = lanes_at_most(a.y, zero);
    for (uint32_t k = 0; k < count; k++) {
        const struct lanes3 b = group_shear(g, i, v[k]);
        const lane_mask b_low = lanes_at_most(b.y, zero), passes = a_low ^ b_low;
        if (lane_mask_bits(passes)) {
            const lanes x = a.x * b.y, y = a.y * b.x;
            /* On the right: x > y for an upward edge, x < y for a downward one. */
            const lane_mask right = passes & lane_mask_not(lanes_less(y, x) ^ a_low);
            w.ties |= lane_mask_bits(passes & lanes_equal(x, y));
            winding = winding + lanes_select(right, lanes_select(a_low, one, -one), zero);
        }
        if (near)
            w.border |= edge_passes_origins(g, i, a, b);
        a = b;
        a_low = b_low;
    }
    w.inside = LANES_ALL & ~lane_mask_bits(lanes_equal(winding, zero));
    return w;
}

/* pen_facet_root, where it is not grazing. */
static inline lanes group_facet_root(const struct ray_group *g, int i,
                                     const struct pen_facet *facet)
{
    const struct lanes3 o = group_origin(g, i), d = group_direction(g, i);
    const struct lanes3 n = group_splat(g, facet->g), low = group_splat(g, facet->g_low);
    const struct lanes3 minus = {-n.x, -n.y, -n.z};
    const lanes along = lanes3_dot2_plus(lanes_splat(0), n, d, lanes3_dot(low, d));
    return lanes3_dot2_plus(lanes_splat(facet->c), minus, o,
                            lanes_splat(facet->c_low) - lanes3_dot(low, o)) /
           along;
}

/* As offer_outline, for lanes that pass inside. */
static inline void group_offer_facet(struct ray_group *g, int i, unsigned inside,
                                     const struct pen_facet *facet, const struct group_prim *q)
{
    const struct lanes3 o = group_origin(g, i), d = group_direction(g, i),
                        n = group_splat(g, facet->g);
    const lanes above = lanes_splat(facet->c) - lanes3_dot(n, o), along = lanes3_dot(n, d);
    const lanes size = lanes_splat(fabs(facet->c)) + lanes3_norm1(o);
    const lanes t = above / along, tmax = lanes_load(g->tmax + i);
    const lanes bound = lanes_load(g->bound + i), near_sq = lanes_load(g->near_sq + i);
    const lanes slack = lanes_splat(2) * bound + lanes_splat(16 * PEN_U * g->accel->scale);
    const lanes more = lanes_splat(1.0000001), dn = lanes3_dot(d, group_splat(g, facet->n));
    /* pen_facet_root_roughly is sure, starts_off, and beyond the rule's reach. */
    unsigned sure = lane_mask_bits(
        lanes_at_most(lanes_splat(0x1p-16) * size, lanes_abs(above)) &
        lanes_at_most(lanes_splat(2 * facet->grazing) * lanes_abs(d.z), lanes_abs(along)));
    if (g->from_surface)
        sure &= lane_mask_bits(lanes_less(slack, lanes_abs(t * dn)) &
                               lanes_less(more * near_sq, t * t));
    const unsigned ask = inside & ~sure;
    unsigned ahead = inside & sure &
                     lane_mask_bits(lanes_less(lanes_splat(0), t) & lanes_at_most(t, more * tmax));
    if (g->any && !q->see_through) {
        const unsigned ends = lane_mask_bits(lanes_less(more * t, tmax));
        g->blocked |= (uint64_t)(ahead & ends) << i;
        ahead &= ~ends;
    }
    if (ahead)
        group_offer(g, i, ahead, group_facet_root(g, i, facet), q->prim, PEN_PART_SIDE,
                    q->see_through);
    group_ask_all(g, i, ask, q->prim, q->near);
}

static inline void group_test_outline_at(struct ray_group *g, int i, const struct pen_vec3 *v,
                                         uint32_t count, const struct pen_facet *facet,
                                         const struct group_prim *q)
{
    unsigned live = group_live(g, i) & ~group_starts_on(g, i, q);
    if (!live)
        return;
    const struct lanes_winding w = group_winding(g, i, v, count, q->near);
    const unsigned ask = live & (w.ties | w.border);
    if (live & w.inside & ~ask)
        group_offer_facet(g, i, live & w.inside & ~ask, facet, q);
    group_ask_all(g, i, ask, q->prim, q->near);
}

/* pen_plane_root with pen_dot_guarded, where that keeps its digits. */
static inline void group_test_plane_at(struct ray_group *g, int i, const struct pen_plane *p,
                                       const struct group_prim *q)
{
    const unsigned live = group_live(g, i) & ~group_starts_on(g, i, q);
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
        ask = live & group_own(g, i, q->prim);
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
    case PEN_BLOCK_TRIANGLES: {
        const struct pen_triangle *t = &prims->triangle[ref.index];
        group_test_outline_at(g, i, t->v, 3, &t->facet, q);
        break;
    }
    case PEN_BLOCK_POLYGONS: {
        const struct pen_polygon *p = &prims->polygon[ref.index];
        if (p->piece)
            group_ask_all(g, i, group_live(g, i), q->prim, true);
        else
            group_test_outline_at(g, i, p->v, p->count, &p->facet, q);
        break;
    }
    case PEN_BLOCK_INFINITE_CYLINDERS:
    case PEN_BLOCK_GENERIC:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        group_ask_all(g, i, group_live(g, i), q->prim, true);
        break;
    }
}

/* Of the rays from i on, whether some may still meet what lies at this depth or beyond. */
static inline bool group_reaches(const struct ray_group *g, int i, double depth)
{
    const lanes most = lanes_load(g->tmax + i) * lanes_abs(lanes_load(g->d[2] + i));
    return lane_mask_bits(lanes_at_most(lanes_splat(depth), lanes_splat(1.0000001) * most));
}

/* Tests a primitive against all live rays. */
static inline void group_test(struct ray_group *g, const struct group_prim *q)
{
    const struct pen_prim_ref ref = g->accel->prims->ref[q->prim];
    for (int i = 0; i < g->count; i += LANES)
        if ((q->rays >> i & 1) && group_live(g, i) &&
            (q->depth <= 0 || group_reaches(g, i, (double)q->depth)))
            group_test_at(g, i, ref, q);
    g->live &= ~g->blocked;
}

#endif
