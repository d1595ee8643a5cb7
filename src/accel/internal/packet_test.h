/* SPDX-License-Identifier: MIT */
/* Tests the rays of a packet against its candidates, four rays at a time, and traces those that
 * need the scalar fallback. */
#ifndef PEN_ACCEL_INTERNAL_PACKET_TEST_H
#define PEN_ACCEL_INTERNAL_PACKET_TEST_H

#include "accel/internal/packet_traverse.h"
#include "accel/internal/traverse_query.h"

/* Rays that surely hit the candidate's primitive before they end, that surely miss it, that surely
 * intersect it exactly once, and exactly twice. A ray in neither `hit` nor `miss` is not decided.
 */
struct verdict {
    mask4 hit, miss, once, twice;
};

static inline void classify_lines(const struct pen_candidate *candidate, const double4 *a,
                                  const double4 *b, struct verdict *out)
{
    out->hit = (mask4){-1, -1, -1, -1};
    out->miss = out->twice = (mask4){0, 0, 0, 0};
    for (int i = 0; i < candidate->lines; i++) {
        const struct pen_packet_line *line = &candidate->line[i];
        double4 e = line->e + *a * line->u + *b * line->v;
        out->hit &= e > line->band;
        out->miss |= e < -line->band;
    }
    if (candidate->plane_only)
        out->hit = out->twice;
    out->once = out->hit;
}

/* Rays that are surely on one side of a line. */
struct sides {
    mask4 above, below;
};

static inline void line_sides(const struct pen_packet_line *line, const double4 *a,
                              const double4 *b, struct sides *out)
{
    double4 e = line->e + *a * line->u + *b * line->v;
    out->above = e > line->band;
    out->below = e < -line->band;
}

/* See outline_candidate. */
static inline void classify_outline(const struct pen_candidate *candidate, const double4 *a,
                                    const double4 *b, struct verdict *out)
{
    struct sides plane, chord, edge, next;
    mask4 inside = {0, 0, 0, 0}, sure;
    line_sides(&candidate->line[0], a, b, &plane);
    line_sides(&candidate->line[1], a, b, &chord);
    sure = chord.above | chord.below;
    for (int i = 2; i + 1 < candidate->lines; i += 2) {
        line_sides(&candidate->line[i], a, b, &edge);
        line_sides(&candidate->line[i + 1], a, b, &next);
        sure &= (edge.above | edge.below) & (next.above | next.below);
        inside ^= (chord.above & edge.above & next.below) | (chord.below & edge.below & next.above);
        chord = next;
    }
    out->hit = out->once = plane.above & sure & inside;
    out->miss = plane.below | (sure & ~inside);
    out->twice = (mask4){0, 0, 0, 0};
}

static inline void classify_sphere_ahead(const struct pen_candidate *candidate, const double4 *a,
                                         const double4 *b, struct verdict *out)
{
    const struct pen_packet_line *g = &candidate->line[0], *k = &candidate->line[1],
                                 *d = &candidate->line[2];
    double4 p = g->e + *a * g->u + *b * g->v;
    double4 dd = d->e + *a * *a * d->u + *b * *b * d->v;
    double4 f = p * p - k->e * dd;
    out->hit = out->twice = (f > k->band) & (p > 0);
    out->miss = (f < -k->band) | ((f > k->band) & (p < 0));
    out->once = (mask4){0, 0, 0, 0};
}

/* Two intersections at lo < hi: whether each surely counts, or surely does not. */
struct ends {
    mask4 lo, no_lo, hi, no_hi;
};

/* An intersection before the ray begins or after it ends does not count. If the ray starts on the
 * primitive, neither does the intersection at its origin, which is lo if hi is surely ahead. */
static inline void ends_of(const struct pen_candidate *candidate, const double4 *lo,
                           const double4 *hi, double end, struct ends *out)
{
    double4 lo_band = 0x1p-20 * (1 + ABS4(*lo)), hi_band = 0x1p-20 * (1 + ABS4(*hi));
    out->lo = (*lo > lo_band) & (*lo < end - lo_band);
    out->hi = (*hi > hi_band) & (*hi < end - hi_band);
    out->no_lo = (*lo < -lo_band) | (*lo > end + lo_band);
    out->no_hi = (*hi < -hi_band) | (*hi > end + hi_band);
    if (candidate->is_origin) {
        out->no_lo = *hi > hi_band;
        out->no_hi &= *hi > hi_band;
        out->lo = out->lo ^ out->lo;
    }
}

static inline void verdict_of_ends(const struct ends *e, const mask4 *sure, const mask4 *beside,
                                   struct verdict *out)
{
    out->hit = *sure & (e->lo | e->hi);
    out->miss = *beside | (*sure & e->no_lo & e->no_hi);
    out->twice = *sure & e->lo & e->hi;
    out->once = *sure & ((e->lo & e->no_hi) | (e->no_lo & e->hi));
}

static inline void classify_sphere(const struct pen_candidate *candidate, const double4 *a,
                                   const double4 *b, struct verdict *out)
{
    const struct pen_packet_line *g = &candidate->line[0], *k = &candidate->line[1],
                                 *d = &candidate->line[2];
    double4 p = g->e + *a * g->u + *b * g->v;
    double4 dd = d->e + *a * *a * d->u + *b * *b * d->v;
    double4 f = p * p - k->e * dd, root = f, inv = 1 / dd;
    sqrt4(&root);
    double4 lo = (p - root) * inv, hi = (p + root) * inv;
    mask4 sure = f > k->band, beside = f < -k->band;
    struct ends e;
    ends_of(candidate, &lo, &hi, d->band, &e);
    verdict_of_ends(&e, &sure, &beside, out);
}

/* The lines are those of cylinder_lines, in packet_candidate.c. Without caps, an end of the overlap
 * that belongs to the slab is no intersection. One at a cap that the ray runs along is not sure. */
static inline void classify_cylinder(const struct pen_candidate *candidate, const double4 *a,
                                     const double4 *b, struct verdict *out)
{
    const struct pen_packet_line *la = &candidate->line[0], *lb = &candidate->line[1],
                                 *d = &candidate->line[2];
    const struct pen_packet_line *side = &candidate->line[3], *slab = &candidate->line[4];
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
    ends_of(candidate, &lo, &hi, d->band, &e);
    if (slab->v > 0) {
        e.lo &= lo_side | (lo_cap & slanting);
        e.hi &= hi_side | (hi_cap & slanting);
    } else {
        e.lo &= lo_side;
        e.hi &= hi_side;
        e.no_lo |= lo_cap;
        e.no_hi |= hi_cap;
    }
    verdict_of_ends(&e, &sure, &beside, out);
}

/* The same for a whole packet, a bit for each ray. */
struct verdicts {
    uint64_t hit, miss, once, twice;
};

/* Classifies rays 0 ... n - 1, without groups of four that are all in `done`. */
static inline void classify_rays(const struct pen_candidate *candidate, const double *a,
                                 const double *b, int n, uint64_t done, struct verdicts *v)
{
    *v = (struct verdicts){0, 0, 0, 0};
    for (int i = 0; i < n; i += 4) {
        if ((done >> i & 15) == 15)
            continue;
        const double4 *a4 = (const double4 *)(a + i), *b4 = (const double4 *)(b + i);
        struct verdict out;
        if (candidate->kind == PEN_CANDIDATE_LINES)
            classify_lines(candidate, a4, b4, &out);
        else if (candidate->kind == PEN_CANDIDATE_OUTLINE)
            classify_outline(candidate, a4, b4, &out);
        else if (candidate->kind == PEN_CANDIDATE_SPHERE_AHEAD)
            classify_sphere_ahead(candidate, a4, b4, &out);
        else if (candidate->kind == PEN_CANDIDATE_SPHERE)
            classify_sphere(candidate, a4, b4, &out);
        else
            classify_cylinder(candidate, a4, b4, &out);
        v->hit |= (uint64_t)mask4_bits(&out.hit) << i;
        v->miss |= (uint64_t)mask4_bits(&out.miss) << i;
        if (candidate->opaque)
            continue;
        v->once |= (uint64_t)mask4_bits(&out.once) << i;
        v->twice |= (uint64_t)mask4_bits(&out.twice) << i;
    }
}

/* Tests opaque candidates: returns the rays that are blocked. */
static inline uint64_t test_opaque(struct pen_shadow_packet *packet, const double *a,
                                   const double *b, int n, uint64_t all)
{
    uint64_t blocked = 0;
    for (int i = 0; i < packet->candidate_count && blocked != all; i++) {
        struct pen_candidate *candidate = &packet->candidate[i];
        struct verdicts v;
        candidate->fallback = all;
        if (!candidate->opaque || candidate->kind == PEN_CANDIDATE_FALLBACK)
            continue;
        classify_rays(candidate, a, b, n, blocked | ~all, &v);
        blocked |= v.hit & all;
        candidate->fallback = all & ~v.hit & ~v.miss;
        if (v.hit == all)
            packet->last_occluder = candidate->prim;
    }
    return blocked;
}

/* Tests candidates that let light pass, for the rays in `open`, and returns those that need the
 * scalar fallback: not decided, or intersecting more than twice in all, where the order of the
 * products matters. one, two, more: a counter of two bits per ray, and its overflow. */
static inline uint64_t test_transmissive(struct pen_shadow_packet *packet, const double *a,
                                         const double *b, int n, uint64_t open)
{
    uint64_t one = 0, two = 0, more = 0, fallback = 0;
    for (int i = 0; i < packet->transmissive_count; i++) {
        struct pen_candidate *candidate = &packet->candidate[packet->transmissive[i]];
        struct verdicts v = {0, 0, 0, 0};
        if (candidate->kind != PEN_CANDIDATE_FALLBACK)
            classify_rays(candidate, a, b, n, ~open, &v);
        candidate->once = v.once & open;
        candidate->twice = v.twice & open;
        candidate->fallback = open & ~(v.miss | v.once | v.twice);
        uint64_t carry = one & candidate->once;
        one ^= candidate->once;
        more |= (two & carry) | ((two ^ carry) & candidate->twice);
        two = two ^ carry ^ candidate->twice;
        fallback |= candidate->fallback;
    }
    return fallback | more | (one & two);
}

static uint64_t packet_test(struct pen_shadow_packet *packet, const double a[PEN_PACKET_RAYS],
                            const double b[PEN_PACKET_RAYS], int n, uint64_t *fallback)
{
    uint64_t all = n < 64 ? (UINT64_C(1) << n) - 1 : UINT64_MAX;
    uint64_t blocked = test_opaque(packet, a, b, n, all);
    *fallback = 0;
    if (blocked == all)
        return blocked;
    *fallback = test_transmissive(packet, a, b, n, all & ~blocked);
    for (int i = 0; i < packet->candidate_count; i++)
        if (packet->candidate[i].opaque || packet->candidate[i].kind == PEN_CANDIDATE_FALLBACK)
            *fallback |= packet->candidate[i].fallback;
    *fallback &= ~blocked;
    for (int i = 0; *fallback && i < packet->transmissive_count; i++) {
        struct pen_candidate *candidate = &packet->candidate[packet->transmissive[i]];
        candidate->fallback |= *fallback & (candidate->once | candidate->twice);
    }
    return blocked;
}

static bool packet_ray(const struct pen_accel *accel, const struct pen_shadow_packet *packet,
                       const struct pen_ray *ray, int i, struct pen_shadow *query)
{
    struct trace trace = trace_begin_shadow(accel, ray, packet->origin, query);
    for (int k = 0; k < packet->candidate_count; k++) {
        const struct pen_candidate *candidate = &packet->candidate[k];
        if (!(candidate->fallback >> i & 1))
            continue;
        if (candidate->by_reference ? test_reference(&trace, candidate->prim, true)
                                    : test_prim(&trace, candidate->prim, true))
            return true;
    }
    return false;
}

#endif
