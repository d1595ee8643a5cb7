/* SPDX-License-Identifier: MIT */
/* The intersections of a ray that starts on a surface: the self-intersection rule, stated with a
 * figure and a decision table in src/geom/README.md. Here P is the primitive that the ray starts on
 * and Q another one. */
#include <math.h>
#include <stddef.h>

#include "geom/internal/coincidence.h"
#include "geom/internal/kinds.h"
#include "geom/prims.h"
#include "math/scale.h"

/* Rounding seldom reaches this share of its bound. */
#define USUAL_ROUNDING 0.125

/* By how much an intersection of the primitive near p may miss it. */
static double own_rounding(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    return 8 * PEN_U * pen_prim_scale(prims, prim, p);
}

/* How far the primitive extends along unit vector n beyond point p. */
static double reach(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 n,
                    struct pen_vec3 p)
{
    return pen_prim_row(prims, prim)->fn->reach(pen_prim_self(prims, prim), n, p);
}

/* A surface to judge: a primitive, or a triangle of a polygon that is cut. */
struct surface {
    const struct pen_kind_functions *fn;
    const void *self;
};

static struct surface surface_of_piece(const struct pen_triangle *piece)
{
    return (struct surface){&pen_triangle_functions, piece};
}

/* The primitive; of a polygon that is cut, the triangle at p. */
static struct surface surface_at(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    const struct pen_polygon *polygon = pen_prim_cut(prims, prim);
    if (polygon)
        return surface_of_piece(pen_polygon_piece(polygon, p));
    return (struct surface){pen_prim_row(prims, prim)->fn, pen_prim_self(prims, prim)};
}

static struct pen_outline outline_of(struct surface s)
{
    return s.fn->outline ? s.fn->outline(s.self) : (struct pen_outline){NULL, 0, 0};
}

/* Whether p is within b of the segment from a to c. */
static bool near_segment(struct pen_vec3 a, struct pen_vec3 c, struct pen_vec3 p, double b)
{
    struct pen_vec3 e = pen_sub(c, a), f = pen_sub(p, a);
    double ee = pen_dot(e, e), s = ee > 0 ? pen_dot(f, e) / ee : 0;
    struct pen_vec3 off = pen_along(f, e, s < 0 ? 0 : s > 1 ? -1 : -s);
    return pen_dot(off, off) <= b * b;
}

/* How far p is above a flat surface with unit normal n, to some u of |p|, however far its vertices
 * are. */
static double height_above(struct surface s, struct pen_vec3 n, struct pen_vec3 p)
{
    return pen_dot(n, pen_sub(p, s.fn->project(s.self, PEN_PART_SIDE, p)));
}

/* Whether p is on a flat primitive with unit normal n, within b: on its border, or inside. */
static bool contains_point(struct surface s, struct pen_vec3 n, struct pen_vec3 p, double b)
{
    const struct pen_outline line = outline_of(s);
    for (uint32_t i = 0; i < line.count; i++) {
        if (near_segment(line.v[i], line.v[i + 1 < line.count ? i + 1 : 0], p, b))
            return true;
    }
    struct pen_ray normal_ray;
    struct pen_intersections c = {.count = 0};
    if (line.count > 0 && !(fabs(height_above(s, n, p)) <= 2 * b))
        return false;
    if (!pen_ray_make(&normal_ray, p, n))
        return false;
    s.fn->intersect_line(s.self, &normal_ray, &c);
    return c.count > 0 && fabs(c.t[0]) <= b;
}

/* The contact of a primitive Q with the origin of a ray that starts on another primitive P. */
struct contact {
    const struct pen_prims *prims;
    const struct pen_origin_surface *origin; /* P */
    struct pen_hit q;                        /* Q and its part */
    struct surface surface;                  /* that of Q */
    struct pen_vec3 p, n;                    /* the ray's origin, and Q's unit normal there */
    double slack;                            /* by how much p may miss Q */
    double own;                              /* by how much Q itself is known */
    double share; /* d counts as parallel to Q where |d.n| is at most this share of |d| */
};

/* The plane of a flat primitive is known to `slack` over its whole extent: that bounds `share`. */
static struct contact contact_at(const struct pen_prims *prims, struct pen_hit q, struct surface s,
                                 const struct pen_ray *ray, const struct pen_origin_surface *origin)
{
    struct contact c = {.prims = prims, .origin = origin, .q = q, .p = ray->o, .share = 4 * PEN_U};
    c.surface = s;
    c.n = s.fn->normal(s.self, q.part, ray->o);
    c.own = own_rounding(prims, q.prim, ray->o);
    c.slack = origin->bound + c.own;
    const struct pen_outline outline = outline_of(s);
    if (outline.count > 0)
        c.share = pen_larger(c.share, c.slack / outline.extent);
    return c;
}

/* d.n, or 0 where that is rounding. */
static double across(const struct contact *c, struct pen_vec3 d)
{
    double dn = pen_dot(d, c->n);
    return fabs(dn) <= c->share * pen_norm1(d) ? 0 : dn;
}

/* How far p is above Q, if Q is flat; else 0. */
static double above(const struct contact *c)
{
    return outline_of(c->surface).count > 0 ? height_above(c->surface, c->n, c->p) : 0;
}

/* The side of Q on which a ray to the origin began, as the sign of a product with n. `toward` is
 * the vector from the origin back to that beginning, which may miss its surface by `bound`. 0: it
 * began within rounding of Q. Where p is makes no difference if Q is flat. */
static double side_of_beginning(const struct contact *c, struct pen_vec3 toward, double bound)
{
    double wn = pen_dot(toward, c->n) + above(c), rounding = 2 * (bound + c->own);
    if (outline_of(c->surface).count == 0)
        rounding += 2 * c->origin->bound;
    rounding += pen_larger(8 * PEN_U * pen_norm1(c->p), c->share * pen_norm1(toward));
    return fabs(wn) <= rounding ? 0 : wn;
}

/* The side of Q on which the path began, by the last of its rays that tells; 0: none does. */
static double side_of_path(const struct contact *c)
{
    double wn = side_of_beginning(c, c->origin->toward, c->origin->toward_bound);
    return wn != 0 ? wn : side_of_beginning(c, c->origin->before, c->origin->before_bound);
}

/* The side of Q on which P lies, if it lies on one only; else 0. */
static double side_of_origin_surface(const struct contact *c)
{
    bool out = reach(c->prims, c->origin->prim, c->n, c->p) > 2 * c->slack;
    bool in = reach(c->prims, c->origin->prim, pen_neg(c->n), c->p) > 2 * c->slack;
    return (double)(out - in);
}

/* The side of Q from which the ray comes, as the sign of a product with n:
 *  1. that on which the path began, if P does not lie on the other side, with p there beyond the
 *     usual rounding: then the path has come round a corner;
 *  2. that on which P lies, if the path passed `through` P or does not tell;
 *  3. 0 if nothing tells: P and Q are one surface there. */
static double side_of_arrival(const struct contact *c)
{
    double side = side_of_path(c), lies = side_of_origin_surface(c);
    if (c->origin->through || side == 0)
        return lies != 0 ? lies : side;
    bool round_corner = side * lies < 0 && above(c) * lies > USUAL_ROUNDING * c->slack;
    return round_corner ? lies : side;
}

/* The contact of P itself with the ray's origin, as if it were Q. */
static struct contact contact_of_origin(const struct contact *c)
{
    struct pen_hit left = {0, c->origin->prim, c->origin->part};
    const struct pen_ray here = {.o = c->p};
    return contact_at(c->prims, left, surface_at(c->prims, left.prim, c->p), &here, c->origin);
}

/* The side of P on which the ray goes, as the sign of a product with P's normal m: that from which
 * the path came, or the other one if it passed `through` P. A mirrored ray that runs along P may
 * seem to go to the other side, by rounding. */
static double side_of_departure(const struct contact *own, struct pen_vec3 d)
{
    double dm = pen_dot(d, own->n), side = across(own, d) != 0 ? 0 : side_of_path(own);
    if (side == 0)
        return dm;
    return own->origin->through ? -side : side;
}

/* The largest up.(x - p) of the points x of the segment from a to e that are within r of p;
 * -INFINITY if there are none. */
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

/* The reach of a flat Q along unit vector `up` beyond p, of its points within r of p: the largest
 * is on Q's outline or, steepest in Q's plane, on the sphere of radius r. INFINITY where the
 * rounding of far corners could hide more than the slack. */
static double reach_nearby(const struct contact *c, struct pen_vec3 up, double r)
{
    const struct pen_outline line = outline_of(c->surface);
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
    if (contains_point(c->surface, c->n, x, c->slack))
        most = pen_larger(most, pen_dot(up, pen_sub(x, c->p)));
    return most;
}

/* The unit normal of P on the side to which the ray goes; false if no side tells. */
static bool side_up(const struct contact *c, struct pen_vec3 d, struct pen_vec3 *up)
{
    const struct contact own = contact_of_origin(c);
    double side = side_of_departure(&own, d);
    *up = side > 0 ? own.n : pen_neg(own.n);
    return side != 0;
}

/* Whether Q extends beyond P's tangent plane, on the side to which the ray goes. */
static bool rises(const struct contact *c, struct pen_vec3 d)
{
    struct pen_vec3 up;
    return !side_up(c, d, &up) || c->surface.fn->reach(c->surface.self, up, c->p) > c->slack;
}

/* Whether a flat Q, whose border the ray passes near p, does so near p: no ray is so low that it
 * meets Q there if Q rises only farther away (PEN_HORIZON_SINE). Without that a corner which the
 * rounding of the document has lifted over P would count. */
static bool rises_nearby(const struct contact *c, struct pen_vec3 d)
{
    struct pen_vec3 up;
    if (!side_up(c, d, &up))
        return true;
    return c->surface.fn->reach(c->surface.self, up, c->p) > c->slack &&
           reach_nearby(c, up, PEN_NEARBY * c->slack) > c->slack;
}

/* Whether d is so low over a surface with unit normal n that a ray along it has not risen above the
 * bounds before it leaves the range in which borders are looked at. */
static bool grazes(struct pen_vec3 n, struct pen_vec3 d)
{
    double dn = pen_dot(d, n);
    return dn * dn <= PEN_HORIZON_SINE * PEN_HORIZON_SINE * pen_dot(d, d);
}

/* Whether an intersection of Q at the ray's origin counts: the ray does not go back to the side
 * from which it comes, and Q rises over P. A ray that grazes Q does not go back. */
static bool origin_counts(const struct contact *c, struct pen_vec3 d)
{
    double side = side_of_arrival(c), dn = pen_dot(d, c->n);
    if (side == 0 || (!grazes(c->n, d) && (side > 0) == (dn > 0)))
        return false;
    return rises(c, d);
}

/* Whether Q is a layer with P at the origin: coincident, and there wherever P is. */
static bool is_layer(const struct contact *c)
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

/* The t at which the ray meets layer Q; 0 if it does not. Layers lie in document order, the first
 * nearest to where the path came from. So a ray that goes back to that side meets the earlier
 * ones, nearest first, and any other ray the later ones. */
static double t_of_layer(const struct contact *c, struct pen_vec3 d)
{
    double side = side_of_path(c), dn = across(c, d);
    if (side == 0 || dn == 0)
        return 0;
    uint32_t p = c->origin->prim, q = c->q.prim;
    bool earlier = (side > 0) == (dn > 0);
    if (earlier != (q < p))
        return 0;
    return PEN_FIRST_T * (1.0 + (earlier ? p - q : q - p));
}

/* The t of an intersection of Q at the ray's origin; 0 if it does not count. */
static double t_at_origin(const struct contact *c, struct pen_vec3 d)
{
    if (is_layer(c))
        return t_of_layer(c, d);
    return origin_counts(c, d) ? c->q.t : 0;
}

/* The intersections with P itself: a flat primitive is not met again, a round one perhaps once. */
static void intersect_own(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                          uint8_t part, struct pen_intersections *out)
{
    const struct pen_kind *kind = pen_prim_row(prims, prim);
    out->count = 0;
    if (kind->shape == PEN_KIND_ROUND)
        kind->fn->intersect_own(pen_prim_self(prims, prim), ray, part, out);
}

/* Adds an intersection at the ray's origin if it counts. */
static void add_at_origin(const struct pen_prims *prims, struct pen_hit q, struct surface s,
                          const struct pen_ray *ray, const struct pen_origin_surface *origin,
                          struct pen_intersections *out)
{
    const struct contact c = contact_at(prims, q, s, ray, origin);
    double t = t_at_origin(&c, ray->d);
    if (t > 0)
        pen_intersections_add(out, t, q.part);
}

/* Replaces the intersections of a round primitive that contains the origin within the bounds: the
 * intersection at the origin gets t = 0 exactly. */
static void intersect_touching(const struct pen_prims *prims, uint32_t prim,
                               const struct pen_ray *ray, const struct pen_origin_surface *origin,
                               struct pen_intersections *out)
{
    const struct surface s = surface_at(prims, prim, ray->o);
    unsigned rim = s.fn->intersect_touching(s.self, ray, origin->bound, out);
    for (uint8_t part = 0; out->count == 0 && rim >> part != 0; part++) {
        const struct contact at =
            contact_at(prims, (struct pen_hit){PEN_FIRST_T, prim, part}, s, ray, origin);
        if (rim >> part & 1 && t_at_origin(&at, ray->d) > 0)
            *out = (struct pen_intersections){1, {0}, {part}};
    }
}

/* A point relative to the ray's origin, projected along the ray. */
static struct pen_vec3 projected(const struct pen_ray *ray, struct pen_vec3 v)
{
    struct pen_vec3 f = pen_sub(v, ray->o);
    return pen_along(f, ray->d, -pen_dot(f, ray->d) * ray->inv_dd);
}

/* Whether the ray passes the border of a triangle or polygon near its origin within b: whether its
 * line meets the primitive is then an accident of rounding. *t is where it meets the plane, and
 * where it passes the border if it begins in the plane; *far how far its origin is from that. */
static bool passes_border(struct surface s, struct pen_vec3 n, const struct pen_ray *ray, double b,
                          double *t, double *far)
{
    const struct pen_outline line = outline_of(s);
    if (line.count == 0)
        return false;
    double nearby = PEN_NEARBY * b, end = nearby * nearby * ray->inv_dd;
    const struct pen_vec3 to_corner = pen_sub(line.v[0], ray->o);
    double dn = pen_dot(n, ray->d), roughly = pen_dot(n, to_corner), t_roughly = roughly / dn;
    /* Most are told by a corner: t is off by a quarter at most, and is behind or far away. */
    if (fabs(roughly) > b + 32 * PEN_U * pen_norm1(to_corner) &&
        !(t_roughly > 0 && t_roughly * t_roughly <= 2 * end))
        return false;
    *far = -height_above(s, n, ray->o);
    *t = *far / dn;
    bool off = fabs(*far) > 0.5 * b;
    if (off && !(*t > 0 && *t * *t <= end))
        return false;
    for (uint32_t i = 0; i < line.count; i++) {
        struct pen_vec3 from = line.v[i], to = line.v[i + 1 < line.count ? i + 1 : 0];
        struct pen_vec3 x = projected(ray, from), y = projected(ray, to), e = pen_sub(y, x);
        if (!near_segment(x, y, pen_vec3(0, 0, 0), b))
            continue;
        if (off)
            return true;
        double ee = pen_dot(e, e), k = ee > 0 ? -pen_dot(x, e) / ee : 0;
        struct pen_vec3 at = pen_along(from, pen_sub(to, from), k < 0 ? 0 : k > 1 ? 1 : k);
        *t = pen_dot(pen_sub(at, ray->o), ray->d) * ray->inv_dd;
        if (*t > 0 && *t * *t <= end)
            return true;
    }
    return false;
}

/* A primitive whose border the ray passes is met, in its plane, if it rises over P near p; and if p
 * is in that plane within rounding, if it rises over P and the ray does not go back. */
static void intersect_border(const struct pen_prims *prims, struct pen_hit q, struct surface s,
                             const struct pen_ray *ray, const struct pen_origin_surface *origin,
                             double far, struct pen_intersections *out)
{
    const struct contact c = contact_at(prims, q, s, ray, origin);
    bool met = fabs(far) <= 2 * c.slack ? origin_counts(&c, ray->d) : rises_nearby(&c, ray->d);
    if (!met)
        out->count = 0;
    else if (out->count == 0)
        *out = (struct pen_intersections){1, {q.t}, {q.part}};
}

/* Replaces the intersection with a flat surface of Q that is not P's. The line of a ray that starts
 * on Q may miss Q all the same: at its border, or where it is parallel. */
static void intersect_flat(const struct pen_prims *prims, uint32_t prim, struct surface s,
                           const struct pen_ray *ray, const struct pen_origin_surface *origin,
                           struct pen_intersections *out)
{
    double scale = pen_prim_scale(prims, prim, ray->o), b = origin->bound + 8 * PEN_U * scale;
    struct pen_hit hit = {out->count ? out->t[0] : 0, prim, PEN_PART_SIDE};
    struct pen_vec3 n = s.fn->normal(s.self, hit.part, ray->o);
    /* t of a grazing ray may be that of the edge past which the ray is seen to enter Q. */
    bool touches = out->count && (pen_flat_touches(n, scale, ray, hit.t, origin->bound) ||
                                  (hit.t > 0 && fabs(height_above(s, n, ray->o)) <= b));
    if (!touches && !(hit.t <= 0 && contains_point(s, n, ray->o, b))) {
        double far;
        if (passes_border(s, n, ray, b, &hit.t, &far))
            intersect_border(prims, hit, s, ray, origin, far, out);
        return;
    }
    out->count = 0;
    if (hit.t <= 0 || pen_flat_near(ray, hit.t, b) ||
        (grazes(n, ray->d) && contains_point(s, n, ray->o, b)))
        hit.t = PEN_FIRST_T;
    add_at_origin(prims, hit, s, ray, origin, out);
}

/* Whether the polygon is a layer of P at the ray's origin. Then the intersection there is added, if
 * the ray meets it. */
static bool is_cut_layer(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                         const struct pen_origin_surface *origin, struct pen_intersections *out)
{
    const struct surface s = surface_at(prims, prim, ray->o);
    const struct contact c =
        contact_at(prims, (struct pen_hit){0, prim, PEN_PART_SIDE}, s, ray, origin);
    if (!contains_point(s, c.n, c.p, c.slack) || !is_layer(&c))
        return false;
    double t = t_of_layer(&c, ray->d);
    if (t > 0)
        pen_intersections_add(out, t, PEN_PART_SIDE);
    return true;
}

/* A polygon that is cut into triangles is met where the first of them is, each judged as if it were
 * a primitive: P is the one at the ray's origin, and a ray may meet others of the same polygon. One
 * that goes through the polygon has met it: it counts once. */
static void intersect_cut(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                          const struct pen_origin_surface *origin, struct pen_intersections *out)
{
    const struct pen_polygon *polygon = pen_prim_cut(prims, prim);
    const struct pen_triangle *left = NULL;
    out->count = 0;
    if (prim == origin->prim && origin->through)
        return;
    if (prim == origin->prim)
        left = pen_polygon_piece(polygon, ray->o);
    else if (is_cut_layer(prims, prim, ray, origin, out))
        return;
    for (uint32_t i = 0; i + 2 < polygon->count; i++) {
        const struct surface s = surface_of_piece(&polygon->piece[i]);
        struct pen_intersections met = {.count = 0};
        if (s.self == left)
            continue;
        s.fn->intersect_line(s.self, ray, &met);
        intersect_flat(prims, prim, s, ray, origin, &met);
        if (met.count > 0) {
            out->t[0] = out->count ? pen_first_ahead(out->t[0], met.t[0]) : met.t[0];
            out->count = 1;
        }
    }
    out->part[0] = PEN_PART_SIDE;
}

/* Whether the ray passes a rim of the primitive near its origin, within the bounds: as
 * passes_border. at->t, at->part are as for the kind's function. If p is on that part, continued
 * without end, the ray does not get there. */
static bool passes_rim(const struct pen_prims *prims, const struct pen_ray *ray,
                       const struct pen_origin_surface *origin, struct pen_hit *at)
{
    const struct pen_kind_functions *fn = pen_prim_row(prims, at->prim)->fn;
    const void *self = pen_prim_self(prims, at->prim);
    double b = origin->bound + own_rounding(prims, at->prim, ray->o), nearby = PEN_NEARBY * b;
    if (!fn->passes_rim || !fn->passes_rim(self, ray, b, &at->t, &at->part) ||
        !(at->t * at->t <= nearby * nearby * ray->inv_dd))
        return false;
    struct pen_vec3 x = pen_along(ray->o, ray->d, at->t), n = fn->normal(self, at->part, x);
    return fabs(at->t * pen_dot(ray->d, n)) > 0.5 * b && !fn->touches(self, ray->o, origin->bound);
}

/* Where the ray passes a rim, it meets the primitive if that rises over P: the side of an open one,
 * there only. A closed one that the line misses is met at its cap and at once at its side. */
static void intersect_rim(const struct pen_prims *prims, struct pen_hit q,
                          const struct pen_ray *ray, const struct pen_origin_surface *origin,
                          struct pen_intersections *out)
{
    const struct surface s = surface_at(prims, q.prim, ray->o);
    const struct contact c = contact_at(prims, q, s, ray, origin);
    const struct pen_intersections all = *out;
    bool closed = q.part != PEN_PART_SIDE;
    int i = 0;
    if (closed && all.count > 0)
        return;
    out->count = 0;
    for (; i < all.count && all.t[i] < q.t; i++)
        pen_intersections_add(out, all.t[i], all.part[i]);
    if (rises(&c, ray->d))
        pen_intersections_add(out, q.t, q.part);
    if (closed && out->count > 0)
        pen_intersections_add(out, q.t, PEN_PART_SIDE);
    for (; i < all.count; i++) {
        if (all.t[i] != q.t)
            pen_intersections_add(out, all.t[i], all.part[i]);
    }
}

/* Whether a primitive with rims, which p is not on, is left near the ray's origin although it does
 * not rise over P. The ray has then passed a rim in which a neighbour of P ends, and has met it by
 * rounding: what does not rise has a chord within the slack of P's tangent plane, no longer than
 * the slack over the sine of the ray, which is nearby (PEN_HORIZON_SINE). */
static bool ends_below(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                       const struct pen_origin_surface *origin, const struct pen_intersections *met)
{
    const struct pen_kind_functions *fn = pen_prim_row(prims, prim)->fn;
    if (!fn->passes_rim || met->count == 0)
        return false;
    const int last = met->count - 1;
    double t = met->t[last], b = origin->bound + own_rounding(prims, prim, ray->o),
           nearby = PEN_NEARBY * b;
    if (!(t > 0 && t * t <= nearby * nearby * ray->inv_dd) ||
        fn->touches(pen_prim_self(prims, prim), ray->o, origin->bound))
        return false;
    const struct pen_hit q = {t, prim, met->part[last]};
    const struct contact c = contact_at(prims, q, surface_at(prims, prim, ray->o), ray, origin);
    return !rises(&c, ray->d);
}

void pen_prim_intersect(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                        const struct pen_origin_surface *origin, struct pen_intersections *out)
{
    if (origin->prim != PEN_NO_PRIM && pen_prim_cut(prims, prim)) {
        intersect_cut(prims, prim, ray, origin, out);
        return;
    }
    if (prim == origin->prim) {
        intersect_own(prims, prim, ray, origin->part, out);
        return;
    }
    pen_prim_intersect_line(prims, prim, ray, out);
    if (origin->prim == PEN_NO_PRIM)
        return;
    if (pen_prim_flat(prims->ref[prim].kind)) {
        intersect_flat(prims, prim, surface_at(prims, prim, ray->o), ray, origin, out);
        return;
    }
    struct pen_hit rim = {.prim = prim};
    if (passes_rim(prims, ray, origin, &rim))
        intersect_rim(prims, rim, ray, origin, out);
    if (ends_below(prims, prim, ray, origin, out))
        out->count = 0;
    intersect_touching(prims, prim, ray, origin, out);
    struct pen_intersections all = *out;
    out->count = 0;
    for (int i = 0; i < all.count; i++) {
        if (all.t[i] == 0)
            add_at_origin(prims, (struct pen_hit){PEN_FIRST_T, prim, all.part[i]},
                          surface_at(prims, prim, ray->o), ray, origin, out);
        else
            pen_intersections_add(out, all.t[i], all.part[i]);
    }
}

double pen_prim_viewer_side(const struct pen_prims *prims, struct pen_hit hit, struct pen_vec3 p,
                            struct pen_vec3 v, const struct pen_origin_surface *origin)
{
    const struct pen_ray here = {.o = p};
    const struct contact c = contact_at(prims, hit, surface_at(prims, hit.prim, p), &here, origin);
    bool layer = hit.t > PEN_FIRST_T && hit.t <= PEN_LAST_LAYER_T;
    double side = layer ? -across(&c, v) : 0;
    if (side == 0)
        side = side_of_path(&c);
    return side != 0 ? side : -pen_dot(v, c.n);
}

bool pen_prim_ends_ray(const struct pen_prims *prims, struct pen_hit hit, const struct pen_ray *ray,
                       double t_end, double bound)
{
    if (hit.t <= PEN_LAST_LAYER_T)
        return false;
    struct pen_vec3 x = pen_along(ray->o, ray->d, hit.t), p = pen_along(ray->o, ray->d, t_end);
    struct pen_vec3 n = pen_prim_normal(prims, hit, x);
    double b = bound + own_rounding(prims, hit.prim, p);
    if (!(fabs((t_end - hit.t) * pen_dot(ray->d, n)) <= b))
        return false;
    if (!pen_prim_flat(prims->ref[hit.prim].kind))
        return pen_prim_touches(prims, hit.prim, p, bound) >> hit.part & 1;
    const struct surface s = surface_at(prims, hit.prim, p);
    return contains_point(s, s.fn->normal(s.self, hit.part, p), p, b);
}
