/* SPDX-License-Identifier: MIT */
/* Holds rays of a fan against its gates, four at a time, and casts those that must be asked. */
#ifndef PEN_SRC_ACCEL_FAN_LOOK_H
#define PEN_SRC_ACCEL_FAN_LOOK_H

#include "fan_walk.h"

/* Rays that surely meet a gate's body, and rays that surely do not. */
struct verdict {
    mask4 hit, miss;
};

static inline void look_at_lines(const struct pen_gate *gate, const double4 *a, const double4 *b,
                                 struct verdict *out)
{
    out->hit = (mask4){-1, -1, -1, -1};
    out->miss = (mask4){0, 0, 0, 0};
    for (int i = 0; i < gate->lines; i++) {
        const struct pen_fan_line *line = &gate->line[i];
        double4 e = line->e + *a * line->u + *b * line->v;
        out->hit &= e > line->band;
        out->miss |= e < -line->band;
    }
}

static inline void look_at_sphere(const struct pen_gate *gate, const double4 *a, const double4 *b,
                                  struct verdict *out)
{
    const struct pen_fan_line *g = &gate->line[0], *tangent = &gate->line[1], *d = &gate->line[2];
    double4 p = g->e + *a * g->u + *b * g->v;
    double4 dd = d->e + *a * *a * d->u + *b * *b * d->v;
    double4 f = p * p - tangent->e * dd;
    out->hit = (f > tangent->band) & (p > 0);
    out->miss = (f < -tangent->band) | ((f > tangent->band) & (p < 0));
}

static inline void look_at_cylinder(const struct pen_gate *gate, const double4 *a, const double4 *b,
                                    struct verdict *out)
{
    const struct pen_fan_line *la = &gate->line[0], *lb = &gate->line[1], *d = &gate->line[2];
    const struct pen_fan_line *side = &gate->line[3], *slab = &gate->line[4];
    double4 da = la->e + *a * la->u + *b * la->v, fd = lb->e + *a * lb->u + *b * lb->v;
    double4 dd = d->e + *a * *a * d->u + *b * *b * d->v, mm = dd - da * da;
    double4 disc = fd * fd - mm * side->e, size = fd * fd + mm * side->u, root = disc;
    mask4 oblique = mm > 0x1p-16 * dd;
    sqrt4(&root);
    double4 inv = 1 / mm, t0 = (-fd - root) * inv, t1 = (-fd + root) * inv;
    double4 sa = slab->e / da, sb = slab->u / da;
    double4 s0 = SELECT4(sa < sb, sa, sb), s1 = SELECT4(sa < sb, sb, sa);
    double4 lo = SELECT4(t0 > s0, t0, s0), hi = SELECT4(t1 < s1, t1, s1);
    double4 band = 0x1p-20 * (1 + ABS4(lo) + ABS4(hi));
    mask4 sure = oblique & (disc > 0x1p-20 * size);
    out->hit = sure & (hi - lo > band) & (lo > band) & (lo < slab->v - band);
    out->miss = (oblique & (disc < -0x1p-20 * size)) |
                (sure & ((hi - lo < -band) | (hi < -band) | (lo > slab->v + band)));
}

/* Rays [0, n): *hit and *miss get a bit each. Rays that `done` has are left out. */
static inline void fan_look_at(const struct pen_gate *gate, const double *a, const double *b, int n,
                               uint64_t done, uint64_t verdict[2])
{
    verdict[0] = verdict[1] = 0;
    for (int i = 0; i < n; i += 4) {
        if ((done >> i & 15) == 15)
            continue;
        const double4 *a4 = (const double4 *)(a + i), *b4 = (const double4 *)(b + i);
        struct verdict out;
        if (gate->kind == PEN_GATE_LINES)
            look_at_lines(gate, a4, b4, &out);
        else if (gate->kind == PEN_GATE_SPHERE)
            look_at_sphere(gate, a4, b4, &out);
        else
            look_at_cylinder(gate, a4, b4, &out);
        verdict[0] |= (uint64_t)mask4_bits(&out.hit) << i;
        verdict[1] |= (uint64_t)mask4_bits(&out.miss) << i;
    }
}

static uint64_t fan_look(struct pen_fan *fan, const double a[PEN_FAN_RAYS],
                         const double b[PEN_FAN_RAYS], int n, uint64_t *ask)
{
    uint64_t all = n < 64 ? (UINT64_C(1) << n) - 1 : UINT64_MAX, blocked = 0, verdict[2];
    *ask = 0;
    for (int i = 0; i < fan->gates; i++) {
        struct pen_gate *gate = &fan->gate[i];
        gate->ask = all;
        if (!gate->opaque || gate->kind == PEN_GATE_ASK)
            continue;
        fan_look_at(gate, a, b, n, blocked | ~all, verdict);
        blocked |= verdict[0] & all;
        gate->ask = all & ~verdict[0] & ~verdict[1];
        if (verdict[0] == all)
            fan->last_occluder = gate->prim;
    }
    for (int i = 0; i < fan->gates && blocked != all; i++) {
        struct pen_gate *gate = &fan->gate[i];
        if (!gate->opaque && gate->kind != PEN_GATE_ASK) {
            fan_look_at(gate, a, b, n, blocked | ~all, verdict);
            gate->ask = all & ~verdict[1];
        }
        *ask |= gate->ask;
    }
    *ask &= ~blocked;
    return blocked;
}

static bool fan_ray(const struct pen_accel *accel, const struct pen_fan *fan,
                    const struct pen_ray *ray, int i, struct pen_shadow *query)
{
    struct trace w = begin(accel, ray, fan->leave);
    w.shadow = query;
    if (query->to_point) {
        w.light_bound = pen_shadow_light_bound(ray);
        w.light = pen_along(ray->o, ray->d, query->tmax);
    }
    query->count = 0;
    query->overflow = false;
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
