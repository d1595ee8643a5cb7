/* SPDX-License-Identifier: MIT */
#include "geom/internal/contact.h"

#include "geom/internal/coincidence.h"

/* Rounding rarely exceeds this share of its bound. */
#define USUAL_ROUNDING 0.125

/* How far the primitive extends along unit vector n beyond point p. */
static double reach(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 n,
                    struct pen_vec3 p)
{
    struct pen_triangle room;
    return pen_prim_row(prims, prim)->fn->reach(pen_prim_self(prims, prim, &room), n, p);
}

bool pen_surface_contains(struct pen_surface s, struct pen_vec3 n, struct pen_vec3 p, double b)
{
    const struct pen_outline line = pen_surface_outline(s);
    for (uint32_t i = 0; i < line.count; i++) {
        if (pen_near_segment(line.v[i], line.v[i + 1 < line.count ? i + 1 : 0], p, b))
            return true;
    }
    struct pen_ray normal_ray;
    struct pen_intersections c = {.count = 0};
    if (line.count > 0 && !(fabs(pen_height_above(s, n, p)) <= 2 * b))
        return false;
    if (!pen_ray_make(&normal_ray, p, n))
        return false;
    s.fn->intersect_line(s.self, &normal_ray, &c);
    return c.count > 0 && fabs(c.t[0]) <= b;
}

struct pen_contact pen_contact_at(const struct pen_prims *prims, struct pen_hit q,
                                  struct pen_surface s, const struct pen_ray *ray,
                                  const struct pen_origin_surface *origin)
{
    struct pen_contact c = {
        .prims = prims, .origin = origin, .q = q, .p = ray->o, .share = 4 * PEN_U};
    c.surface = s;
    c.n = s.fn->normal(s.self, q.part, ray->o);
    c.own = pen_own_rounding(prims, q.prim, ray->o);
    c.slack = origin->bound + c.own;
    const struct pen_outline outline = pen_surface_outline(s);
    if (outline.count > 0)
        c.share = pen_larger(c.share, c.slack / outline.extent);
    return c;
}

double pen_contact_across(const struct pen_contact *c, struct pen_vec3 d)
{
    double dn = pen_dot(d, c->n);
    return fabs(dn) <= c->share * pen_norm1(d) ? 0 : dn;
}

/* The height of p above Q if Q is flat, else 0. */
static double above(const struct pen_contact *c)
{
    return pen_surface_outline(c->surface).count > 0 ? pen_height_above(c->surface, c->n, c->p) : 0;
}

/* The side of Q on which a ray to the origin began, as the sign of a product with n. `toward` is
 * the vector from the origin back to that beginning, which may miss its surface by `bound`. 0: it
 * began within rounding of Q. If Q is flat, the place of p does not matter. */
static double side_of_beginning(const struct pen_contact *c, struct pen_vec3 toward, double bound)
{
    double wn = pen_dot(toward, c->n) + above(c), rounding = 2 * (bound + c->own);
    if (pen_surface_outline(c->surface).count == 0)
        rounding += 2 * c->origin->bound;
    rounding += pen_larger(8 * PEN_U * pen_norm1(c->p), c->share * pen_norm1(toward));
    return fabs(wn) <= rounding ? 0 : wn;
}

double pen_contact_path_side(const struct pen_contact *c)
{
    double wn = side_of_beginning(c, c->origin->toward, c->origin->toward_bound);
    return wn != 0 ? wn : side_of_beginning(c, c->origin->before, c->origin->before_bound);
}

/* The side of Q on which P lies, if P lies on one side only; else 0. */
static double side_of_origin_surface(const struct pen_contact *c)
{
    bool out = reach(c->prims, c->origin->prim, c->n, c->p) > 2 * c->slack;
    bool in = reach(c->prims, c->origin->prim, pen_neg(c->n), c->p) > 2 * c->slack;
    return (double)(out - in);
}

/* Whether Q is curved at p, so that points below its tangent plane may be outside it. */
static bool is_curved(const struct pen_contact *c)
{
    return c->surface.fn->curvature &&
           c->surface.fn->curvature(c->surface.self, c->q.part, c->p) > 0;
}

/* The side of Q from which the ray comes, as the sign of a product with n. The first rule that
 * applies decides:
 *  1. The side on which the path began. It does not apply if P lies on the other side and p is
 *     there beyond the usual rounding: then the path has gone round a corner.
 *  2. The side on which P lies, if the path passed `through` P or does not decide. It does not
 *     apply to the inside of a curved Q that the path reaches from outside, because P may be around
 *     Q.
 *  3. 0: P and Q are one surface there. */
static double side_of_arrival(const struct pen_contact *c)
{
    double side = pen_contact_path_side(c), lies = side_of_origin_surface(c);
    if (c->origin->through || side == 0)
        return lies == 0 || (lies < 0 && side > 0 && is_curved(c)) ? side : lies;
    bool round_corner = side * lies < 0 && above(c) * lies > USUAL_ROUNDING * c->slack;
    return round_corner ? lies : side;
}

/* The contact of P itself with the ray's origin, as if it were Q. `room` as in pen_prim_self. */
static struct pen_contact contact_of_origin(const struct pen_contact *c, struct pen_triangle *room)
{
    struct pen_hit left = {0, c->origin->prim, c->origin->part};
    const struct pen_ray here = {.o = c->p};
    return pen_contact_at(c->prims, left, pen_surface_at(c->prims, left.prim, c->p, room), &here,
                          c->origin);
}

/* The side of P on which the ray goes, as the sign of a product with P's normal m: the side from
 * which the path came, or the other one if it passed `through` P. A mirrored ray that runs along P
 * may seem to go to the other side, by rounding. */
static double side_of_departure(const struct pen_contact *own, struct pen_vec3 d)
{
    double dm = pen_dot(d, own->n),
           side = pen_contact_across(own, d) != 0 ? 0 : pen_contact_path_side(own);
    if (side == 0)
        return dm;
    return own->origin->through ? -side : side;
}

/* The largest up.(x - p) for points x of the segment from a to e within r of p; -INFINITY if there
 * are none. */
static double segment_reach(struct pen_vec3 a, struct pen_vec3 e, struct pen_vec3 p,
                            struct pen_vec3 up, double r)
{
    const struct pen_vec3 w = pen_sub(e, a), f = pen_sub(a, p);
    double ww = pen_dot(w, w), k = ww > 0 ? -pen_dot(f, w) / ww : 0;
    const struct pen_vec3 foot = pen_along(f, w, k);
    double half_sq = r * r - pen_dot(foot, foot);
    if (!(half_sq >= 0))
        return -INFINITY;
    double half = ww > 0 ? sqrt(half_sq / ww) : INFINITY;
    double lo = pen_larger(k - half, 0), hi = k + half < 1 ? k + half : 1;
    if (!(lo <= hi))
        return -INFINITY;
    return pen_larger(pen_dot(up, pen_along(f, w, lo)), pen_dot(up, pen_along(f, w, hi)));
}

/* How far a flat Q extends along unit vector `up` beyond p, for its points within r of p. The
 * maximum is on Q's outline or, in the steepest direction of Q's plane, on the sphere of radius r.
 * INFINITY if the rounding of far corners could hide more than the slack. */
static double reach_nearby(const struct pen_contact *c, struct pen_vec3 up, double r)
{
    const struct pen_outline line = pen_surface_outline(c->surface);
    double most = -INFINITY, size = 0;
    for (uint32_t i = 0; i < line.count; i++) {
        const struct pen_vec3 from = line.v[i], to = line.v[i + 1 < line.count ? i + 1 : 0];
        size = pen_larger(size, pen_norm1(pen_sub(from, c->p)));
        most = pen_larger(most, segment_reach(from, to, c->p, up, r));
    }
    if (4 * PEN_U * size > c->slack)
        return INFINITY;
    double high = above(c), flat_sq = r * r - high * high;
    const struct pen_vec3 foot = pen_along(c->p, c->n, -high);
    const struct pen_vec3 steep = pen_along(up, c->n, -pen_dot(up, c->n));
    double length = pen_length(steep);
    struct pen_vec3 x = foot;
    if (length > 0 && flat_sq > 0)
        x = pen_along(foot, steep, sqrt(flat_sq) / length);
    if (pen_surface_contains(c->surface, c->n, x, c->slack))
        most = pen_larger(most, pen_dot(up, pen_sub(x, c->p)));
    return most;
}

/* The unit normal of P on the side to which the ray goes; false if the side is not known. */
static bool side_up(const struct pen_contact *c, struct pen_vec3 d, struct pen_vec3 *up)
{
    struct pen_triangle room;
    const struct pen_contact own = contact_of_origin(c, &room);
    double side = side_of_departure(&own, d);
    *up = side > 0 ? own.n : pen_neg(own.n);
    return side != 0;
}

bool pen_contact_rises(const struct pen_contact *c, struct pen_vec3 d)
{
    struct pen_vec3 up;
    return !side_up(c, d, &up) || c->surface.fn->reach(c->surface.self, up, c->p) > c->slack;
}

bool pen_contact_rises_nearby(const struct pen_contact *c, struct pen_vec3 d)
{
    struct pen_vec3 up;
    if (!side_up(c, d, &up))
        return true;
    return c->surface.fn->reach(c->surface.self, up, c->p) > c->slack &&
           reach_nearby(c, up, PEN_NEARBY * c->slack) > c->slack;
}

bool pen_grazes(struct pen_vec3 n, struct pen_vec3 d)
{
    double dn = pen_dot(d, n);
    return dn * dn <= PEN_HORIZON_SINE * PEN_HORIZON_SINE * pen_dot(d, d);
}

bool pen_contact_counts(const struct pen_contact *c, struct pen_vec3 d)
{
    double side = side_of_arrival(c), dn = pen_dot(d, c->n);
    if (side == 0 || (!pen_grazes(c->n, d) && (side > 0) == (dn > 0)))
        return false;
    return pen_contact_rises(c, d);
}

bool pen_contact_is_layer(const struct pen_contact *c)
{
    if (c->q.prim == c->origin->prim)
        return false; /* triangles of one polygon */
    const struct pen_pair pair = {.prims = c->prims,
                                  .a = {0, c->origin->prim, c->origin->part},
                                  .b = c->q,
                                  .p = c->p,
                                  .slack = c->slack};
    return pen_coincide(&pair) && pen_prim_may_coincide(c->prims, pair.a, pair.b) &&
           pen_covers(&pair);
}

double pen_contact_layer_t(const struct pen_contact *c, struct pen_vec3 d)
{
    double side = pen_contact_path_side(c), dn = pen_contact_across(c, d);
    if (side == 0 || dn == 0)
        return 0;
    uint32_t p = c->origin->prim, q = c->q.prim;
    bool earlier = (side > 0) == (dn > 0);
    if (earlier != (q < p))
        return 0;
    return PEN_FIRST_T * (1.0 + (earlier ? p - q : q - p));
}

double pen_contact_t(const struct pen_contact *c, struct pen_vec3 d)
{
    if (pen_contact_is_layer(c))
        return pen_contact_layer_t(c, d);
    return pen_contact_counts(c, d) ? c->q.t : 0;
}
