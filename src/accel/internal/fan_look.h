/* SPDX-License-Identifier: MIT */
/* Holds rays of a fan against its gates, four at a time, and casts those that must be asked. */
#ifndef PEN_ACCEL_INTERNAL_FAN_LOOK_H
#define PEN_ACCEL_INTERNAL_FAN_LOOK_H

#include "accel/internal/fan_walk.h"

/* Rays that surely cross a gate's body before they end, surely do not, surely do so once, twice. */
struct verdict {
    mask4 hit, miss, once, twice;
};

static inline void look_at_lines(const struct pen_gate *gate, const double4 *a, const double4 *b,
                                 struct verdict *out)
{
    out->hit = (mask4){-1, -1, -1, -1};
    out->miss = out->twice = (mask4){0, 0, 0, 0};
    for (int i = 0; i < gate->lines; i++) {
        const struct pen_fan_line *line = &gate->line[i];
        double4 e = line->e + *a * line->u + *b * line->v;
        out->hit &= e > line->band;
        out->miss |= e < -line->band;
    }
    if (gate->vague)
        out->hit = out->twice;
    out->once = out->hit;
}

/* On which side of a line a ray surely is. */
struct sides {
    mask4 above, below;
};

static inline void line_sides(const struct pen_fan_line *line, const double4 *a, const double4 *b,
                              struct sides *out)
{
    double4 e = line->e + *a * line->u + *b * line->v;
    out->above = e > line->band;
    out->below = e < -line->band;
}

/* See outline_gate. */
static inline void look_at_outline(const struct pen_gate *gate, const double4 *a, const double4 *b,
                                   struct verdict *out)
{
    struct sides plane, chord, edge, next;
    mask4 inside = {0, 0, 0, 0}, sure;
    line_sides(&gate->line[0], a, b, &plane);
    line_sides(&gate->line[1], a, b, &chord);
    sure = chord.above | chord.below;
    for (int i = 2; i + 1 < gate->lines; i += 2) {
        line_sides(&gate->line[i], a, b, &edge);
        line_sides(&gate->line[i + 1], a, b, &next);
        sure &= (edge.above | edge.below) & (next.above | next.below);
        inside ^= (chord.above & edge.above & next.below) | (chord.below & edge.below & next.above);
        chord = next;
    }
    out->hit = out->once = plane.above & sure & inside;
    out->miss = plane.below | (sure & ~inside);
    out->twice = (mask4){0, 0, 0, 0};
}

static inline void look_at_sphere(const struct pen_gate *gate, const double4 *a, const double4 *b,
                                  struct verdict *out)
{
    const struct pen_fan_line *g = &gate->line[0], *k = &gate->line[1], *d = &gate->line[2];
    double4 p = g->e + *a * g->u + *b * g->v;
    double4 dd = d->e + *a * *a * d->u + *b * *b * d->v;
    double4 f = p * p - k->e * dd;
    out->hit = out->twice = (f > k->band) & (p > 0);
    out->miss = (f < -k->band) | ((f > k->band) & (p < 0));
    out->once = (mask4){0, 0, 0, 0};
}

/* Crossings at lo and hi, lo < hi: whether each surely counts, or surely does not. */
struct ends {
    mask4 lo, no_lo, hi, no_hi;
};

/* Those before the ray begins, and after it ends, do not; nor does the one that it leaves, which
 * is at lo if the other is surely ahead. */
static inline void ends_in(const struct pen_gate *gate, const double4 *lo, const double4 *hi,
                           double end, struct ends *out)
{
    double4 lo_band = 0x1p-20 * (1 + ABS4(*lo)), hi_band = 0x1p-20 * (1 + ABS4(*hi));
    out->lo = (*lo > lo_band) & (*lo < end - lo_band);
    out->hi = (*hi > hi_band) & (*hi < end - hi_band);
    out->no_lo = (*lo < -lo_band) | (*lo > end + lo_band);
    out->no_hi = (*hi < -hi_band) | (*hi > end + hi_band);
    if (gate->own) {
        out->no_lo = *hi > hi_band;
        out->no_hi &= *hi > hi_band;
        out->lo = out->lo ^ out->lo;
    }
}

static inline void ends_verdict(const struct ends *e, const mask4 *sure, const mask4 *beside,
                                struct verdict *out)
{
    out->hit = *sure & (e->lo | e->hi);
    out->miss = *beside | (*sure & e->no_lo & e->no_hi);
    out->twice = *sure & e->lo & e->hi;
    out->once = *sure & ((e->lo & e->no_hi) | (e->no_lo & e->hi));
}

static inline void look_at_ball(const struct pen_gate *gate, const double4 *a, const double4 *b,
                                struct verdict *out)
{
    const struct pen_fan_line *g = &gate->line[0], *k = &gate->line[1], *d = &gate->line[2];
    double4 p = g->e + *a * g->u + *b * g->v;
    double4 dd = d->e + *a * *a * d->u + *b * *b * d->v;
    double4 f = p * p - k->e * dd, root = f, inv = 1 / dd;
    sqrt4(&root);
    double4 lo = (p - root) * inv, hi = (p + root) * inv;
    mask4 sure = f > k->band, beside = f < -k->band;
    struct ends e;
    ends_in(gate, &lo, &hi, d->band, &e);
    ends_verdict(&e, &sure, &beside, out);
}

/* Without caps, an end of the overlap that is the slab's is no crossing. One at a cap that the ray
 * runs along is not sure. */
static inline void look_at_cylinder(const struct pen_gate *gate, const double4 *a, const double4 *b,
                                    struct verdict *out)
{
    const struct pen_fan_line *la = &gate->line[0], *lb = &gate->line[1], *d = &gate->line[2];
    const struct pen_fan_line *side = &gate->line[3], *slab = &gate->line[4];
    double4 da = la->e + *a * la->u + *b * la->v, fd = lb->e + *a * lb->u + *b * lb->v;
    double4 dd = d->e + *a * *a * d->u + *b * *b * d->v, mm = dd - da * da;
    double4 disc = fd * fd - mm * side->e, size = fd * fd + mm * side->u, root = disc;
    mask4 oblique = mm > 0x1p-16 * dd, slanting = da * da > 0x1p-40 * dd;
    sqrt4(&root);
    double4 inv = 1 / mm, t0 = (-fd - root) * inv, t1 = (-fd + root) * inv;
    double4 sa = slab->e / da, sb = slab->u / da;
    double4 s0 = SELECT4(sa < sb, sa, sb), s1 = SELECT4(sa < sb, sb, sa);
    double4 lo = SELECT4(t0 > s0, t0, s0), hi = SELECT4(t1 < s1, t1, s1);
    double4 band = 0x1p-20 * (1 + ABS4(lo) + ABS4(hi));
    mask4 meets = oblique & (disc > 0x1p-20 * size), sure = meets & (hi - lo > band);
    mask4 beside = (oblique & (disc < -0x1p-20 * size)) | (meets & (hi - lo < -band));
    mask4 lo_side = t0 - s0 > band, lo_cap = t0 - s0 < -band;
    mask4 hi_side = s1 - t1 > band, hi_cap = s1 - t1 < -band;
    struct ends e;
    ends_in(gate, &lo, &hi, d->band, &e);
    if (slab->v > 0) {
        e.lo &= lo_side | (lo_cap & slanting);
        e.hi &= hi_side | (hi_cap & slanting);
    } else {
        e.lo &= lo_side;
        e.hi &= hi_side;
        e.no_lo |= lo_cap;
        e.no_hi |= hi_cap;
    }
    ends_verdict(&e, &sure, &beside, out);
}

/* The same in bits: one for each ray. */
struct verdicts {
    uint64_t hit, miss, once, twice;
};

/* Rays [0, n), but for groups of four that `done` has. */
static inline void fan_look_at(const struct pen_gate *gate, const double *a, const double *b, int n,
                               uint64_t done, struct verdicts *v)
{
    *v = (struct verdicts){0, 0, 0, 0};
    for (int i = 0; i < n; i += 4) {
        if ((done >> i & 15) == 15)
            continue;
        const double4 *a4 = (const double4 *)(a + i), *b4 = (const double4 *)(b + i);
        struct verdict out;
        if (gate->kind == PEN_GATE_LINES)
            look_at_lines(gate, a4, b4, &out);
        else if (gate->kind == PEN_GATE_OUTLINE)
            look_at_outline(gate, a4, b4, &out);
        else if (gate->kind == PEN_GATE_SPHERE)
            look_at_sphere(gate, a4, b4, &out);
        else if (gate->kind == PEN_GATE_BALL)
            look_at_ball(gate, a4, b4, &out);
        else
            look_at_cylinder(gate, a4, b4, &out);
        v->hit |= (uint64_t)mask4_bits(&out.hit) << i;
        v->miss |= (uint64_t)mask4_bits(&out.miss) << i;
        if (gate->opaque)
            continue;
        v->once |= (uint64_t)mask4_bits(&out.once) << i;
        v->twice |= (uint64_t)mask4_bits(&out.twice) << i;
    }
}

/* Opaque bodies: which rays are blocked. */
static inline uint64_t fan_look_opaque(struct pen_fan *fan, const double *a, const double *b, int n,
                                       uint64_t all)
{
    uint64_t blocked = 0;
    for (int i = 0; i < fan->gates && blocked != all; i++) {
        struct pen_gate *gate = &fan->gate[i];
        struct verdicts v;
        gate->ask = all;
        if (!gate->opaque || gate->kind == PEN_GATE_ASK)
            continue;
        fan_look_at(gate, a, b, n, blocked | ~all, &v);
        blocked |= v.hit & all;
        gate->ask = all & ~v.hit & ~v.miss;
        if (v.hit == all)
            fan->last_occluder = gate->prim;
    }
    return blocked;
}

/* Bodies that let light pass: which rays cross which, counted by two bits and one for more. A ray
 * that is asked is asked about all that it crosses. */
static inline uint64_t fan_look_tints(struct pen_fan *fan, const double *a, const double *b, int n,
                                      uint64_t open)
{
    uint64_t one = 0, two = 0, more = 0, ask = 0;
    for (int i = 0; i < fan->tints; i++) {
        struct pen_gate *gate = &fan->gate[fan->tint[i]];
        struct verdicts v = {0, 0, 0, 0};
        if (gate->kind != PEN_GATE_ASK)
            fan_look_at(gate, a, b, n, ~open, &v);
        gate->once = v.once & open;
        gate->twice = v.twice & open;
        gate->ask = open & ~(v.miss | v.once | v.twice);
        uint64_t carry = one & gate->once;
        one ^= gate->once;
        more |= (two & carry) | ((two ^ carry) & gate->twice);
        two = two ^ carry ^ gate->twice;
        ask |= gate->ask;
    }
    return ask | more | (one & two);
}

static uint64_t fan_look(struct pen_fan *fan, const double a[PEN_FAN_RAYS],
                         const double b[PEN_FAN_RAYS], int n, uint64_t *ask)
{
    uint64_t all = n < 64 ? (UINT64_C(1) << n) - 1 : UINT64_MAX;
    uint64_t blocked = fan_look_opaque(fan, a, b, n, all);
    *ask = 0;
    if (blocked == all)
        return blocked;
    *ask = fan_look_tints(fan, a, b, n, all & ~blocked);
    for (int i = 0; i < fan->gates; i++)
        if (fan->gate[i].opaque || fan->gate[i].kind == PEN_GATE_ASK)
            *ask |= fan->gate[i].ask;
    *ask &= ~blocked;
    for (int i = 0; *ask && i < fan->tints; i++) {
        struct pen_gate *gate = &fan->gate[fan->tint[i]];
        gate->ask |= *ask & (gate->once | gate->twice);
    }
    return blocked;
}

static bool fan_ray(const struct pen_accel *accel, const struct pen_fan *fan,
                    const struct pen_ray *ray, int i, struct pen_shadow *query)
{
    struct trace w = begin_shadow(accel, ray, fan->leave, query);
    for (int k = 0; k < fan->gates; k++) {
        const struct pen_gate *gate = &fan->gate[k];
        if (!(gate->ask >> i & 1))
            continue;
        if (gate->near ? test_at_origin(&w, gate->prim, true) : test_prim(&w, gate->prim, true))
            return true;
    }
    return false;
}

#endif
