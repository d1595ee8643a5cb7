/* SPDX-License-Identifier: MIT */
/* Classifies LANES rays of a disk packet against a candidate: certain hit, certain miss, or
 * undecided because of rounding. */
#ifndef PEN_ACCEL_INTERNAL_DISK_PACKET_CLASSIFY_H
#define PEN_ACCEL_INTERNAL_DISK_PACKET_CLASSIFY_H

#include "accel/internal/disk_candidate.h"
#include "math/lanes.h"

/* Rays that certainly hit the candidate's primitive before they end, certainly miss it, certainly
 * intersect it exactly once, and exactly twice. A ray in neither `hit` nor `miss` is undecided. */
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

/* The squared length d.d of the direction to a point of the disk that u and v span. */
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

/* Rays that are certainly on one side of a line. */
struct sides {
    lane_mask above, below;
};

static inline struct sides line_sides(const struct pen_disk_line *line, struct disk_points p)
{
    const lanes e = line_at(line, p);
    return (struct sides){lanes_above(e, line->band), lanes_below(e, -line->band)};
}

/* For a flat primitive with any outline: see outline_candidate. */
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

/* Two intersections at lo < hi: the rays in which each certainly counts, and certainly does not. */
struct ends {
    lane_mask lo, no_lo, hi, no_hi;
};

/* An intersection before the ray begins or after it ends does not count. If the ray starts on the
 * primitive, the intersection at its origin does not count either; it is lo if hi is certainly
 * ahead. */
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

/* The intersections of rays with a solid, at lo < hi for rays that certainly meet it. */
struct chord {
    lanes lo, hi;
    struct ends ends;
    lane_mask meets, beside; /* both are certain; a ray in neither is undecided */
};

static inline struct verdict verdict_of_chord(const struct chord *c)
{
    const struct ends *e = &c->ends;
    return (struct verdict){.hit = c->meets & (e->lo | e->hi),
                            .miss = c->beside | (c->meets & e->no_lo & e->no_hi),
                            .once = c->meets & ((e->lo & e->no_hi) | (e->no_lo & e->hi)),
                            .twice = c->meets & e->lo & e->hi};
}

static inline struct chord sphere_chord(const struct pen_disk_candidate *candidate,
                                        struct disk_points at)
{
    const struct pen_disk_line *k = &candidate->line[1], *d = &candidate->line[2];
    const lanes p = line_at(&candidate->line[0], at), dd = length_at(d, at);
    const lanes f = p * p - k->e * dd, root = lanes_sqrt(f), inv = 1 / dd;
    const lanes lo = (p - root) * inv, hi = (p + root) * inv;
    return (struct chord){.lo = lo,
                          .hi = hi,
                          .ends = ends_of(candidate, lo, hi, d->band),
                          .meets = lanes_above(f, k->band),
                          .beside = lanes_below(f, -k->band)};
}

/* The chord in a cylinder. The lines are those of cylinder_lines in disk_candidate.c. Without caps,
 * an end of the overlap that belongs to the slab is no intersection. If a ray runs along the caps,
 * at a sine below 2^-20, rounding decides where it passes their planes; then no hit is certain. */
static inline struct chord cylinder_chord(const struct pen_disk_candidate *candidate,
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
    return (struct chord){.lo = lo,
                          .hi = hi,
                          .ends = e,
                          .meets = meets & lanes_less(band, hi - lo),
                          .beside = beside};
}

static inline struct verdict classify(const struct pen_disk_candidate *candidate,
                                      struct disk_points p)
{
    struct chord chord;
    switch ((enum pen_disk_candidate_kind)candidate->kind) {
    case PEN_DISK_CANDIDATE_LINES:
        return classify_lines(candidate, p);
    case PEN_DISK_CANDIDATE_OUTLINE:
        return classify_outline(candidate, p);
    case PEN_DISK_CANDIDATE_SPHERE_AHEAD:
        return classify_sphere_ahead(candidate, p);
    case PEN_DISK_CANDIDATE_SPHERE:
        chord = sphere_chord(candidate, p);
        return verdict_of_chord(&chord);
    case PEN_DISK_CANDIDATE_CYLINDER:
        chord = cylinder_chord(candidate, p);
        return verdict_of_chord(&chord);
    case PEN_DISK_CANDIDATE_FALLBACK:
        break;
    }
    const lane_mask none = lane_mask_of(0);
    return (struct verdict){none, none, none, none};
}

#endif
