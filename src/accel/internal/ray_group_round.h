/* SPDX-License-Identifier: MIT */
/* Tests of spheres and cylinders against the rays of a group.
 *
 * Most lanes in which the scalar test refines its roots need no fallback, because refinement does
 * not change their answer. The ray certainly misses, meets the surface only behind its origin or
 * beyond its best intersection, or is certainly blocked. Let n be the vector from the centre to the
 * ray's origin; for a cylinder, its component across the axis, times |a|. m is the direction, or
 * its component across the axis times |a|. R is the radius, times |a|; u = 2^-53. The middle and
 * the half chord of the quadratic equation are
 *
 *   tp = -m.n / m.m,  h = sqrt(D / m.m),  D = R^2 - |l|^2,  l = n + tp m
 *
 * n and m are known to 4 u of themselves in each component. So l is off by at most 20 u |n| + u |l|
 * across m, D by 2^-44 (|n|^2 + R^2), and tp with its correction by 2^-47 (|n| + R) / |m|. Refined
 * roots are within 4 u of the true ones. So if h is larger than
 *
 *   e = 2^-42 (|n|^2 + R^2) / (|m|^2 h)
 *
 * there are two roots, each off by less than e. Proof: the error of D moves h by half as much over
 * |m|^2 h, and |n| + R and |m| h are below 1.5 sqrt(|n|^2 + R^2). Otherwise the true h^2 is below
 * 2^-41 (|n|^2 + R^2) / |m|^2. Then the roots, if any, are within 2^-20 times the root of that
 * quotient of tp. */
#ifndef PEN_ACCEL_INTERNAL_RAY_GROUP_ROUND_H
#define PEN_ACCEL_INTERNAL_RAY_GROUP_ROUND_H

#include "accel/internal/ray_group.h"

/* The intersections of lines with a round side, and bounds of the refined ones. */
struct lanes_roots {
    lanes t0, t1;
    unsigned refined;                           /* lanes that the scalar function refines */
    lanes t0_least, t0_most, t1_least, t1_most; /* bounds, in these lanes */
    unsigned two;                               /* lanes that certainly have two roots */
};

/* Lanes that certainly go outward from a round side that they start on, so that they do not meet it
 * again. f is the outward normal at the origin, not normalised. */
static inline unsigned lanes_outward(lanes outward, struct lanes3 f, struct lanes3 d)
{
    return lane_mask_bits(
        lanes_less(lanes_splat(0x1p-38) * (lanes3_norm1(f) * lanes3_norm1(d)), outward));
}

/* Lanes whose roots the scalar function refines. */
static inline unsigned lanes_refined(const struct ray_group *g, int i, lanes tp, lanes h,
                                     lanes disc, lanes rr)
{
    const lanes near = lanes_load(g->rays->near + i);
    return lane_mask_bits(lanes_less(lanes_abs(lanes_abs(tp) - h), near * h) |
                          lanes_less(lanes_abs(disc), lanes_splat(PEN_GRAZING) * rr));
}

/* Bounds of refined roots. `size` is (|n|^2 + R^2) / |m|^2. */
static inline void lanes_bound_roots(struct lanes_roots *x, lanes tp, lanes h, lanes size)
{
    const lanes e = lanes_splat(0x1p-42) * size / h,
                reach = lanes_splat(0x1p-20) * lanes_sqrt(size);
    const lane_mask two = lanes_less(e, h);
    x->two = lane_mask_bits(two);
    x->t0_least = lanes_select(two, x->t0 - e, tp - reach);
    x->t0_most = lanes_select(two, x->t0 + e, tp + reach);
    x->t1_least = lanes_select(two, x->t1 - e, tp - reach);
    x->t1_most = lanes_select(two, x->t1 + e, tp + reach);
}

/* Where rays enter and leave a convex solid: bounds of both ends. */
struct lanes_inside {
    lanes in_least, in_most, out_least, out_most;
};

/* Lanes whose ends certainly do not matter: there are none, or both are behind the origin or beyond
 * the end of the query. */
static inline unsigned group_useless(const struct ray_group *g, int i, const struct lanes_inside *x)
{
    const lanes tmax = lanes_load(g->tmax + i), after = lanes_load(g->after_t + i);
    return lane_mask_bits(lanes_less(x->out_most, x->in_least) | lanes_less(tmax, x->in_least) |
                          lanes_less(x->out_most, after) |
                          (lanes_less(x->in_most, after) & lanes_less(tmax, x->out_least)));
}

/* Lanes in which a t between these bounds is certainly between the ends of the shadow ray. */
static inline unsigned group_between(const struct ray_group *g, int i, lanes least, lanes most)
{
    return lane_mask_bits(lanes_less(lanes_splat(0), least) &
                          lanes_less(most, lanes_load(g->tmax + i)));
}

/* Decides as many as possible of the lanes that the scalar test refines; returns the others. */
static inline unsigned group_decide_sphere(struct ray_group *g, int i, unsigned lanes_refined,
                                           const struct lanes_roots *x, const struct group_prim *q)
{
    const struct lanes_inside in = {x->t0_least, x->t0_most, x->t1_least, x->t1_most};
    lanes_refined &= ~group_useless(g, i, &in);
    if (g->any && !q->see_through) {
        const unsigned blocked = lanes_refined & x->two &
                                 (group_between(g, i, x->t0_least, x->t0_most) |
                                  group_between(g, i, x->t1_least, x->t1_most));
        g->blocked |= (uint64_t)blocked << i;
        lanes_refined &= ~blocked;
    }
    return lanes_refined;
}

/* A sphere in all lanes. */
struct group_sphere {
    struct lanes3 c;
    lanes rr, rr_low, r;
};

/* Of the lanes, those that start on the sphere or may touch it at their start, so that the
 * self-intersection rule decides. Lanes that certainly leave it are removed from *live. */
static inline unsigned group_at_sphere(const struct ray_group *g, int i,
                                       const struct group_sphere *s, struct lanes3 f,
                                       unsigned *live, const struct group_prim *q)
{
    const unsigned own = *live & group_starts_on(i, q);
    const lanes slack =
        lanes_splat(4) * s->r * (lanes_load(g->bound + i) + lanes_splat(8 * PEN_U) * s->r);
    *live &= ~(own & lanes_outward(lanes3_dot(f, group_direction(g, i)), f, group_direction(g, i)));
    return *live &
           (own | lane_mask_bits(lanes_at_most(lanes_abs(lanes3_dot(f, f) - s->rr), slack)));
}

/* pen_sphere_roots, for the rays from i on. */
static inline void group_test_sphere_at(struct ray_group *g, int i, const struct group_sphere *s,
                                        unsigned live, const struct group_prim *q)
{
    const struct lanes3 o = group_origin(g, i), d = group_direction(g, i), f = lanes3_sub(o, s->c),
                        low = lanes3_difference_error(o, s->c, f);
    const lanes inv_dd = lanes_load(g->rays->inv_dd + i), tp = -lanes3_dot(f, d) * inv_dd;
    const struct lanes3 l = lanes3_add(lanes3_along_once(f, d, tp), low);
    const lanes disc = (s->rr - lanes3_dot(l, l)) + s->rr_low;
    live &= lane_mask_bits(lanes_less(lanes_splat(-PEN_GRAZING) * s->rr, disc));
    if (!live)
        return;
    const lanes rest = -lanes3_dot(l, d) * inv_dd, h = lanes_sqrt(disc * inv_dd);
    struct lanes_roots x = {.t0 = tp + (rest - h), .t1 = tp + (rest + h)};
    unsigned fallback = q->near ? group_at_sphere(g, i, s, f, &live, q) : 0;
    x.refined = live & ~fallback & lanes_refined(g, i, tp, h, disc, s->rr);
    live &= ~fallback & ~x.refined & lane_mask_bits(lanes_less(x.t0, x.t1));
    if (x.refined) {
        lanes_bound_roots(&x, tp, h, (lanes3_dot(f, f) + s->rr) * inv_dd);
        fallback |= group_decide_sphere(g, i, x.refined, &x, q);
    }
    const struct group_ends ends = {.at = {live, live}, .t = {x.t0, x.t1}};
    group_offer_ends(g, i, &ends, q);
    group_fall_back_all(g, i, fallback, q->prim, true);
}

static inline void group_test_sphere(struct ray_group *g, const struct pen_sphere *s,
                                     const struct group_prim *q)
{
    const struct group_sphere all = {group_splat(g, s->c), lanes_splat(s->rr),
                                     lanes_splat(s->rr_low), lanes_splat(s->r)};
    for (int i = 0; i < g->end; i += LANES) {
        const unsigned live = group_waits(g, i, q);
        if (live)
            group_test_sphere_at(g, i, &all, live, q);
    }
}

/* A cylinder, in all lanes. */
struct group_cylinder {
    const struct pen_cylinder *c;
    struct lanes3 q, a;
    lanes rr, rr_low, base, top;
    lanes beyond, rounding; /* see group_passes: r^2 (1 + 1/16) and 2^-42 X */
};

/* The intersections of lines with the slab of a cylinder, and with its side continued without end.
 */
struct lanes_cylinder {
    struct lanes_roots side; /* pen_cylinder_side_roots */
    lanes lo, hi;            /* pen_cylinder_slab */
    lanes nn, fa;            /* squared distance from the axis times |a|^2; height times |a| */
    unsigned up;             /* from the base to the top */
    unsigned special;        /* parallel to the side or the caps, or pen_dot_guarded compensates */
    unsigned loses;          /* lanes in which pen_cylinder_slab is refined */
    lanes pad;               /* exceeds the rounding of lo and hi */
};

/* Lanes whose line certainly misses the side, by about a thirty-second of its radius r. The line
 * passes the axis at distance |f.m| / |m|, with m = d x a. X bounds coordinates; |d.z| and 1 bound
 * the components of d and a. So f.m is off by less than 72 u X |d.z|, and r |m| by 14 u X |d.z|,
 * since r is below 2 X. The scalar test's l is off by some 60 u X |a|, over |a| as m is here. The
 * code uses four times the sum. So the scalar test too finds D < -R^2 / 32: it does not refine, and
 * has no roots. */
static inline unsigned group_passes(const struct ray_group *g, int i,
                                    const struct group_cylinder *c, struct lanes3 f)
{
    const struct lanes3 d = group_direction(g, i), a = c->a;
    const struct lanes3 m = {lanes_fma(d.y, a.z, -(d.z * a.y)), lanes_fma(d.z, a.x, -(d.x * a.z)),
                             lanes_fma(d.x, a.y, -(d.y * a.x))};
    const lanes mm = lanes_fma(m.x, m.x, lanes_fma(m.y, m.y, m.z * m.z));
    const lanes fm = lanes_fma(f.x, m.x, lanes_fma(f.y, m.y, f.z * m.z));
    const lanes off = lanes_max(lanes_abs(fm) - c->rounding * lanes_abs(d.z), lanes_splat(0));
    return lane_mask_bits(lanes_less(c->beyond * mm, off * off));
}

/* Finds the side's roots. Returns the lanes that may have some. */
static inline unsigned group_cylinder_side(const struct ray_group *g, int i,
                                           const struct group_cylinder *c, struct lanes3 f,
                                           struct lanes_cylinder *out)
{
    const struct lanes3 o = group_origin(g, i), d = group_direction(g, i), a = c->a,
                        low = lanes3_difference_error(o, c->q, f);
    const struct lanes3 rest3 = {low.y * a.z - low.z * a.y, low.z * a.x - low.x * a.z,
                                 low.x * a.y - low.y * a.x};
    const struct lanes3 m = lanes3_cross(d, a), n = lanes3_add(lanes3_cross(f, a), rest3);
    const lanes mm = lanes3_dot(m, m), inv = lanes_splat(1) / mm;
    const lanes tp = -lanes3_dot(m, n) * inv;
    const struct lanes3 l = lanes3_along_once(n, m, tp);
    const lanes disc = (c->rr - lanes3_dot(l, l)) + c->rr_low;
    const unsigned parallel = lane_mask_bits(lanes_equal(mm, lanes_splat(0)));
    const lanes rest = -lanes3_dot(l, m) * inv, h = lanes_sqrt(disc * inv);
    struct lanes_roots *x = &out->side;
    x->t0 = tp + (rest - h);
    x->t1 = tp + (rest + h);
    x->refined = lanes_refined(g, i, tp, h, disc, c->rr);
    out->nn = lanes3_dot(n, n);
    out->special = parallel;
    lanes_bound_roots(x, tp, h, (out->nn + c->rr) * inv);
    return parallel | lane_mask_bits(lanes_less(lanes_splat(-PEN_GRAZING) * c->rr, disc));
}

static inline void group_cylinder_slab(const struct ray_group *g, int i,
                                       const struct group_cylinder *c, struct lanes3 f,
                                       struct lanes_cylinder *out)
{
    const struct lanes3 d = group_direction(g, i), a = c->a;
    const lanes da = lanes3_dot(d, a), fa = lanes3_dot(f, a), inv = lanes_splat(1) / da;
    const lanes base = (c->base - fa) * inv;
    const lanes top = (c->top - fa) * inv, four = lanes_splat(4);
    const lane_mask up = lanes_less(lanes_splat(0), da);
    const lanes d_size = lanes3_dot_size(d, a), f_size = lanes3_dot_size(f, a);
    const lanes rest = lanes_abs(c->top - fa);
    const lanes least = lanes_min(rest, lanes_abs(fa)), steep = lanes_abs(da);
    out->fa = fa;
    out->up = lane_mask_bits(up);
    out->lo = lanes_select(up, base, top);
    out->hi = lanes_select(up, top, base);
    const lanes edge_on = lanes_splat(PEN_EDGE_ON) * lanes_abs(d.z);
    out->special |= lane_mask_bits(lanes_at_most(steep, edge_on)) |
                    (LANES_ALL & ~lane_mask_bits(lanes_at_most(d_size, lanes_splat(8) * steep)));
    out->loses = lane_mask_bits(lanes_less(four * least, f_size) | lanes_less(four * rest, c->top) |
                                lanes_less(four * steep, d_size)) |
                 (LANES_ALL & ~lane_mask_bits(lanes_less(lanes_load(g->rays->near + i),
                                                         lanes_splat(INFINITY))));
    out->pad = lanes_splat(0x1p-40) * (f_size + c->top) * lanes_abs(inv);
}

/* A superset of the lanes whose origin is on the cylinder, or that may pass its open rim near their
 * origin: pen_cylinder_touches, with |a| < 2, and may_pass_rim if the line may miss the cylinder.
 */
static inline unsigned group_at_cylinder(const struct ray_group *g, int i,
                                         const struct pen_cylinder *c,
                                         const struct lanes_cylinder *x)
{
    const double size = c->round.r + c->h + c->rim / (8 * PEN_U);
    const lanes bound = lanes_load(g->bound + i) + lanes_splat(8 * PEN_U * size);
    const lanes off = lanes_abs(x->nn - lanes_splat(c->round.rr)), twice = lanes_splat(2) * bound;
    const lanes least = lanes_min(x->side.t0 * x->side.t0, x->side.t1 * x->side.t1);
    const lanes off_base = lanes_abs(lanes_splat(c->slab_base) - x->fa);
    const lanes off_top = lanes_abs(lanes_splat(c->slab_top) - x->fa);
    unsigned at = lane_mask_bits(lanes_at_most(off, lanes_splat(16 * size) * bound) |
                                 lanes_at_most(off_base, twice) | lanes_at_most(off_top, twice));
    if (!c->caps)
        at |= LANES_ALL & ~lane_mask_bits(lanes_less(lanes_load(g->near_sq + i), least));
    return at;
}

/* Of the lanes that start on the cylinder, those that certainly leave it: outward from the side, as
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
        on[g->packet->origin[i + lane]->part] |= 1u << lane;
    }
    unsigned out = on[PEN_PART_BASE] & lane_mask_bits(lanes_less(da, -least));
    out |= on[PEN_PART_TOP] & lane_mask_bits(lanes_less(least, da));
    if (on[PEN_PART_SIDE])
        out |= on[PEN_PART_SIDE] &
               lanes_outward(lanes3_dot(d, f) * lanes3_dot(a, a) - da * lanes3_dot(f, a), f, d);
    return out;
}

/* Offers the ends of the rays' intervals inside: pen_interval_clip. */
static inline void group_offer_inside(struct ray_group *g, int i, unsigned at,
                                      const struct group_cylinder *c,
                                      const struct lanes_cylinder *x, const struct group_prim *q)
{
    const lane_mask enters = lanes_less(x->lo, x->side.t0), leaves = lanes_less(x->side.t1, x->hi);
    const unsigned side0 = lane_mask_bits(enters), side1 = lane_mask_bits(leaves);
    const unsigned ends = c->c->caps ? LANES_ALL : 0;
    const struct group_ends e = {
        .at = {at & (side0 | ends), at & (side1 | ends)},
        .base = {~side0 & x->up, ~side1 & ~x->up},
        .top = {~side0 & ~x->up, ~side1 & x->up},
        .t = {lanes_select(enters, x->side.t0, x->lo), lanes_select(leaves, x->side.t1, x->hi)},
    };
    group_offer_ends(g, i, &e, q);
}

/* Lanes that leave the inside, at t or later, beyond the reach of the self-intersection rule: see
 * may_pass_rim. */
static inline unsigned group_leaves_far(const struct ray_group *g, int i, lanes t)
{
    return lane_mask_bits(lanes_less(lanes_splat(0), t) &
                          lanes_less(lanes_load(g->near_sq + i), t * t));
}

/* Decides as many as possible of the lanes in which the scalar test refines the roots of the side,
 * `refined`, or of the slab; returns the others. If rays may pass a rim near their origin, bounds
 * of two refined roots are not used, because the self-intersection rule may decide otherwise. */
static inline unsigned group_decide_cylinder(struct ray_group *g, int i, unsigned rays,
                                             const struct group_cylinder *c,
                                             const struct lanes_cylinder *x,
                                             const struct group_prim *q)
{
    const struct lanes_roots *s = &x->side;
    const lanes base = x->lo - x->pad, top = x->hi + x->pad;
    const lanes after_base = x->lo + x->pad, before_top = x->hi - x->pad;
    const struct lanes_inside in = {lanes_max(s->t0_least, base), lanes_max(s->t0_most, after_base),
                                    lanes_min(s->t1_least, before_top), lanes_min(s->t1_most, top)};
    rays &= ~group_useless(g, i, &in);
    if (!rays || !g->any || q->see_through || (q->near && !c->c->caps))
        return rays;
    unsigned enters = LANES_ALL, leaves = LANES_ALL;
    if (!c->c->caps) {
        enters = lane_mask_bits(lanes_less(after_base, s->t0_least));
        leaves = lane_mask_bits(lanes_less(s->t1_most, before_top));
    }
    unsigned blocked = rays & s->two & lane_mask_bits(lanes_less(in.in_most, in.out_least)) &
                       ((enters & group_between(g, i, in.in_least, in.in_most)) |
                        (leaves & group_between(g, i, in.out_least, in.out_most)));
    if (q->near)
        blocked &= group_leaves_far(g, i, in.out_least);
    g->blocked |= (uint64_t)blocked << i;
    return rays & ~blocked;
}

/* Lanes whose ends are certainly on the side, if the ends of the refined slab are within x->pad of
 * these. `first`: only the first end matters, if it is ahead. */
static inline unsigned group_ends_on_side(const struct ray_group *g, int i,
                                          const struct lanes_cylinder *x, bool first)
{
    const lanes before = x->hi - x->pad;
    lane_mask last = lanes_less(x->side.t1, before);
    if (first)
        last |= lanes_less(x->side.t0, before) & lanes_less(lanes_load(g->after_t + i), x->side.t0);
    return lane_mask_bits(lanes_less(x->lo + x->pad, x->side.t0) & last);
}

/* Tests the rays from i on that may meet the cylinder and do not start on it. */
static inline void group_test_cylinder_at(struct ray_group *g, int i,
                                          const struct group_cylinder *c, struct lanes3 f,
                                          unsigned live, const struct group_prim *q)
{
    struct lanes_cylinder x;
    live &= group_cylinder_side(g, i, c, f, &x);
    if (!live)
        return;
    group_cylinder_slab(g, i, c, f, &x);
    const lanes t0 = lanes_max(x.side.t0, x.lo), t1 = lanes_min(x.side.t1, x.hi);
    const unsigned met = lane_mask_bits(lanes_less(x.side.t0, x.side.t1) & lanes_less(t0, t1));
    unsigned fallback = live & x.special;
    if (q->near) {
        const unsigned ahead = met & lane_mask_bits(lanes_less(lanes_splat(0), t1));
        fallback |=
            live & (group_at_cylinder(g, i, c->c, &x) | (ahead & ~group_leaves_far(g, i, t1)));
    }
    unsigned refined = live & ~fallback & (x.side.refined | (x.loses & met));
    if (refined & ~x.side.refined)
        refined &= x.side.refined | ~group_ends_on_side(g, i, &x, !g->any && !q->near);
    if (refined)
        fallback |= group_decide_cylinder(g, i, refined, c, &x, q);
    group_offer_inside(g, i, live & met & ~(fallback | refined), c, &x, q);
    group_fall_back_all(g, i, fallback, q->prim, true);
}

static inline void group_test_cylinder(struct ray_group *g, const struct pen_cylinder *c,
                                       const struct group_prim *q)
{
    const struct group_cylinder all = {
        .c = c,
        .q = group_splat(g, c->round.q),
        .a = group_splat(g, c->round.a),
        .rr = lanes_splat(c->round.rr),
        .rr_low = lanes_splat(c->round.rr_low),
        .base = lanes_splat(c->slab_base),
        .top = lanes_splat(c->slab_top),
        .beyond = lanes_splat(1.0625 * c->round.r * c->round.r),
        .rounding = lanes_splat(0x1p-42 * g->extent),
    };
    for (int i = 0; i < g->end; i += LANES) {
        unsigned live = group_waits(g, i, q);
        if (!live)
            continue;
        const unsigned own = live & group_starts_on(i, q);
        if (own)
            group_fall_back_all(g, i, own & ~group_leaves_cylinder(g, i, c, own), q->prim, true);
        const struct lanes3 f = lanes3_sub(group_origin(g, i), all.q);
        live &= ~(own | group_passes(g, i, &all, f));
        if (live)
            group_test_cylinder_at(g, i, &all, f, live, q);
    }
}

#endif
