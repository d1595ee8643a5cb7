/* SPDX-License-Identifier: MIT */
/* Whether two surfaces are layers at a point. Both questions use only the functions that every kind
 * of primitive has, so no pair of kinds is special. */
#include "geom/internal/coincidence.h"

#include "math/frame.h"

static struct pen_vec3 projected(const struct pen_prims *prims, struct pen_hit on,
                                 struct pen_vec3 p)
{
    struct pen_triangle room;
    return pen_prim_row(prims, on.prim)
        ->fn->project(pen_prim_self(prims, on.prim, &room), on.part, p);
}

/* Whether x, a point of one surface, is on the other. The two normals may differ by some roundings,
 * which moves x by as much. */
static bool is_on(const struct pen_pair *pair, struct pen_hit on, struct pen_vec3 x)
{
    double off = pen_norm1(pen_sub(projected(pair->prims, on, x), x));
    return off <= 4 * pair->slack + 32 * PEN_U * pen_norm1(pen_sub(x, pair->p));
}

/* Whether four points of surface `in` around p, at a distance of about its size, are on surface
 * `on`. They are not symmetric, so that no common line or circle of two quadrics goes through all
 * of them. Beyond an apex a point may have no projection. */
static bool samples_lie_in(const struct pen_pair *pair, struct pen_hit in, struct pen_hit on)
{
    double size = pair->slack / (8 * PEN_U); /* a plane's normal is known to this precision */
    if (pen_prim_row(pair->prims, in.prim)->shape == PEN_KIND_ROUND)
        size = pen_prim_scale(pair->prims, in.prim, pair->p);
    struct pen_across across = pen_across(pen_prim_normal(pair->prims, in, pair->p));
    int count = 0;
    for (int i = 0; i < 4; i++) {
        double c = size * (i & 1 ? -0.3 : 0.3), s = size * (i & 2 ? -0.4 : 0.4);
        struct pen_vec3 x = pen_along(pen_along(pair->p, across.u, c), across.v, i & 1 ? -s : s);
        x = projected(pair->prims, in, x);
        if (!is_on(pair, in, x))
            continue;
        if (!is_on(pair, on, x))
            return false;
        count++;
    }
    return count > 0;
}

/* Whether surface `in` lies in surface `on`, judged by points of it that determine a plane or a
 * quadric: the corners of an outline, else samples. */
static bool lies_in(const struct pen_pair *pair, struct pen_hit in, struct pen_hit on)
{
    struct pen_triangle room;
    const struct pen_outline line = pen_prim_outline(pair->prims, in.prim, &room);
    if (line.count == 0)
        return samples_lie_in(pair, in, on);
    for (uint32_t i = 0; i < line.count; i++)
        if (!is_on(pair, on, line.v[i]))
            return false;
    return true;
}

bool pen_coincide(const struct pen_pair *pair)
{
    struct pen_vec3 m = pen_prim_normal(pair->prims, pair->a, pair->p);
    struct pen_vec3 n = pen_prim_normal(pair->prims, pair->b, pair->p);
    if (!(pen_norm1(pen_cross(m, n)) <= 0x1p-10 * pen_norm1(m))) /* this excludes most pairs */
        return false;
    return lies_in(pair, pair->b, pair->a) || lies_in(pair, pair->a, pair->b);
}

/* The direction from p away from the borders of surface a that are within `near` of p; 0 if there
 * is none. Its speed away from each of one or two borders is 1. */
static struct pen_vec3 inward_of_outline(const struct pen_outline *line, struct pen_vec3 n,
                                         struct pen_vec3 p, double near, int *borders)
{
    struct pen_vec3 sum = pen_vec3(0, 0, 0), turns = sum;
    for (uint32_t i = 0; i < line->count; i++) {
        struct pen_vec3 e = pen_sub(line->v[i + 1 < line->count ? i + 1 : 0], line->v[i]);
        struct pen_vec3 f = pen_sub(p, line->v[i]);
        double ee = pen_dot(e, e), s = ee > 0 ? pen_dot(f, e) / ee : 0;
        struct pen_vec3 off = pen_along(f, e, s < 0 ? 0 : s > 1 ? -1 : -s);
        turns = pen_add(turns, pen_cross(pen_sub(line->v[i], line->v[0]), e));
        if (ee > 0 && pen_dot(off, off) <= near * near) {
            sum = pen_add(sum, pen_scale(pen_cross(n, e), 1 / sqrt(ee)));
            ++*borders;
        }
    }
    return pen_dot(turns, n) < 0 ? pen_neg(sum) : sum;
}

static struct pen_vec3 inward(const struct pen_pair *pair, struct pen_vec3 n, double near)
{
    struct pen_triangle room;
    const struct pen_kind *kind = pen_prim_row(pair->prims, pair->a.prim);
    const struct pen_outline line = pen_prim_outline(pair->prims, pair->a.prim, &room);
    struct pen_vec3 sum = pen_vec3(0, 0, 0);
    int borders = 0;
    if (line.count > 0)
        sum = inward_of_outline(&line, n, pair->p, near, &borders);
    else if (kind->shape == PEN_KIND_ROUND) {
        unsigned others = pen_prim_touches(pair->prims, pair->a.prim, pair->p, near);
        others &= ~(1u << pair->a.part);
        for (uint8_t part = 0; others >> part != 0; part++) {
            struct pen_hit rim = {0, pair->a.prim, part};
            if (others >> part & 1) {
                sum = pen_sub(sum, pen_prim_normal(pair->prims, rim, pair->p));
                borders++;
            }
        }
    }
    double square = pen_dot(sum, sum);
    return square > 0x1p-64 * borders ? pen_scale(sum, borders / square) : pen_vec3(0, 0, 0);
}

/* Whether b contains a point of the line along a's normal through p. If p is near a's border, the
 * line goes through a point slightly farther inside a, without passing another border. Of
 * neighbours in b's plane that share an edge, the line meets exactly one. */
bool pen_covers(const struct pen_pair *pair)
{
    struct pen_vec3 n = pen_prim_normal(pair->prims, pair->a, pair->p);
    struct pen_vec3 x = pen_along(pair->p, inward(pair, n, 64 * pair->slack), 4 * pair->slack);
    struct pen_ray line;
    struct pen_intersections crossed;
    if (!pen_ray_make(&line, x, n))
        return false;
    pen_prim_intersect_line(pair->prims, pair->b.prim, &line, &crossed);
    for (int i = 0; i < crossed.count; i++)
        if (crossed.part[i] == pair->b.part && fabs(crossed.t[i]) <= 8 * pair->slack)
            return true;
    return false;
}

bool pen_prim_layers(const struct pen_prims *prims, const struct pen_ray *ray, struct pen_hit a,
                     struct pen_hit b, double bound)
{
    const struct pen_pair pair = {
        .prims = prims,
        .a = a,
        .b = b,
        .p = pen_prim_point(prims, a, ray),
        .slack = bound + pen_prim_rounding(prims, b.prim, pen_along(ray->o, ray->d, b.t))};
    double dn = pen_dot(ray->d, pen_prim_normal(prims, a, pair.p));
    return a.prim != b.prim && fabs((b.t - a.t) * dn) <= 2 * pair.slack && pen_coincide(&pair);
}

/* The rounding of the other surface is not known yet. Finite surfaces are not much larger than the
 * scene, whose size is about 1. */
double pen_prim_layers_end(const struct pen_prims *prims, const struct pen_ray *ray,
                           struct pen_hit a, double bound)
{
    struct pen_vec3 p = pen_prim_point(prims, a, ray);
    double dn = pen_dot(ray->d, pen_prim_normal(prims, a, p));
    return a.t + (64 * bound + 0x1p-42 * (1 + pen_norm1(p))) / fabs(dn);
}

/* A point of the surface: a corner, or the point nearest corner i of its box. */
static struct pen_vec3 point_of(const struct pen_prims *prims, struct pen_hit on, int i)
{
    struct pen_triangle room;
    const struct pen_outline line = pen_prim_outline(prims, on.prim, &room);
    if (line.count > 0)
        return line.v[0];
    struct pen_box box = {pen_vec3(0, 0, 0), pen_vec3(0, 0, 0)};
    if (!pen_prim_infinite(pen_prim_kind(prims, on.prim)))
        box = pen_prim_bounds(prims, on.prim);
    return projected(prims, on,
                     pen_vec3(i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y,
                              i & 4 ? box.hi.z : box.lo.z));
}

/* Makes a pair at a common point of both surfaces, if there is one. Beyond the apex of a cone, a
 * corner of its box may have no nearest point; then the next corner is tried. */
static bool pair_make(struct pen_pair *pair, const struct pen_prims *prims, struct pen_hit a,
                      struct pen_hit b)
{
    bool infinite = pen_prim_infinite(pen_prim_kind(prims, a.prim));
    struct pen_hit on = infinite || pen_prim_row(prims, b.prim)->fn->outline ? b : a;
    struct pen_hit other = on.prim == a.prim ? b : a;
    for (int i = 0; i < 8; i++) {
        struct pen_vec3 p = point_of(prims, on, i);
        double slack =
            16 * (pen_prim_rounding(prims, a.prim, p) + pen_prim_rounding(prims, b.prim, p));
        *pair = (struct pen_pair){prims, a, b, p, slack};
        if (is_on(pair, on, p))
            return is_on(pair, other, p);
    }
    return false;
}

/* Whether both surfaces are flat or both are round sides. A sphere is alike only to spheres. */
static bool are_alike(const struct pen_prims *prims, struct pen_hit a, struct pen_hit b)
{
    uint32_t kind_a = pen_prim_kind(prims, a.prim), kind_b = pen_prim_kind(prims, b.prim);
    bool round_a = a.part == PEN_PART_SIDE && !pen_prim_flat(kind_a);
    bool round_b = b.part == PEN_PART_SIDE && !pen_prim_flat(kind_b);
    return round_a == round_b && (kind_a == PEN_PRIM_SPHERE) == (kind_b == PEN_PRIM_SPHERE);
}

/* Whether an edge of `a` separates them, up to `slack`: all of `a` is on one side of it, and all of
 * `b` on the other. */
static bool edge_separates(const struct pen_outline *a, const struct pen_outline *b,
                           struct pen_vec3 n, double slack)
{
    for (uint32_t i = 0; i < a->count; i++) {
        struct pen_vec3 e = pen_sub(a->v[i + 1 < a->count ? i + 1 : 0], a->v[i]);
        struct pen_vec3 aside = pen_cross(e, n);
        double near = slack * pen_norm1(e), own[2] = {0, 0}, other[2] = {INFINITY, -INFINITY};
        for (uint32_t k = 0; k < a->count; k++) {
            double x = pen_dot(aside, pen_sub(a->v[k], a->v[i]));
            own[x > 0] = fabs(x) > fabs(own[x > 0]) ? x : own[x > 0];
        }
        for (uint32_t k = 0; k < b->count; k++) {
            double x = pen_dot(aside, pen_sub(b->v[k], a->v[i]));
            other[0] = x < other[0] ? x : other[0];
            other[1] = x > other[1] ? x : other[1];
        }
        if ((own[1] <= near && other[0] >= -near) || (own[0] >= -near && other[1] <= near))
            return true;
    }
    return false;
}

/* Outlines with more corners in all are not compared edge by edge. */
enum { EDGES_MAX = 64 };

bool pen_prim_may_coincide(const struct pen_prims *prims, struct pen_hit a, struct pen_hit b)
{
    struct pen_triangle rooms[2];
    const struct pen_outline line_a = pen_prim_outline(prims, a.prim, &rooms[0]),
                             line_b = pen_prim_outline(prims, b.prim, &rooms[1]);
    struct pen_pair pair;
    if (!are_alike(prims, a, b) || !pair_make(&pair, prims, a, b) || !pen_coincide(&pair))
        return false;
    if (line_a.count == 0 || line_b.count == 0 || line_a.count + line_b.count > EDGES_MAX)
        return true;
    struct pen_vec3 n = pen_prim_normal(prims, a, pair.p);
    return !edge_separates(&line_a, &line_b, n, pair.slack) &&
           !edge_separates(&line_b, &line_a, n, pair.slack);
}
