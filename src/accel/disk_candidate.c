/* SPDX-License-Identifier: MIT */
/* Makes the candidates of disk packets: the relation of a primitive to the rays from one point to a
 * disk.
 *
 * Bands. Let delta be 4 grow plus some 2^-34 of all lengths involved, where grow is the reach of
 * the self-intersection rule (see prim_test.h). A primitive's own test has roundings of some 2^-50
 * of those lengths. So it agrees with exact geometry that is moved by less than delta. Hence:
 *  - Farther than delta from the border between a hit and a miss, the primitive's test and the
 *    lines here decide alike.
 *  - A primitive within delta of the origin is always tested by the reference.
 *  - So is a primitive that a ray passes within delta of the ray's end. */
#include "accel/internal/disk_candidate.h"

#include <float.h>

#include "accel/internal/structure.h"
#include "math/scale.h"

/* A margin for a length: far above its rounding, far below the visible. */
static double margin_of(double length)
{
    return 0x1p-34 * length;
}

static bool in_range(struct pen_vec3 v)
{
    return pen_norm1(v) <= 0x1p200;
}

bool pen_disk_packet_prepare(struct pen_disk_packet *packet, double scale)
{
    double cc = pen_dot(packet->c, packet->c),
           uu = pen_larger(pen_dot(packet->u, packet->u), pen_dot(packet->v, packet->v));
    if (!(in_range(packet->o) && in_range(packet->c) && in_range(packet->u) &&
          in_range(packet->v) && scale <= 0x1p200 && cc >= 0x1p-200 && uu <= 0x1p60 * cc))
        return false;
    double slant = 1 / sqrt(cc + uu);
    packet->depth = sqrt(cc);
    packet->cone_cos = packet->depth * slant;
    packet->cone_sin = sqrt(uu) * slant;
    packet->axis = pen_scale(packet->c, 1 / packet->depth);
    packet->reach = pen_norm1(packet->c) + pen_norm1(packet->u) + pen_norm1(packet->v);
    packet->grow = 2 * PEN_NEARBY * (packet->origin->bound + 8 * PEN_U * scale);
    packet->delta =
        4 * packet->grow + margin_of(pen_norm1(packet->o) + (packet->to_point ? packet->reach : 0));
    packet->candidate_count = packet->transmissive_count = 0;
    return true;
}

/* The sign of a line for all rays of the packet. */
enum line_sign { LINE_NEGATIVE, LINE_POSITIVE, LINE_MIXED };

static inline struct pen_disk_line line_of(const struct pen_disk_packet *packet, struct pen_vec3 n,
                                           double band)
{
    return (struct pen_disk_line){pen_dot(n, packet->c), pen_dot(n, packet->u),
                                  pen_dot(n, packet->v), band};
}

static enum line_sign line_sign(const struct pen_disk_line *line)
{
    double most = sqrt(line->u * line->u + line->v * line->v) + line->band;
    return line->e > most ? LINE_POSITIVE : line->e < -most ? LINE_NEGATIVE : LINE_MIXED;
}

/* Adds a line that is positive where rays hit. Returns false if it is positive for no ray. A line
 * that is positive for all rays is left out. */
static bool add_line(struct pen_disk_candidate *candidate, struct pen_disk_line line)
{
    enum line_sign sign = line_sign(&line);
    if (sign == LINE_NEGATIVE)
        return false;
    if (sign == LINE_MIXED)
        candidate->line[candidate->lines++] = line;
    return true;
}

/* The reference tests every ray against the primitive, alone. */
static enum pen_disk_candidate_verdict scalar_fallback(struct pen_disk_candidate *candidate)
{
    candidate->kind = PEN_DISK_CANDIDATE_FALLBACK;
    candidate->by_reference = true;
    return PEN_DISK_CANDIDATE_SOME;
}

static enum pen_disk_candidate_verdict verdict_of_lines(const struct pen_disk_candidate *candidate)
{
    return candidate->lines == 0 && candidate->opaque ? PEN_DISK_CANDIDATE_ALWAYS
                                                      : PEN_DISK_CANDIDATE_SOME;
}

/* The line that is positive for rays that intersect the candidate's plane before they end. n is the
 * plane's unit normal, h the plane's signed distance from the origin along n. */
static struct pen_disk_line plane_line(const struct pen_disk_packet *packet, struct pen_vec3 n,
                                       double h, double delta, struct pen_disk_candidate *candidate)
{
    struct pen_vec3 towards = h < 0 ? pen_neg(n) : n;
    struct pen_disk_line line = line_of(packet, towards, delta);
    candidate->facing = line;
    candidate->height = fabs(h);
    if (packet->to_point)
        line.e -= fabs(h);
    else
        line.band = margin_of(packet->reach);
    return line;
}

static enum pen_disk_candidate_verdict plane_candidate(const struct pen_disk_packet *packet,
                                                       const struct pen_plane *plane,
                                                       struct pen_disk_candidate *candidate)
{
    struct pen_vec3 f = pen_sub(plane->q, packet->o);
    double h = pen_dot(plane->n, f), delta = packet->delta + margin_of(pen_norm1(f));
    if (fabs(h) <= delta)
        return scalar_fallback(candidate);
    if (!add_line(candidate, plane_line(packet, plane->n, h, delta, candidate)))
        return PEN_DISK_CANDIDATE_NEVER;
    return verdict_of_lines(candidate);
}

/* A triangle, or a polygon that is flat up to rounding. */
struct flat {
    const struct pen_vec3 *v;
    uint32_t count;
    struct pen_vec3 n; /* unit; the vertices run counter-clockwise around it */
};

static double farthest(const struct pen_disk_packet *packet, const struct flat *flat)
{
    double most = 0;
    for (uint32_t i = 0; i < flat->count; i++)
        most = pen_larger(most, pen_norm1(pen_sub(flat->v[i], packet->o)));
    return most;
}

static struct pen_vec3 cross(struct pen_vec3 a, struct pen_vec3 b)
{
    return pen_vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* The line that is positive for rays that pass on the inner side of an edge or a chord from p to q,
 * if they go towards the side of n. The distance between the ray's line and that of the edge is at
 * least |value| / (|d| |edge|), which gives the band. */
static struct pen_disk_line chord_line(const struct pen_disk_packet *packet,
                                       const struct pen_vec3 *p, const struct pen_vec3 *q,
                                       double delta)
{
    struct pen_vec3 edge = pen_sub(*q, *p);
    return line_of(packet, cross(pen_sub(*p, packet->o), edge),
                   packet->reach * pen_norm1(edge) * delta);
}

/* The line of edge i. */
static struct pen_disk_line edge_line(const struct pen_disk_packet *packet, const struct flat *flat,
                                      uint32_t i, double delta)
{
    return chord_line(packet, &flat->v[i], &flat->v[i + 1 < flat->count ? i + 1 : 0], delta);
}

/* For an origin within delta of the primitive's plane. The primitive is left out only if one edge
 * has all rays on one side and another edge has all rays on the other. Else it falls back. */
static enum pen_disk_candidate_verdict coplanar_candidate(const struct pen_disk_packet *packet,
                                                          const struct flat *flat, double delta,
                                                          struct pen_disk_candidate *candidate)
{
    bool positive = false, negative = false;
    for (uint32_t i = 0; i < flat->count; i++) {
        struct pen_disk_line line = edge_line(packet, flat, i, delta);
        enum line_sign sign = line_sign(&line);
        positive = positive || sign == LINE_POSITIVE;
        negative = negative || sign == LINE_NEGATIVE;
        if (positive && negative)
            return PEN_DISK_CANDIDATE_NEVER;
    }
    return scalar_fallback(candidate);
}

static enum pen_disk_candidate_verdict convex_candidate(const struct pen_disk_packet *packet,
                                                        const struct flat *flat,
                                                        struct pen_disk_candidate *candidate)
{
    double delta = packet->delta + margin_of(farthest(packet, flat));
    double h = pen_dot(flat->n, pen_sub(flat->v[0], packet->o));
    if (fabs(h) <= delta)
        return coplanar_candidate(packet, flat, delta, candidate);
    if (!add_line(candidate, plane_line(packet, flat->n, h, delta, candidate)))
        return PEN_DISK_CANDIDATE_NEVER;
    for (uint32_t i = 0; i < flat->count; i++) {
        struct pen_disk_line line = edge_line(packet, flat, i, delta);
        if (h < 0) {
            line.e = -line.e;
            line.u = -line.u;
            line.v = -line.v;
        }
        if (!add_line(candidate, line))
            return PEN_DISK_CANDIDATE_NEVER;
    }
    return verdict_of_lines(candidate);
}

/* A lower bound of a point's distance from the cone of rays, and its depth along the cone's axis.
 */
struct cone_coordinates {
    double outside, depth;
};

static struct cone_coordinates cone_coordinates_of(const struct pen_disk_packet *packet,
                                                   struct pen_vec3 f)
{
    double depth = pen_dot(f, packet->axis), aside = pen_length(cross(f, packet->axis));
    return (struct cone_coordinates){aside * packet->cone_cos - depth * packet->cone_sin, depth};
}

/* Whether all rays pass the ball of radius r around o + f at more than delta. */
static bool ball_is_outside(const struct pen_disk_packet *packet, struct pen_vec3 f, double r,
                            double delta)
{
    struct cone_coordinates p = cone_coordinates_of(packet, f);
    return p.outside > r + delta || p.depth < -(r + delta) ||
           (packet->to_point && p.depth > packet->depth + r + delta);
}

/* Whether d.n > 0 for all rays, where n has the rounding of a vector of length `size`. */
static bool all_positive(const struct pen_disk_packet *packet, struct pen_vec3 n, double size)
{
    struct pen_disk_line line = line_of(packet, n, margin_of(packet->reach * size));
    return line_sign(&line) == LINE_POSITIVE;
}

/* A ray's intersections with a sphere are at t = (p -+ sqrt(p^2 - k |d|^2)) / |d|^2, with p = g.d,
 * g from the origin to the centre, and k = |g|^2 - r^2. The candidate's lines hold:
 *   0  p as a function of (a, b)
 *   1  e: k; band: that of the square root's argument
 *   2  |d|^2 = e + u a^2 + v b^2; band: the t at which a ray ends */
static void sphere_lines(const struct pen_disk_packet *packet, struct pen_vec3 g, double k,
                         double size, struct pen_disk_candidate *candidate)
{
    candidate->line[0] = line_of(packet, g, 0);
    candidate->line[1].e = k;
    candidate->line[1].band = 0x1p-28 * size * size * packet->reach * packet->reach;
    candidate->line[2].e = packet->depth * packet->depth;
    candidate->line[2].u = pen_dot(packet->u, packet->u);
    candidate->line[2].v = pen_dot(packet->v, packet->v);
    candidate->line[2].band = packet->to_point ? 1 : INFINITY;
}

/* If the origin is outside and the whole sphere is before the disk, a ray with p > 0 either misses
 * the sphere or intersects it twice. The cone of tangents from the origin decides. */
static enum pen_disk_candidate_verdict sphere_candidate(const struct pen_disk_packet *packet,
                                                        const struct pen_sphere *s,
                                                        struct pen_disk_candidate *candidate)
{
    struct pen_vec3 g = pen_sub(s->c, packet->o);
    double distance = pen_length(g), delta = packet->delta + margin_of(distance + s->r);
    if (candidate->is_origin && all_positive(packet, pen_neg(g), pen_norm1(g)))
        return PEN_DISK_CANDIDATE_NEVER;
    if (!candidate->is_origin && ball_is_outside(packet, g, s->r, delta))
        return PEN_DISK_CANDIDATE_NEVER;
    if (!candidate->is_origin && fabs(distance - s->r) <= delta)
        return scalar_fallback(candidate);
    double depth = pen_dot(g, packet->axis), k = (distance - s->r) * (distance + s->r);
    candidate->kind = PEN_DISK_CANDIDATE_SPHERE;
    sphere_lines(packet, g, k, distance + s->r, candidate);
    if (candidate->is_origin || k < 0 || (packet->to_point && depth + s->r > packet->depth - delta))
        return PEN_DISK_CANDIDATE_SOME;
    double aside = pen_length(cross(g, packet->axis));
    if (candidate->opaque && depth * packet->cone_cos - aside * packet->cone_sin > sqrt(k) + delta)
        return PEN_DISK_CANDIDATE_ALWAYS;
    candidate->kind = PEN_DISK_CANDIDATE_SPHERE_AHEAD;
    return PEN_DISK_CANDIDATE_SOME;
}

/* Whether the plane through the origin that touches the cone of rays in direction `across`
 * separates the cylinder from the cone. `across` is a unit vector perpendicular to the cone's axis,
 * to some 2^-40. */
static bool cylinder_is_beyond(const struct pen_disk_packet *packet, struct pen_vec3 across,
                               struct pen_vec3 middle, struct pen_vec3 axis,
                               const struct pen_cylinder *c, double delta)
{
    struct pen_vec3 m =
        pen_along(pen_scale(across, packet->cone_cos), packet->axis, -packet->cone_sin);
    double ma = pen_dot(m, axis);
    double rim = c->round.r * sqrt(pen_larger(1 - ma * ma, 0));
    return pen_dot(m, middle) - 0.5 * c->h * fabs(ma) - rim > delta;
}

static bool cylinder_is_outside(const struct pen_disk_packet *packet, const struct pen_cylinder *c,
                                struct pen_vec3 middle, struct pen_vec3 axis, double delta)
{
    if (ball_is_outside(packet, middle, c->round.r + 0.5 * c->h, delta))
        return true;
    struct pen_vec3 side = pen_sub(middle, pen_scale(packet->axis, pen_dot(middle, packet->axis)));
    struct pen_vec3 wing = cross(axis, packet->axis);
    double aside = pen_length(side), wide = pen_length(wing);
    if (aside > 0x1p-10 * pen_norm1(middle) &&
        cylinder_is_beyond(packet, pen_scale(side, 1 / aside), middle, axis, c, delta))
        return true;
    if (!(1024 * wide > 1)) /* the sine of their angle */
        return false;
    wing = pen_scale(wing, (pen_dot(wing, middle) < 0 ? -1 : 1) / wide);
    return cylinder_is_beyond(packet, wing, middle, axis, c, delta);
}

/* A lower bound of the distance of o from the solid cylinder; <= 0 inside. f is o relative to its
 * base. */
static double cylinder_gap(const struct pen_cylinder *c, struct pen_vec3 axis, struct pen_vec3 f)
{
    double along = pen_dot(f, axis), side = pen_length(cross(f, axis)) - c->round.r;
    return pen_larger(side, pen_larger(-along, along - c->h));
}

/* Whether no ray that starts on the cylinder intersects it again. */
static bool cylinder_is_not_met_again(const struct pen_disk_packet *packet,
                                      const struct pen_cylinder *c, struct pen_vec3 axis,
                                      struct pen_vec3 f)
{
    switch (packet->origin->part) {
    case PEN_PART_SIDE:
        return all_positive(packet, pen_sub(f, pen_scale(axis, pen_dot(f, axis))), pen_norm1(f));
    case PEN_PART_BASE:
        return c->caps && all_positive(packet, pen_neg(axis), 1);
    default:
        return c->caps && all_positive(packet, axis, 1);
    }
}

/* A ray intersects a cylinder at the ends of the overlap of two t-intervals, of the infinite side
 * and of the slab between the caps: as in pen_cylinder_interval, with |axis| = 1. Let f be the
 * origin relative to the base and `side` its component perpendicular to the axis. The lines hold:
 *   0  d.axis as a function of (a, b)
 *   1  d.side as a function of (a, b)
 *   2  |d|^2 = e + u a^2 + v b^2; band: the t at which a ray ends
 *   3  e: |side|^2 - r^2; u: |side|^2 + r^2
 *   4  e, u: the heights of base and top above the origin along the axis; v: 1 if there are caps */
static void cylinder_lines(const struct pen_disk_packet *packet, const struct pen_cylinder *c,
                           struct pen_vec3 axis, struct pen_vec3 f,
                           struct pen_disk_candidate *candidate)
{
    double along = pen_dot(f, axis);
    struct pen_vec3 side = pen_sub(f, pen_scale(axis, along));
    candidate->kind = PEN_DISK_CANDIDATE_CYLINDER;
    candidate->line[0] = line_of(packet, axis, 0);
    candidate->line[1] = line_of(packet, side, 0);
    candidate->line[2].e = packet->depth * packet->depth;
    candidate->line[2].u = pen_dot(packet->u, packet->u);
    candidate->line[2].v = pen_dot(packet->v, packet->v);
    candidate->line[2].band = packet->to_point ? 1 : INFINITY;
    candidate->line[3].e = pen_dot(side, side) - c->round.r * c->round.r;
    candidate->line[3].u = pen_dot(side, side) + c->round.r * c->round.r;
    candidate->line[4].e = -along;
    candidate->line[4].u = c->h - along;
    candidate->line[4].v = c->caps;
}

static enum pen_disk_candidate_verdict cylinder_candidate(const struct pen_disk_packet *packet,
                                                          const struct pen_cylinder *c,
                                                          struct pen_disk_candidate *candidate)
{
    struct pen_vec3 axis = pen_scale(c->round.a, 1 / c->round.length);
    struct pen_vec3 f = pen_sub(packet->o, c->round.q);
    double size = c->round.r + c->h, delta = packet->delta + margin_of(pen_norm1(f) + size);
    if (candidate->is_origin && cylinder_is_not_met_again(packet, c, axis, f))
        return PEN_DISK_CANDIDATE_NEVER;
    double gap = cylinder_gap(c, axis, f);
    struct pen_vec3 middle = pen_sub(pen_scale(axis, 0.5 * c->h), f);
    if (!candidate->is_origin && gap > delta && cylinder_is_outside(packet, c, middle, axis, delta))
        return PEN_DISK_CANDIDATE_NEVER;
    if (!candidate->is_origin && fabs(gap) <= delta)
        return scalar_fallback(candidate);
    cylinder_lines(packet, c, axis, f, candidate);
    return PEN_DISK_CANDIDATE_SOME;
}

static enum pen_disk_candidate_verdict
infinite_cylinder_candidate(const struct pen_disk_packet *packet,
                            const struct pen_infinite_cylinder *infinite_cylinder,
                            struct pen_disk_candidate *candidate)
{
    struct pen_vec3 axis =
        pen_scale(infinite_cylinder->round.a, 1 / infinite_cylinder->round.length);
    struct pen_vec3 f = pen_sub(packet->o, infinite_cylinder->round.q);
    if (candidate->is_origin &&
        all_positive(packet, pen_sub(f, pen_scale(axis, pen_dot(f, axis))), pen_norm1(f)))
        return PEN_DISK_CANDIDATE_NEVER;
    candidate->kind = PEN_DISK_CANDIDATE_FALLBACK;
    return PEN_DISK_CANDIDATE_SOME;
}

/* LINE_POSITIVE if all rays pass inside the outline, LINE_NEGATIVE if all pass outside, LINE_MIXED
 * if neither is certain. The outline is a triangle fan around its first corner. A point is inside
 * if an odd number of these triangles contain it. A triangle contains a point that is on one side
 * of all three edges. */
static enum line_sign outline_sign(const struct pen_disk_candidate *candidate, uint32_t corners)
{
    bool inside = false;
    for (uint32_t i = 0; i < 2 * corners - 3; i++)
        if (line_sign(&candidate->line[1 + i]) == LINE_MIXED)
            return LINE_MIXED;
    for (uint32_t i = 1; i + 1 < corners; i++) {
        const struct pen_disk_line *line = &candidate->line[2 * i - 1];
        enum line_sign from = line_sign(&line[0]), edge = line_sign(&line[1]);
        inside ^= from == edge && line_sign(&line[2]) != edge;
    }
    return inside ? LINE_POSITIVE : LINE_NEGATIVE;
}

/* A flat polygon that need not be convex. Line 0 is that of its plane. Then follow alternately the
 * chord from the first corner to corner i, and the edge from corner i to the next corner. */
static enum pen_disk_candidate_verdict outline_candidate(const struct pen_disk_packet *packet,
                                                         const struct flat *flat, double delta,
                                                         struct pen_disk_candidate *candidate)
{
    double h = pen_dot(flat->n, pen_sub(flat->v[0], packet->o));
    candidate->lines = (uint8_t)(2 * flat->count - 2);
    for (uint32_t i = 1; i < flat->count; i++) {
        candidate->line[2 * i - 1] = chord_line(packet, &flat->v[0], &flat->v[i], delta);
        if (i + 1 < flat->count)
            candidate->line[2 * i] = edge_line(packet, flat, i, delta);
    }
    enum line_sign inside = outline_sign(candidate, flat->count);
    if (inside == LINE_NEGATIVE)
        return PEN_DISK_CANDIDATE_NEVER;
    if (fabs(h) <= delta)
        return scalar_fallback(candidate);
    candidate->kind = PEN_DISK_CANDIDATE_OUTLINE;
    candidate->line[0] = plane_line(packet, flat->n, h, delta, candidate);
    enum line_sign before = line_sign(&candidate->line[0]);
    if (before == LINE_NEGATIVE)
        return PEN_DISK_CANDIDATE_NEVER;
    bool always = candidate->opaque && before == LINE_POSITIVE && inside == LINE_POSITIVE;
    return always ? PEN_DISK_CANDIDATE_ALWAYS : PEN_DISK_CANDIDATE_SOME;
}

static enum pen_disk_candidate_verdict triangle_candidate(const struct pen_disk_packet *packet,
                                                          const struct pen_triangle *tri,
                                                          struct pen_disk_candidate *candidate)
{
    const struct pen_vec3 *v = tri->v;
    struct flat flat = {v, 3, tri->facet.n};
    if (pen_dot(cross(pen_sub(v[1], v[0]), pen_sub(v[2], v[0])), tri->facet.n) < 0)
        flat.n = pen_neg(tri->facet.n);
    return convex_candidate(packet, &flat, candidate);
}

/* A polygon with many corners, or one that is not flat. Only its plane is used, with a margin for
 * the distance of the corners from it, and only to prove misses. */
static enum pen_disk_candidate_verdict plane_only_candidate(const struct pen_disk_packet *packet,
                                                            const struct pen_polygon *p,
                                                            double delta,
                                                            struct pen_disk_candidate *candidate)
{
    double h = pen_dot(p->facet.n, pen_sub(p->v[0], packet->o));
    if (!p->flat)
        delta += 0x1p-18 * p->extent;
    if (fabs(h) <= delta)
        return scalar_fallback(candidate);
    candidate->plane_only = true;
    return add_line(candidate, plane_line(packet, p->facet.n, h, delta, candidate))
               ? PEN_DISK_CANDIDATE_SOME
               : PEN_DISK_CANDIDATE_NEVER;
}

static enum pen_disk_candidate_verdict polygon_candidate(const struct pen_disk_packet *packet,
                                                         const struct pen_polygon *p,
                                                         struct pen_disk_candidate *candidate)
{
    const struct flat flat = {p->v, p->count, p->facet.n};
    if (p->flat && p->convex && p->count < PEN_DISK_LINES)
        return convex_candidate(packet, &flat, candidate);
    double delta = packet->delta + margin_of(farthest(packet, &flat));
    if (ball_is_outside(packet, pen_sub(p->v[0], packet->o), 2 * p->extent, delta))
        return PEN_DISK_CANDIDATE_NEVER;
    if (p->flat && 2 * p->count - 2 <= PEN_DISK_LINES)
        return outline_candidate(packet, &flat, delta, candidate);
    return plane_only_candidate(packet, p, delta, candidate);
}

enum pen_disk_candidate_verdict pen_disk_candidate_make(const struct pen_disk_packet *packet,
                                                        const struct pen_prims *prims,
                                                        uint32_t prim, bool generic,
                                                        struct pen_disk_candidate *candidate)
{
    struct pen_triangle room;
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    if (prim == packet->origin->prim && pen_prim_flat(ref.kind) && !generic)
        return PEN_DISK_CANDIDATE_NEVER;
    candidate->prim = prim;
    candidate->kind = PEN_DISK_CANDIDATE_LINES;
    candidate->lines = 0;
    candidate->plane_only = false;
    candidate->is_origin = candidate->by_reference = prim == packet->origin->prim;
    candidate->opaque = !pen_see_through(prims, packet->see_through, prim);
    switch (generic ? PEN_BLOCK_GENERIC : pen_block_of(ref.kind)) {
    case PEN_BLOCK_SPHERES:
        return sphere_candidate(packet, &prims->sphere[ref.index], candidate);
    case PEN_BLOCK_PLANES:
        return plane_candidate(packet, &prims->plane[ref.index], candidate);
    case PEN_BLOCK_TRIANGLES:
        return triangle_candidate(packet, pen_prim_triangle(prims, ref.index, &room), candidate);
    case PEN_BLOCK_POLYGONS:
        return polygon_candidate(packet, &prims->polygon[ref.index], candidate);
    case PEN_BLOCK_INFINITE_CYLINDERS:
        return infinite_cylinder_candidate(packet, &prims->infinite_cylinder[ref.index], candidate);
    case PEN_BLOCK_CYLINDERS:
        return cylinder_candidate(packet, &prims->cylinder[ref.index], candidate);
    case PEN_BLOCK_GENERIC:
    case PEN_BLOCK_MESH:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        break;
    }
    return scalar_fallback(candidate);
}
