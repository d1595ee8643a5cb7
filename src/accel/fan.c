/* SPDX-License-Identifier: MIT */
/* Fans: what a body is to the rays from one point to a disk.
 *
 * Bands. Let delta be 4 grow and some 2^-34 of all lengths in play, grow being what the leave rule
 * can reach (see traverse.h). A body's own test, with its roundings of some 2^-50 of those lengths,
 * agrees with exact geometry moved by less than delta; so what is farther than delta from the
 * border between a hit and a miss is decided the same by both. A body within delta of the origin is
 * always asked, by the reference itself; one that passes within delta of where a ray ends too. */
#include "accel/internal/fan_prepare.h"

#include <float.h>

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

bool pen_fan_prepare(struct pen_fan *fan, double scale)
{
    double cc = pen_dot(fan->c, fan->c),
           uu = max2(pen_dot(fan->u, fan->u), pen_dot(fan->v, fan->v));
    if (!(fit(fan->o) && fit(fan->c) && fit(fan->u) && fit(fan->v) && scale <= 0x1p200 &&
          cc >= 0x1p-200 && uu <= 0x1p60 * cc))
        return false;
    double slant = 1 / sqrt(cc + uu);
    fan->depth = sqrt(cc);
    fan->slope_cos = fan->depth * slant;
    fan->slope_sin = sqrt(uu) * slant;
    fan->l = pen_scale(fan->c, 1 / fan->depth);
    fan->reach = pen_norm1(fan->c) + pen_norm1(fan->u) + pen_norm1(fan->v);
    fan->grow = 2 * PEN_NEARBY * (fan->leave->bound + 8 * PEN_U * scale);
    fan->delta = 4 * fan->grow + share(pen_norm1(fan->o) + (fan->to_point ? fan->reach : 0));
    fan->gates = fan->tints = 0;
    return true;
}

/* What all rays say of a line. */
enum line_say { LINE_NEGATIVE, LINE_POSITIVE, LINE_MIXED };

static struct pen_fan_line line_of(const struct pen_fan *fan, struct pen_vec3 n, double band)
{
    return (struct pen_fan_line){pen_dot(n, fan->c), pen_dot(n, fan->u), pen_dot(n, fan->v), band};
}

static enum line_say line_say(const struct pen_fan_line *line)
{
    double most = sqrt(line->u * line->u + line->v * line->v) + line->band;
    return line->e > most ? LINE_POSITIVE : line->e < -most ? LINE_NEGATIVE : LINE_MIXED;
}

/* Adds a line that must be positive. False if it never is. */
static bool gate_add(struct pen_gate *gate, struct pen_fan_line line)
{
    enum line_say say = line_say(&line);
    if (say == LINE_NEGATIVE)
        return false;
    if (say == LINE_MIXED)
        gate->line[gate->lines++] = line;
    return true;
}

static enum pen_gate_say ask(struct pen_gate *gate, bool near)
{
    gate->kind = PEN_GATE_ASK;
    gate->near = near;
    return PEN_GATE_SOME;
}

static enum pen_gate_say all_lines(const struct pen_gate *gate)
{
    return gate->lines == 0 && gate->opaque ? PEN_GATE_ALWAYS : PEN_GATE_SOME;
}

/* The line that is positive where a ray meets the plane at distance h along its unit normal n, on
 * the side that h says, and before it ends. */
static struct pen_fan_line plane_line(const struct pen_fan *fan, struct pen_vec3 n, double h,
                                      double delta)
{
    struct pen_vec3 towards = h < 0 ? pen_neg(n) : n;
    struct pen_fan_line line = line_of(fan, towards, delta);
    if (fan->to_point)
        line.e -= fabs(h);
    else
        line.band = share(fan->reach);
    return line;
}

static enum pen_gate_say plane_gate(const struct pen_fan *fan, const struct pen_plane *plane,
                                    struct pen_gate *gate)
{
    struct pen_vec3 f = pen_sub(plane->q, fan->o);
    double h = pen_dot(plane->n, f), delta = fan->delta + share(pen_norm1(f));
    if (fabs(h) <= delta)
        return ask(gate, true);
    if (!gate_add(gate, plane_line(fan, plane->n, h, delta)))
        return PEN_GATE_NEVER;
    return all_lines(gate);
}

/* A triangle, or a polygon that is flat but for rounding. */
struct flat {
    const struct pen_vec3 *v;
    uint32_t count;
    struct pen_vec3 n; /* unit; the vertices run counter-clockwise around it */
};

static double farthest(const struct pen_fan *fan, const struct flat *flat)
{
    double most = 0;
    for (uint32_t i = 0; i < flat->count; i++)
        most = max2(most, pen_norm1(pen_sub(flat->v[i], fan->o)));
    return most;
}

static struct pen_vec3 plain_cross(struct pen_vec3 a, struct pen_vec3 b)
{
    return pen_vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Positive where rays pass on the inner side of edge i, if they go towards the side of n. The
 * distance of the ray's line from the edge's is at least |e| / (|d| |edge|). */
static struct pen_fan_line edge_line(const struct pen_fan *fan, const struct flat *flat, uint32_t i,
                                     double delta)
{
    struct pen_vec3 p = flat->v[i], q = flat->v[i + 1 < flat->count ? i + 1 : 0];
    struct pen_vec3 edge = pen_sub(q, p);
    return line_of(fan, plain_cross(pen_sub(p, fan->o), edge),
                   fan->reach * pen_norm1(edge) * delta);
}

/* The origin is in the body's plane, or all but: only what no ray's line passes is left out. */
static enum pen_gate_say coplanar_gate(const struct pen_fan *fan, const struct flat *flat,
                                       double delta, struct pen_gate *gate)
{
    bool positive = false, negative = false;
    for (uint32_t i = 0; i < flat->count; i++) {
        struct pen_fan_line line = edge_line(fan, flat, i, delta);
        enum line_say say = line_say(&line);
        positive = positive || say == LINE_POSITIVE;
        negative = negative || say == LINE_NEGATIVE;
        if (positive && negative)
            return PEN_GATE_NEVER;
    }
    return ask(gate, true);
}

static enum pen_gate_say flat_gate(const struct pen_fan *fan, const struct flat *flat,
                                   struct pen_gate *gate)
{
    double delta = fan->delta + share(farthest(fan, flat));
    double h = pen_dot(flat->n, pen_sub(flat->v[0], fan->o));
    if (fabs(h) <= delta)
        return coplanar_gate(fan, flat, delta, gate);
    if (!gate_add(gate, plane_line(fan, flat->n, h, delta)))
        return PEN_GATE_NEVER;
    for (uint32_t i = 0; i < flat->count; i++) {
        struct pen_fan_line line = edge_line(fan, flat, i, delta);
        if (h < 0) {
            line.e = -line.e;
            line.u = -line.u;
            line.v = -line.v;
        }
        if (!gate_add(gate, line))
            return PEN_GATE_NEVER;
    }
    return all_lines(gate);
}

/* How far a point is outside the cone at least, and where it is along the cone's axis. */
struct place {
    double outside, depth;
};

static struct place place_of(const struct pen_fan *fan, struct pen_vec3 f)
{
    double depth = pen_dot(f, fan->l), aside = pen_length(plain_cross(f, fan->l));
    return (struct place){aside * fan->slope_cos - depth * fan->slope_sin, depth};
}

/* Whether a ball around o + f is off the fan. */
static bool ball_is_off(const struct pen_fan *fan, struct pen_vec3 f, double r, double delta)
{
    struct place p = place_of(fan, f);
    return p.outside > r + delta || p.depth < -(r + delta) ||
           (fan->to_point && p.depth > fan->depth + r + delta);
}

/* Whether all rays have a positive share of n, whose roundings are those of a vector so long. */
static bool all_along(const struct pen_fan *fan, struct pen_vec3 n, double size)
{
    struct pen_fan_line line = line_of(fan, n, share(fan->reach * size));
    return line_say(&line) == LINE_POSITIVE;
}

/* A ray's crossings with a sphere are at (p -+ sqrt(p^2 - k |d|^2)) / |d|^2, with p = g.d, g from
 * the origin to the centre, and k = |g|^2 - r^2. Lines: p; k with the band of the square root's
 * argument; |d|^2, and the t that ends a ray. */
static void sphere_lines(const struct pen_fan *fan, struct pen_vec3 g, double k, double size,
                         struct pen_gate *gate)
{
    gate->line[0] = line_of(fan, g, 0);
    gate->line[1].e = k;
    gate->line[1].band = 0x1p-28 * size * size * fan->reach * fan->reach;
    gate->line[2].e = fan->depth * fan->depth;
    gate->line[2].u = pen_dot(fan->u, fan->u);
    gate->line[2].v = pen_dot(fan->v, fan->v);
    gate->line[2].band = fan->to_point ? 1 : INFINITY;
}

/* From outside, and with the whole sphere before the disk, a ray that crosses it does so twice, if
 * p > 0; the cone of tangents tells which. */
static enum pen_gate_say sphere_gate(const struct pen_fan *fan, const struct pen_sphere *s,
                                     struct pen_gate *gate)
{
    struct pen_vec3 g = pen_sub(s->c, fan->o);
    double distance = pen_length(g), delta = fan->delta + share(distance + s->r);
    if (gate->own && all_along(fan, pen_neg(g), pen_norm1(g)))
        return PEN_GATE_NEVER;
    if (!gate->own && ball_is_off(fan, g, s->r, delta))
        return PEN_GATE_NEVER;
    if (!gate->own && fabs(distance - s->r) <= delta)
        return ask(gate, true);
    double depth = pen_dot(g, fan->l), k = (distance - s->r) * (distance + s->r);
    gate->kind = PEN_GATE_BALL;
    sphere_lines(fan, g, k, distance + s->r, gate);
    if (gate->own || k < 0 || (fan->to_point && depth + s->r > fan->depth - delta))
        return PEN_GATE_SOME;
    double aside = pen_length(plain_cross(g, fan->l));
    if (gate->opaque && depth * fan->slope_cos - aside * fan->slope_sin > sqrt(k) + delta)
        return PEN_GATE_ALWAYS;
    gate->kind = PEN_GATE_SPHERE;
    return PEN_GATE_SOME;
}

/* Whether a plane through the origin, with the cone on its other side, has the cylinder beyond.
 * `across` is a unit vector at right angles to the cone's axis, to some 2^-40. */
static bool cylinder_is_beyond(const struct pen_fan *fan, struct pen_vec3 across,
                               struct pen_vec3 middle, struct pen_vec3 axis,
                               const struct pen_cylinder *c, double delta)
{
    struct pen_vec3 m = pen_along(pen_scale(across, fan->slope_cos), fan->l, -fan->slope_sin);
    double ma = pen_dot(m, axis);
    double rim = c->round.r * sqrt(max2(1 - ma * ma, 0));
    return pen_dot(m, middle) - 0.5 * c->h * fabs(ma) - rim > delta;
}

static bool cylinder_is_off(const struct pen_fan *fan, const struct pen_cylinder *c,
                            struct pen_vec3 middle, struct pen_vec3 axis, double delta)
{
    if (ball_is_off(fan, middle, c->round.r + 0.5 * c->h, delta))
        return true;
    struct pen_vec3 side = pen_sub(middle, pen_scale(fan->l, pen_dot(middle, fan->l)));
    struct pen_vec3 wing = plain_cross(axis, fan->l);
    double aside = pen_length(side), wide = pen_length(wing);
    if (aside > 0x1p-10 * pen_norm1(middle) &&
        cylinder_is_beyond(fan, pen_scale(side, 1 / aside), middle, axis, c, delta))
        return true;
    if (!(1024 * wide > 1)) /* the sine of their angle */
        return false;
    wing = pen_scale(wing, (pen_dot(wing, middle) < 0 ? -1 : 1) / wide);
    return cylinder_is_beyond(fan, wing, middle, axis, c, delta);
}

/* How far a point is from being inside the cylinder; <= 0 inside. */
static double cylinder_gap(const struct pen_cylinder *c, struct pen_vec3 axis, struct pen_vec3 f)
{
    double along = pen_dot(f, axis), side = pen_length(plain_cross(f, axis)) - c->round.r;
    return max2(side, max2(-along, along - c->h));
}

/* Whether no ray that leaves the cylinder comes back to it. */
static bool cylinder_is_left(const struct pen_fan *fan, const struct pen_cylinder *c,
                             struct pen_vec3 axis, struct pen_vec3 f)
{
    switch (fan->leave->part) {
    case PEN_PART_SIDE:
        return all_along(fan, pen_sub(f, pen_scale(axis, pen_dot(f, axis))), pen_norm1(f));
    case PEN_PART_BASE:
        return c->caps && all_along(fan, pen_neg(axis), 1);
    default:
        return c->caps && all_along(fan, axis, 1);
    }
}

/* A cylinder is crossed at the ends of the overlap of two intervals, of the endless side and of the
 * slab between the caps: as in pen_cylinder_inside, with |a| = 1. Lines: d.a; d.f across the axis;
 * |d|^2, and the t that ends a ray; squared distance from the axis less r^2, and their sum; the two
 * heights of the slab over the origin, and whether there are caps. */
static void cylinder_lines(const struct pen_fan *fan, const struct pen_cylinder *c,
                           struct pen_vec3 axis, struct pen_vec3 f, struct pen_gate *gate)
{
    double along = pen_dot(f, axis);
    struct pen_vec3 side = pen_sub(f, pen_scale(axis, along));
    gate->kind = PEN_GATE_CYLINDER;
    gate->line[0] = line_of(fan, axis, 0);
    gate->line[1] = line_of(fan, side, 0);
    gate->line[2].e = fan->depth * fan->depth;
    gate->line[2].u = pen_dot(fan->u, fan->u);
    gate->line[2].v = pen_dot(fan->v, fan->v);
    gate->line[2].band = fan->to_point ? 1 : INFINITY;
    gate->line[3].e = pen_dot(side, side) - c->round.r * c->round.r;
    gate->line[3].u = pen_dot(side, side) + c->round.r * c->round.r;
    gate->line[4].e = -along;
    gate->line[4].u = c->h - along;
    gate->line[4].v = c->caps;
}

static enum pen_gate_say cylinder_gate(const struct pen_fan *fan, const struct pen_cylinder *c,
                                       struct pen_gate *gate)
{
    struct pen_vec3 axis = pen_scale(c->round.a, 1 / c->round.length);
    struct pen_vec3 f = pen_sub(fan->o, c->round.q);
    double size = c->round.r + c->h, delta = fan->delta + share(pen_norm1(f) + size);
    if (gate->own && cylinder_is_left(fan, c, axis, f))
        return PEN_GATE_NEVER;
    double gap = cylinder_gap(c, axis, f);
    struct pen_vec3 middle = pen_sub(pen_scale(axis, 0.5 * c->h), f);
    if (!gate->own && gap > delta && cylinder_is_off(fan, c, middle, axis, delta))
        return PEN_GATE_NEVER;
    if (!gate->own && fabs(gap) <= delta)
        return ask(gate, true);
    cylinder_lines(fan, c, axis, f, gate);
    return PEN_GATE_SOME;
}

static enum pen_gate_say tube_gate(const struct pen_fan *fan, const struct pen_tube *tube,
                                   struct pen_gate *gate)
{
    struct pen_vec3 axis = pen_scale(tube->round.a, 1 / tube->round.length);
    struct pen_vec3 f = pen_sub(fan->o, tube->round.q);
    if (gate->own && all_along(fan, pen_sub(f, pen_scale(axis, pen_dot(f, axis))), pen_norm1(f)))
        return PEN_GATE_NEVER;
    return ask(gate, true);
}

/* The line from corner i to corner j, as edge_line. */
static struct pen_fan_line chord_line(const struct pen_fan *fan, const struct flat *flat,
                                      uint32_t i, uint32_t j, double delta)
{
    const struct pen_vec3 two[2] = {flat->v[i], flat->v[j]};
    const struct flat chord = {two, 2, flat->n};
    return edge_line(fan, &chord, 0, delta);
}

/* Whether all rays are in the outline, or none is; LINE_MIXED if that is not sure. An outline is
 * the fan of triangles from its first corner: inside is what an odd number of them holds. A
 * triangle holds what is on one side of its three edges. */
static enum line_say outline_say(const struct pen_gate *gate, uint32_t corners)
{
    bool inside = false;
    for (uint32_t i = 0; i < 2 * corners - 3; i++)
        if (line_say(&gate->line[1 + i]) == LINE_MIXED)
            return LINE_MIXED;
    for (uint32_t i = 1; i + 1 < corners; i++) {
        const struct pen_fan_line *line = &gate->line[2 * i - 1];
        enum line_say from = line_say(&line[0]), edge = line_say(&line[1]);
        inside ^= from == edge && line_say(&line[2]) != edge;
    }
    return inside ? LINE_POSITIVE : LINE_NEGATIVE;
}

/* Line 0 is the plane's; then, by turns, the chord from the first corner to corner i, and the edge
 * from there to the next. */
static enum pen_gate_say outline_gate(const struct pen_fan *fan, const struct flat *flat,
                                      double delta, struct pen_gate *gate)
{
    double h = pen_dot(flat->n, pen_sub(flat->v[0], fan->o));
    gate->lines = (uint8_t)(2 * flat->count - 2);
    for (uint32_t i = 1; i < flat->count; i++) {
        gate->line[2 * i - 1] = chord_line(fan, flat, 0, i, delta);
        if (i + 1 < flat->count)
            gate->line[2 * i] = chord_line(fan, flat, i, i + 1, delta);
    }
    enum line_say inside = outline_say(gate, flat->count);
    if (inside == LINE_NEGATIVE)
        return PEN_GATE_NEVER;
    if (fabs(h) <= delta)
        return ask(gate, true);
    gate->kind = PEN_GATE_OUTLINE;
    gate->line[0] = plane_line(fan, flat->n, h, delta);
    enum line_say before = line_say(&gate->line[0]);
    if (before == LINE_NEGATIVE)
        return PEN_GATE_NEVER;
    bool always = gate->opaque && before == LINE_POSITIVE && inside == LINE_POSITIVE;
    return always ? PEN_GATE_ALWAYS : PEN_GATE_SOME;
}

static enum pen_gate_say triangle_gate(const struct pen_fan *fan, const struct pen_triangle *tri,
                                       struct pen_gate *gate)
{
    const struct pen_vec3 *v = tri->v;
    struct flat flat = {v, 3, tri->n};
    if (pen_dot(plain_cross(pen_sub(v[1], v[0]), pen_sub(v[2], v[0])), tri->n) < 0)
        flat.n = pen_neg(tri->n);
    return flat_gate(fan, &flat, gate);
}

/* An outline of many corners, or one that is not flat: all that is used is its plane, give or take
 * what it may be off it. */
static enum pen_gate_say vague_gate(const struct pen_fan *fan, const struct pen_polygon *p,
                                    double delta, struct pen_gate *gate)
{
    double h = pen_dot(p->n, pen_sub(p->v[0], fan->o));
    if (!p->flat)
        delta += 0x1p-18 * p->extent;
    if (fabs(h) <= delta)
        return ask(gate, true);
    gate->vague = true;
    return gate_add(gate, plane_line(fan, p->n, h, delta)) ? PEN_GATE_SOME : PEN_GATE_NEVER;
}

static enum pen_gate_say polygon_gate(const struct pen_fan *fan, const struct pen_polygon *p,
                                      struct pen_gate *gate)
{
    const struct flat flat = {p->v, p->count, p->n};
    if (p->flat && p->convex && p->count < PEN_FAN_LINES)
        return flat_gate(fan, &flat, gate);
    double delta = fan->delta + share(farthest(fan, &flat));
    if (ball_is_off(fan, pen_sub(p->v[0], fan->o), 2 * p->extent, delta))
        return PEN_GATE_NEVER;
    if (p->flat && 2 * p->count - 2 <= PEN_FAN_LINES)
        return outline_gate(fan, &flat, delta, gate);
    return vague_gate(fan, p, delta, gate);
}

enum pen_gate_say pen_gate_make(const struct pen_fan *fan, const struct pen_prims *prims,
                                uint32_t prim, struct pen_gate *gate)
{
    const struct pen_prim_ref ref = prims->ref[prim];
    bool round =
        ref.kind == PEN_PRIM_SPHERE || ref.kind == PEN_PRIM_TUBE || ref.kind == PEN_PRIM_CYLINDER;
    if (prim == fan->leave->prim && !round)
        return PEN_GATE_NEVER;
    gate->prim = prim;
    gate->kind = PEN_GATE_LINES;
    gate->lines = 0;
    gate->vague = false;
    gate->own = gate->near = prim == fan->leave->prim;
    gate->opaque = !(fan->see_through && fan->see_through[prim]);
    switch ((enum pen_prim_kind)ref.kind) {
    case PEN_PRIM_SPHERE:
        return sphere_gate(fan, &prims->sphere[ref.index], gate);
    case PEN_PRIM_PLANE:
        return plane_gate(fan, &prims->plane[ref.index], gate);
    case PEN_PRIM_TRIANGLE:
        return triangle_gate(fan, &prims->triangle[ref.index], gate);
    case PEN_PRIM_POLYGON:
        return polygon_gate(fan, &prims->polygon[ref.index], gate);
    case PEN_PRIM_TUBE:
        return tube_gate(fan, &prims->tube[ref.index], gate);
    case PEN_PRIM_CYLINDER:
        return cylinder_gate(fan, &prims->cylinder[ref.index], gate);
    case PEN_PRIM_KIND_COUNT:
        break;
    }
    return ask(gate, true);
}
