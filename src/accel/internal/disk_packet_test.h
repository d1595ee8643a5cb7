/* SPDX-License-Identifier: MIT */
/* Tests the rays of a disk packet against its candidates, LANES rays at a time, and traces those
 * that need the scalar fallback. */
#ifndef PEN_ACCEL_INTERNAL_DISK_PACKET_TEST_H
#define PEN_ACCEL_INTERNAL_DISK_PACKET_TEST_H

#include "accel/internal/disk_packet_traverse.h"
#include "accel/internal/traverse_query.h"
#include "math/lanes.h"

/* Rays that surely hit the candidate's primitive before they end, that surely miss it, that surely
 * intersect it exactly once, and exactly twice. A ray in neither `hit` nor `miss` is not decided.
 */
struct verdict {
    lane_mask hit, miss, once, twice;
};

/* Points of the disk. */
struct disk_points {
    lanes a, b;
};

static inline lanes line_at(const struct pen_disk_line *line, struct disk_points p)
{
    return line->e + p.a * line->u + p.b * line->v;
}

/* The squared length of the direction to a point of the disk, which u and v span: d.d. */
static inline lanes length_at(const struct pen_disk_line *line, struct disk_points p)
{
    return line->e + p.a * p.a * line->u + p.b * p.b * line->v;
}

static inline lane_mask lanes_above(lanes x, double bound)
{
    return lanes_less(lanes_splat(bound), x);
}

static inline lane_mask lanes_below(lanes x, double bound)
{
    return lanes_less(x, lanes_splat(bound));
}

static inline struct verdict classify_lines(const struct pen_disk_candidate *candidate,
                                            struct disk_points p)
{
    const lane_mask none = lane_mask_of(0);
    struct verdict out = {lane_mask_of(LANES_ALL), none, none, none};
    for (int i = 0; i < candidate->lines; i++) {
        const struct pen_disk_line *line = &candidate->line[i];
        const lanes e = line_at(line, p);
        out.hit &= lanes_above(e, line->band);
        out.miss |= lanes_below(e, -line->band);
    }
    if (candidate->plane_only)
        out.hit = none;
    out.once = out.hit;
    return out;
}

/* Rays that are surely on one side of a line. */
struct sides {
    lane_mask above, below;
};

static inline struct sides line_sides(const struct pen_disk_line *line, struct disk_points p)
{
    const lanes e = line_at(line, p);
    return (struct sides){lanes_above(e, line->band), lanes_below(e, -line->band)};
}

/* See outline_candidate. */
static inline struct verdict classify_outline(const struct pen_disk_candidate *candidate,
                                              struct disk_points p)
{
    const struct sides plane = line_sides(&candidate->line[0], p);
    struct sides chord = line_sides(&candidate->line[1], p);
    lane_mask inside = lane_mask_of(0), sure = chord.above | chord.below;
    for (int i = 2; i + 1 < candidate->lines; i += 2) {
        const struct sides edge = line_sides(&candidate->line[i], p);
        const struct sides next = line_sides(&candidate->line[i + 1], p);
        sure &= (edge.above | edge.below) & (next.above | next.below);
        inside ^= (chord.above & edge.above & next.below) | (chord.below & edge.below & next.above);
        chord = next;
    }
    const lane_mask hit = plane.above & sure & inside;
    return (struct verdict){.hit = hit,
                            .miss = plane.below | (sure & lane_mask_not(inside)),
                            .once = hit,
                            .twice = lane_mask_of(0)};
}

static inline struct verdict classify_sphere_ahead(const struct pen_disk_candidate *candidate,
                                                   struct disk_points at)
{
    const struct pen_disk_line *k = &candidate->line[1];
    const lanes p = line_at(&candidate->line[0], at), dd = length_at(&candidate->line[2], at);
    const lanes f = p * p - k->e * dd;
    const lane_mask hit = lanes_above(f, k->band) & lanes_above(p, 0);
    return (struct verdict){.hit = hit,
                            .miss = lanes_below(f, -k->band) |
                                    (lanes_above(f, k->band) & lanes_below(p, 0)),
                            .once = lane_mask_of(0),
                            .twice = hit};
}

/* Two intersections at lo < hi: whether each surely counts, or surely does not. */
struct ends {
    lane_mask lo, no_lo, hi, no_hi;
};

/* An intersection before the ray begins or after it ends does not count. If the ray starts on the
 * primitive, neither does the intersection at its origin, which is lo if hi is surely ahead. */
static inline struct ends ends_of(const struct pen_disk_candidate *candidate, lanes lo, lanes hi,
                                  double end)
{
    const lanes lo_band = 0x1p-20 * (1 + lanes_abs(lo)), hi_band = 0x1p-20 * (1 + lanes_abs(hi));
    struct ends e = {
        .lo = lanes_less(lo_band, lo) & lanes_less(lo, end - lo_band),
        .no_lo = lanes_less(lo, -lo_band) | lanes_less(end + lo_band, lo),
        .hi = lanes_less(hi_band, hi) & lanes_less(hi, end - hi_band),
        .no_hi = lanes_less(hi, -hi_band) | lanes_less(end + hi_band, hi),
    };
    if (candidate->is_origin) {
        e.no_lo = lanes_less(hi_band, hi);
        e.no_hi &= lanes_less(hi_band, hi);
        e.lo = lane_mask_of(0);
    }
    return e;
}

static inline struct verdict verdict_of_ends(const struct ends *e, lane_mask sure, lane_mask beside)
{
    return (struct verdict){.hit = sure & (e->lo | e->hi),
                            .miss = beside | (sure & e->no_lo & e->no_hi),
                            .once = sure & ((e->lo & e->no_hi) | (e->no_lo & e->hi)),
                            .twice = sure & e->lo & e->hi};
}

static inline struct verdict classify_sphere(const struct pen_disk_candidate *candidate,
                                             struct disk_points at)
{
    const struct pen_disk_line *k = &candidate->line[1], *d = &candidate->line[2];
    const lanes p = line_at(&candidate->line[0], at), dd = length_at(d, at);
    const lanes f = p * p - k->e * dd, root = lanes_sqrt(f), inv = 1 / dd;
    const struct ends e = ends_of(candidate, (p - root) * inv, (p + root) * inv, d->band);
    return verdict_of_ends(&e, lanes_above(f, k->band), lanes_below(f, -k->band));
}

/* The lines are those of cylinder_lines, in disk_candidate.c. Without caps, an end of the overlap
 * that belongs to the slab is no intersection. Where a ray runs along the caps, at a sine below
 * 2^-20, rounding decides where it passes their planes, and no hit is sure. */
static inline struct verdict classify_cylinder(const struct pen_disk_candidate *candidate,
                                               struct disk_points p)
{
    const struct pen_disk_line *d = &candidate->line[2];
    const struct pen_disk_line *side = &candidate->line[3], *slab = &candidate->line[4];
    const lanes da = line_at(&candidate->line[0], p), fd = line_at(&candidate->line[1], p);
    const lanes dd = length_at(d, p), mm = dd - da * da;
    const lanes disc = fd * fd - mm * side->e, size = fd * fd + mm * side->u;
    const lane_mask oblique = lanes_less(0x1p-16 * dd, mm);
    const lane_mask slanting = lanes_less(0x1p-40 * dd, da * da);
    const lanes root = lanes_sqrt(disc), inv = 1 / mm;
    const lanes t0 = (-fd - root) * inv, t1 = (-fd + root) * inv;
    const lanes sa = slab->e / da, sb = slab->u / da;
    const lanes s0 = lanes_min(sa, sb), s1 = lanes_max(sb, sa);
    const lanes lo = lanes_max(t0, s0), hi = lanes_min(t1, s1);
    const lanes band = 0x1p-20 * (1 + lanes_abs(lo) + lanes_abs(hi));
    const lane_mask meets = oblique & slanting & lanes_less(0x1p-20 * size, disc);
    const lane_mask beside =
        (oblique & lanes_less(disc, -0x1p-20 * size)) | (meets & lanes_less(hi - lo, -band));
    const lane_mask lo_side = lanes_less(band, t0 - s0), lo_cap = lanes_less(t0 - s0, -band);
    const lane_mask hi_side = lanes_less(band, s1 - t1), hi_cap = lanes_less(s1 - t1, -band);
    struct ends e = ends_of(candidate, lo, hi, d->band);
    if (slab->v > 0) {
        e.lo &= lo_side | lo_cap;
        e.hi &= hi_side | hi_cap;
    } else {
        e.lo &= lo_side;
        e.hi &= hi_side;
        e.no_lo |= lo_cap;
        e.no_hi |= hi_cap;
    }
    return verdict_of_ends(&e, meets & lanes_less(band, hi - lo), beside);
}

static inline struct verdict classify(const struct pen_disk_candidate *candidate,
                                      struct disk_points p)
{
    switch ((enum pen_disk_candidate_kind)candidate->kind) {
    case PEN_DISK_CANDIDATE_LINES:
        return classify_lines(candidate, p);
    case PEN_DISK_CANDIDATE_OUTLINE:
        return classify_outline(candidate, p);
    case PEN_DISK_CANDIDATE_SPHERE_AHEAD:
        return classify_sphere_ahead(candidate, p);
    case PEN_DISK_CANDIDATE_SPHERE:
        return classify_sphere(candidate, p);
    case PEN_DISK_CANDIDATE_CYLINDER:
        return classify_cylinder(candidate, p);
    case PEN_DISK_CANDIDATE_FALLBACK:
        break;
    }
    const lane_mask none = lane_mask_of(0);
    return (struct verdict){none, none, none, none};
}

/* The same for a whole packet, a bit for each ray. */
struct verdicts {
    uint64_t hit, miss, once, twice;
};

/* Classifies rays 0 ... n - 1, without groups of LANES that are all in `done`. */
static inline void classify_rays(const struct pen_disk_candidate *candidate, const double *a,
                                 const double *b, int n, uint64_t done, struct verdicts *v)
{
    *v = (struct verdicts){0, 0, 0, 0};
    for (int i = 0; i < n; i += LANES) {
        if ((done >> i & LANES_ALL) == LANES_ALL)
            continue;
        const struct disk_points p = {lanes_load(a + i), lanes_load(b + i)};
        const struct verdict out = classify(candidate, p);
        v->hit |= (uint64_t)lane_mask_bits(out.hit) << i;
        v->miss |= (uint64_t)lane_mask_bits(out.miss) << i;
        if (candidate->opaque)
            continue;
        v->once |= (uint64_t)lane_mask_bits(out.once) << i;
        v->twice |= (uint64_t)lane_mask_bits(out.twice) << i;
    }
}

/* Tests opaque candidates: returns the rays that are blocked. */
static inline uint64_t test_opaque(struct pen_disk_packet *packet, const double *a, const double *b,
                                   int n, uint64_t all)
{
    uint64_t blocked = 0;
    for (int i = 0; i < packet->candidate_count && blocked != all; i++) {
        struct pen_disk_candidate *candidate = &packet->candidate[i];
        struct verdicts v;
        candidate->fallback = all;
        if (!candidate->opaque || candidate->kind == PEN_DISK_CANDIDATE_FALLBACK)
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
static inline uint64_t test_transmissive(struct pen_disk_packet *packet, const double *a,
                                         const double *b, int n, uint64_t open)
{
    uint64_t one = 0, two = 0, more = 0, fallback = 0;
    for (int i = 0; i < packet->transmissive_count; i++) {
        struct pen_disk_candidate *candidate = &packet->candidate[packet->transmissive[i]];
        struct verdicts v = {0, 0, 0, 0};
        if (candidate->kind != PEN_DISK_CANDIDATE_FALLBACK)
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

static uint64_t disk_test(struct pen_disk_packet *packet, const double a[PEN_DISK_RAYS],
                          const double b[PEN_DISK_RAYS], int n, uint64_t *fallback)
{
    uint64_t all = n < 64 ? (UINT64_C(1) << n) - 1 : UINT64_MAX;
    uint64_t blocked = test_opaque(packet, a, b, n, all);
    *fallback = 0;
    if (blocked == all)
        return blocked;
    *fallback = test_transmissive(packet, a, b, n, all & ~blocked);
    for (int i = 0; i < packet->candidate_count; i++)
        if (packet->candidate[i].opaque || packet->candidate[i].kind == PEN_DISK_CANDIDATE_FALLBACK)
            *fallback |= packet->candidate[i].fallback;
    *fallback &= ~blocked;
    for (int i = 0; *fallback && i < packet->transmissive_count; i++) {
        struct pen_disk_candidate *candidate = &packet->candidate[packet->transmissive[i]];
        candidate->fallback |= *fallback & (candidate->once | candidate->twice);
    }
    return blocked;
}

static bool disk_ray(const struct pen_accel *accel, const struct pen_disk_packet *packet,
                     const struct pen_ray *ray, int i, struct pen_shadow *query)
{
    struct trace trace = trace_begin_shadow(accel, ray, packet->origin, query);
    for (int k = 0; k < packet->candidate_count; k++) {
        const struct pen_disk_candidate *candidate = &packet->candidate[k];
        if (!(candidate->fallback >> i & 1))
            continue;
        if (candidate->by_reference ? test_reference(&trace, candidate->prim, true)
                                    : test_prim(&trace, candidate->prim, true))
            return true;
    }
    return false;
}

#endif
