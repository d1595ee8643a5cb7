/* SPDX-License-Identifier: MIT */
/* Fans: what a primitive is to the rays from one point to a disk.
 *
 * Bands. Let delta be 4 grow and some 2^-34 of all lengths in play, grow being what the
 * self-intersection rule can reach (see traverse.h). A primitive's own test, with its roundings of
 * some 2^-50 of those lengths, agrees with exact geometry moved by less than delta; so what is
 * farther than delta from the border between a hit and a miss is decided the same by both. A
 * primitive within delta of the origin is always asked, by the reference itself; one that passes
 * within delta of where a ray ends too. */
#include "accel/internal/packet_candidate.h"

#include <float.h>

#include "accel/internal/structure.h"

/* A share of a length: far above its rounding, far below what can be seen. */
static double share(double length)
{
    return 0x1p-34 * length;
}

static double max2(double a, double b)
{
    return a > b ? a : b;
}

static bool fit(struct pen_vec3 v)
{
    return pen_norm1(v) <= 0x1p200;
}

bool pen_packet_prepare(struct pen_shadow_packet *packet, double scale)
{
    double cc = pen_dot(packet->c, packet->c),
           uu = max2(pen_dot(packet->u, packet->u), pen_dot(packet->v, packet->v));
    if (!(fit(packet->o) && fit(packet->c) && fit(packet->u) && fit(packet->v) &&
          scale <= 0x1p200 && cc >= 0x1p-200 && uu <= 0x1p60 * cc))
        return false;
    double slant = 1 / sqrt(cc + uu);
    packet->depth = sqrt(cc);
    packet->slope_cos = packet->depth * slant;
    packet->slope_sin = sqrt(uu) * slant;
    packet->l = pen_scale(packet->c, 1 / packet->depth);
    packet->reach = pen_norm1(packet->c) + pen_norm1(packet->u) + pen_norm1(packet->v);
    packet->grow = 2 * PEN_NEARBY * (packet->origin->bound + 8 * PEN_U * scale);
    packet->delta =
        4 * packet->grow + share(pen_norm1(packet->o) + (packet->to_point ? packet->reach : 0));
    packet->candidate_count = packet->transmissive_count = 0;
    return true;
}

/* What all rays say of a line. */
enum line_say { LINE_NEGATIVE, LINE_POSITIVE, LINE_MIXED };

static struct pen_packet_line line_of(const struct pen_shadow_packet *packet, struct pen_vec3 n,
                                      double band)
{
    return (struct pen_packet_line){pen_dot(n, packet->c), pen_dot(n, packet->u),
                                    pen_dot(n, packet->v), band};
}

static enum line_say line_say(const struct pen_packet_line *line)
{
    double most = sqrt(line->u * line->u + line->v * line->v) + line->band;
    return line->e > most ? LINE_POSITIVE : line->e < -most ? LINE_NEGATIVE : LINE_MIXED;
}

/* Adds a line that must be positive. False if it never is. */
static bool gate_add(struct pen_candidate *candidate, struct pen_packet_line line)
{
    enum line_say say = line_say(&line);
    if (say == LINE_NEGATIVE)
        return false;
    if (say == LINE_MIXED)
        candidate->line[candidate->lines++] = line;
    return true;
}

static enum pen_candidate_verdict ask(struct pen_candidate *candidate, bool near)
{
    candidate->kind = PEN_CANDIDATE_FALLBACK;
    candidate->near = near;
    return PEN_CANDIDATE_SOME;
}

static enum pen_candidate_verdict all_lines(const struct pen_candidate *candidate)
{
    return candidate->lines == 0 && candidate->opaque ? PEN_CANDIDATE_ALWAYS : PEN_CANDIDATE_SOME;
}

/* The line that is positive where a ray meets the plane at distance h along its unit normal n, on
 * the side that h says, and before it ends. */
static struct pen_packet_line plane_line(const struct pen_shadow_packet *packet, struct pen_vec3 n,
                                         double h, double delta)
{
    struct pen_vec3 towards = h < 0 ? pen_neg(n) : n;
    struct pen_packet_line line = line_of(packet, towards, delta);
    if (packet->to_point)
        line.e -= fabs(h);
    else
        line.band = share(packet->reach);
    return line;
}

static enum pen_candidate_verdict plane_gate(const struct pen_shadow_packet *packet,
                                             const struct pen_plane *plane,
                                             struct pen_candidate *candidate)
{
    struct pen_vec3 f = pen_sub(plane->q, packet->o);
    double h = pen_dot(plane->n, f), delta = packet->delta + share(pen_norm1(f));
    if (fabs(h) <= delta)
        return ask(candidate, true);
    if (!gate_add(candidate, plane_line(packet, plane->n, h, delta)))
        return PEN_CANDIDATE_NEVER;
    return all_lines(candidate);
}

/* A triangle, or a polygon that is flat but for rounding. */
struct flat {
    const struct pen_vec3 *v;
    uint32_t count;
    struct pen_vec3 n; /* unit; the vertices run counter-clockwise around it */
};

static double farthest(const struct pen_shadow_packet *packet, const struct flat *flat)
{
    double most = 0;
    for (uint32_t i = 0; i < flat->count; i++)
        most = max2(most, pen_norm1(pen_sub(flat->v[i], packet->o)));
    return most;
}

static struct pen_vec3 plain_cross(struct pen_vec3 a, struct pen_vec3 b)
{
    return pen_vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Positive where rays pass on the inner side of edge i, if they go towards the side of n. The
 * distance of the ray's line from the edge's is at least |e| / (|d| |edge|). */
static struct pen_packet_line edge_line(const struct pen_shadow_packet *packet,
                                        const struct flat *flat, uint32_t i, double delta)
{
    struct pen_vec3 p = flat->v[i], q = flat->v[i + 1 < flat->count ? i + 1 : 0];
    struct pen_vec3 edge = pen_sub(q, p);
    return line_of(packet, plain_cross(pen_sub(p, packet->o), edge),
                   packet->reach * pen_norm1(edge) * delta);
}

/* The origin is in the primitive's plane, or all but: only what no ray's line passes is left out.
 */
static enum pen_candidate_verdict coplanar_gate(const struct pen_shadow_packet *packet,
                                                const struct flat *flat, double delta,
                                                struct pen_candidate *candidate)
{
    bool positive = false, negative = false;
    for (uint32_t i = 0; i < flat->count; i++) {
        struct pen_packet_line line = edge_line(packet, flat, i, delta);
        enum line_say say = line_say(&line);
        positive = positive || say == LINE_POSITIVE;
        negative = negative || say == LINE_NEGATIVE;
        if (positive && negative)
            return PEN_CANDIDATE_NEVER;
    }
    return ask(candidate, true);
}

static enum pen_candidate_verdict flat_gate(const struct pen_shadow_packet *packet,
                                            const struct flat *flat,
                                            struct pen_candidate *candidate)
{
    double delta = packet->delta + share(farthest(packet, flat));
    double h = pen_dot(flat->n, pen_sub(flat->v[0], packet->o));
    if (fabs(h) <= delta)
        return coplanar_gate(packet, flat, delta, candidate);
    if (!gate_add(candidate, plane_line(packet, flat->n, h, delta)))
        return PEN_CANDIDATE_NEVER;
    for (uint32_t i = 0; i < flat->count; i++) {
        struct pen_packet_line line = edge_line(packet, flat, i, delta);
        if (h < 0) {
            line.e = -line.e;
            line.u = -line.u;
            line.v = -line.v;
        }
        if (!gate_add(candidate, line))
            return PEN_CANDIDATE_NEVER;
    }
    return all_lines(candidate);
}

/* How far a point is outside the cone at least, and where it is along the cone's axis. */
struct place {
    double outside, depth;
};

static struct place place_of(const struct pen_shadow_packet *packet, struct pen_vec3 f)
{
    double depth = pen_dot(f, packet->l), aside = pen_length(plain_cross(f, packet->l));
    return (struct place){aside * packet->slope_cos - depth * packet->slope_sin, depth};
}

/* Whether a ball around o + f is off the packet. */
static bool ball_is_off(const struct pen_shadow_packet *packet, struct pen_vec3 f, double r,
                        double delta)
{
    struct place p = place_of(packet, f);
    return p.outside > r + delta || p.depth < -(r + delta) ||
           (packet->to_point && p.depth > packet->depth + r + delta);
}

/* Whether all rays have a positive share of n, whose roundings are those of a vector so long. */
static bool all_along(const struct pen_shadow_packet *packet, struct pen_vec3 n, double size)
{
    struct pen_packet_line line = line_of(packet, n, share(packet->reach * size));
    return line_say(&line) == LINE_POSITIVE;
}

/* A ray's intersections with a sphere are at (p -+ sqrt(p^2 - k |d|^2)) / |d|^2, with p = g.d, g
 * from the origin to the centre, and k = |g|^2 - r^2. Lines: p; k with the band of the square
 * root's argument; |d|^2, and the t that ends a ray. */
static void sphere_lines(const struct pen_shadow_packet *packet, struct pen_vec3 g, double k,
                         double size, struct pen_candidate *candidate)
{
    candidate->line[0] = line_of(packet, g, 0);
    candidate->line[1].e = k;
    candidate->line[1].band = 0x1p-28 * size * size * packet->reach * packet->reach;
    candidate->line[2].e = packet->depth * packet->depth;
    candidate->line[2].u = pen_dot(packet->u, packet->u);
    candidate->line[2].v = pen_dot(packet->v, packet->v);
    candidate->line[2].band = packet->to_point ? 1 : INFINITY;
}

/* From outside, and with the whole sphere before the disk, a ray that crosses it does so twice, if
 * p > 0; the cone of tangents tells which. */
static enum pen_candidate_verdict sphere_gate(const struct pen_shadow_packet *packet,
                                              const struct pen_sphere *s,
                                              struct pen_candidate *candidate)
{
    struct pen_vec3 g = pen_sub(s->c, packet->o);
    double distance = pen_length(g), delta = packet->delta + share(distance + s->r);
    if (candidate->own && all_along(packet, pen_neg(g), pen_norm1(g)))
        return PEN_CANDIDATE_NEVER;
    if (!candidate->own && ball_is_off(packet, g, s->r, delta))
        return PEN_CANDIDATE_NEVER;
    if (!candidate->own && fabs(distance - s->r) <= delta)
        return ask(candidate, true);
    double depth = pen_dot(g, packet->l), k = (distance - s->r) * (distance + s->r);
    candidate->kind = PEN_CANDIDATE_BALL;
    sphere_lines(packet, g, k, distance + s->r, candidate);
    if (candidate->own || k < 0 || (packet->to_point && depth + s->r > packet->depth - delta))
        return PEN_CANDIDATE_SOME;
    double aside = pen_length(plain_cross(g, packet->l));
    if (candidate->opaque &&
        depth * packet->slope_cos - aside * packet->slope_sin > sqrt(k) + delta)
        return PEN_CANDIDATE_ALWAYS;
    candidate->kind = PEN_CANDIDATE_SPHERE;
    return PEN_CANDIDATE_SOME;
}

/* Whether a plane through the origin, with the cone on its other side, has the cylinder beyond.
 * `across` is a unit vector at right angles to the cone's axis, to some 2^-40. */
static bool cylinder_is_beyond(const struct pen_shadow_packet *packet, struct pen_vec3 across,
                               struct pen_vec3 middle, struct pen_vec3 axis,
                               const struct pen_cylinder *c, double delta)
{
    struct pen_vec3 m =
        pen_along(pen_scale(across, packet->slope_cos), packet->l, -packet->slope_sin);
    double ma = pen_dot(m, axis);
    double rim = c->round.r * sqrt(max2(1 - ma * ma, 0));
    return pen_dot(m, middle) - 0.5 * c->h * fabs(ma) - rim > delta;
}

static bool cylinder_is_off(const struct pen_shadow_packet *packet, const struct pen_cylinder *c,
                            struct pen_vec3 middle, struct pen_vec3 axis, double delta)
{
    if (ball_is_off(packet, middle, c->round.r + 0.5 * c->h, delta))
        return true;
    struct pen_vec3 side = pen_sub(middle, pen_scale(packet->l, pen_dot(middle, packet->l)));
    struct pen_vec3 wing = plain_cross(axis, packet->l);
    double aside = pen_length(side), wide = pen_length(wing);
    if (aside > 0x1p-10 * pen_norm1(middle) &&
        cylinder_is_beyond(packet, pen_scale(side, 1 / aside), middle, axis, c, delta))
        return true;
    if (!(1024 * wide > 1)) /* the sine of their angle */
        return false;
    wing = pen_scale(wing, (pen_dot(wing, middle) < 0 ? -1 : 1) / wide);
    return cylinder_is_beyond(packet, wing, middle, axis, c, delta);
}

/* How far a point is from being inside the cylinder; <= 0 inside. */
static double cylinder_gap(const struct pen_cylinder *c, struct pen_vec3 axis, struct pen_vec3 f)
{
    double along = pen_dot(f, axis), side = pen_length(plain_cross(f, axis)) - c->round.r;
    return max2(side, max2(-along, along - c->h));
}

/* Whether no ray that leaves the cylinder comes back to it. */
static bool cylinder_is_left(const struct pen_shadow_packet *packet, const struct pen_cylinder *c,
                             struct pen_vec3 axis, struct pen_vec3 f)
{
    switch (packet->origin->part) {
    case PEN_PART_SIDE:
        return all_along(packet, pen_sub(f, pen_scale(axis, pen_dot(f, axis))), pen_norm1(f));
    case PEN_PART_BASE:
        return c->caps && all_along(packet, pen_neg(axis), 1);
    default:
        return c->caps && all_along(packet, axis, 1);
    }
}

/* A cylinder is crossed at the ends of the overlap of two intervals, of the endless side and of the
 * slab between the caps: as in pen_cylinder_interval, with |a| = 1. Lines: d.a; d.f across the
 * axis; |d|^2, and the t that ends a ray; squared distance from the axis less r^2, and their sum;
 * the two heights of the slab over the origin, and whether there are caps. */
static void cylinder_lines(const struct pen_shadow_packet *packet, const struct pen_cylinder *c,
                           struct pen_vec3 axis, struct pen_vec3 f, struct pen_candidate *candidate)
{
    double along = pen_dot(f, axis);
    struct pen_vec3 side = pen_sub(f, pen_scale(axis, along));
    candidate->kind = PEN_CANDIDATE_CYLINDER;
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

static enum pen_candidate_verdict cylinder_gate(const struct pen_shadow_packet *packet,
                                                const struct pen_cylinder *c,
                                                struct pen_candidate *candidate)
{
    struct pen_vec3 axis = pen_scale(c->round.a, 1 / c->round.length);
    struct pen_vec3 f = pen_sub(packet->o, c->round.q);
    double size = c->round.r + c->h, delta = packet->delta + share(pen_norm1(f) + size);
    if (candidate->own && cylinder_is_left(packet, c, axis, f))
        return PEN_CANDIDATE_NEVER;
    double gap = cylinder_gap(c, axis, f);
    struct pen_vec3 middle = pen_sub(pen_scale(axis, 0.5 * c->h), f);
    if (!candidate->own && gap > delta && cylinder_is_off(packet, c, middle, axis, delta))
        return PEN_CANDIDATE_NEVER;
    if (!candidate->own && fabs(gap) <= delta)
        return ask(candidate, true);
    cylinder_lines(packet, c, axis, f, candidate);
    return PEN_CANDIDATE_SOME;
}

static enum pen_candidate_verdict tube_gate(const struct pen_shadow_packet *packet,
                                            const struct pen_infinite_cylinder *infinite_cylinder,
                                            struct pen_candidate *candidate)
{
    struct pen_vec3 axis =
        pen_scale(infinite_cylinder->round.a, 1 / infinite_cylinder->round.length);
    struct pen_vec3 f = pen_sub(packet->o, infinite_cylinder->round.q);
    if (candidate->own &&
        all_along(packet, pen_sub(f, pen_scale(axis, pen_dot(f, axis))), pen_norm1(f)))
        return PEN_CANDIDATE_NEVER;
    return ask(candidate, true);
}

/* The line from corner i to corner j, as edge_line. */
static struct pen_packet_line chord_line(const struct pen_shadow_packet *packet,
                                         const struct flat *flat, uint32_t i, uint32_t j,
                                         double delta)
{
    const struct pen_vec3 two[2] = {flat->v[i], flat->v[j]};
    const struct flat chord = {two, 2, flat->n};
    return edge_line(packet, &chord, 0, delta);
}

/* Whether all rays are in the outline, or none is; LINE_MIXED if that is not sure. An outline is
 * the packet of triangles from its first corner: inside is what an odd number of them holds. A
 * triangle holds what is on one side of its three edges. */
static enum line_say outline_say(const struct pen_candidate *candidate, uint32_t corners)
{
    bool inside = false;
    for (uint32_t i = 0; i < 2 * corners - 3; i++)
        if (line_say(&candidate->line[1 + i]) == LINE_MIXED)
            return LINE_MIXED;
    for (uint32_t i = 1; i + 1 < corners; i++) {
        const struct pen_packet_line *line = &candidate->line[2 * i - 1];
        enum line_say from = line_say(&line[0]), edge = line_say(&line[1]);
        inside ^= from == edge && line_say(&line[2]) != edge;
    }
    return inside ? LINE_POSITIVE : LINE_NEGATIVE;
}

/* Line 0 is the plane's; then, by turns, the chord from the first corner to corner i, and the edge
 * from there to the next. */
static enum pen_candidate_verdict outline_gate(const struct pen_shadow_packet *packet,
                                               const struct flat *flat, double delta,
                                               struct pen_candidate *candidate)
{
    double h = pen_dot(flat->n, pen_sub(flat->v[0], packet->o));
    candidate->lines = (uint8_t)(2 * flat->count - 2);
    for (uint32_t i = 1; i < flat->count; i++) {
        candidate->line[2 * i - 1] = chord_line(packet, flat, 0, i, delta);
        if (i + 1 < flat->count)
            candidate->line[2 * i] = chord_line(packet, flat, i, i + 1, delta);
    }
    enum line_say inside = outline_say(candidate, flat->count);
    if (inside == LINE_NEGATIVE)
        return PEN_CANDIDATE_NEVER;
    if (fabs(h) <= delta)
        return ask(candidate, true);
    candidate->kind = PEN_CANDIDATE_OUTLINE;
    candidate->line[0] = plane_line(packet, flat->n, h, delta);
    enum line_say before = line_say(&candidate->line[0]);
    if (before == LINE_NEGATIVE)
        return PEN_CANDIDATE_NEVER;
    bool always = candidate->opaque && before == LINE_POSITIVE && inside == LINE_POSITIVE;
    return always ? PEN_CANDIDATE_ALWAYS : PEN_CANDIDATE_SOME;
}

static enum pen_candidate_verdict triangle_gate(const struct pen_shadow_packet *packet,
                                                const struct pen_triangle *tri,
                                                struct pen_candidate *candidate)
{
    const struct pen_vec3 *v = tri->v;
    struct flat flat = {v, 3, tri->n};
    if (pen_dot(plain_cross(pen_sub(v[1], v[0]), pen_sub(v[2], v[0])), tri->n) < 0)
        flat.n = pen_neg(tri->n);
    return flat_gate(packet, &flat, candidate);
}

/* An outline of many corners, or one that is not flat: all that is used is its plane, give or take
 * what it may be off it. */
static enum pen_candidate_verdict vague_gate(const struct pen_shadow_packet *packet,
                                             const struct pen_polygon *p, double delta,
                                             struct pen_candidate *candidate)
{
    double h = pen_dot(p->n, pen_sub(p->v[0], packet->o));
    if (!p->flat)
        delta += 0x1p-18 * p->extent;
    if (fabs(h) <= delta)
        return ask(candidate, true);
    candidate->vague = true;
    return gate_add(candidate, plane_line(packet, p->n, h, delta)) ? PEN_CANDIDATE_SOME
                                                                   : PEN_CANDIDATE_NEVER;
}

static enum pen_candidate_verdict polygon_gate(const struct pen_shadow_packet *packet,
                                               const struct pen_polygon *p,
                                               struct pen_candidate *candidate)
{
    const struct flat flat = {p->v, p->count, p->n};
    if (p->flat && p->convex && p->count < PEN_PACKET_LINES)
        return flat_gate(packet, &flat, candidate);
    double delta = packet->delta + share(farthest(packet, &flat));
    if (ball_is_off(packet, pen_sub(p->v[0], packet->o), 2 * p->extent, delta))
        return PEN_CANDIDATE_NEVER;
    if (p->flat && 2 * p->count - 2 <= PEN_PACKET_LINES)
        return outline_gate(packet, &flat, delta, candidate);
    return vague_gate(packet, p, delta, candidate);
}

enum pen_candidate_verdict pen_candidate_make(const struct pen_shadow_packet *packet,
                                              const struct pen_prims *prims, uint32_t prim,
                                              bool generic, struct pen_candidate *candidate)
{
    const struct pen_prim_ref ref = prims->ref[prim];
    if (prim == packet->origin->prim && pen_prim_flat(ref.kind))
        return PEN_CANDIDATE_NEVER;
    candidate->prim = prim;
    candidate->kind = PEN_CANDIDATE_LINES;
    candidate->lines = 0;
    candidate->vague = false;
    candidate->own = candidate->near = prim == packet->origin->prim;
    candidate->opaque = !(packet->see_through && packet->see_through[prim]);
    switch (generic ? PEN_BLOCK_GENERIC : pen_block_of(ref.kind)) {
    case PEN_BLOCK_SPHERES:
        return sphere_gate(packet, &prims->sphere[ref.index], candidate);
    case PEN_BLOCK_PLANES:
        return plane_gate(packet, &prims->plane[ref.index], candidate);
    case PEN_BLOCK_TRIANGLES:
        return triangle_gate(packet, &prims->triangle[ref.index], candidate);
    case PEN_BLOCK_POLYGONS:
        return polygon_gate(packet, &prims->polygon[ref.index], candidate);
    case PEN_BLOCK_INFINITE_CYLINDERS:
        return tube_gate(packet, &prims->infinite_cylinder[ref.index], candidate);
    case PEN_BLOCK_CYLINDERS:
        return cylinder_gate(packet, &prims->cylinder[ref.index], candidate);
    case PEN_BLOCK_GENERIC:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        break;
    }
    return ask(candidate, true);
}
