/* SPDX-License-Identifier: MIT */
/* The intersections of a ray that starts on a surface: the rule stated in geom/prims.h. */
#include <stddef.h>

#include "geom/internal/kinds.h"

static double max2(double a, double b)
{
    return a > b ? a : b;
}

static bool is_flat(uint32_t kind)
{
    return kind == PEN_PRIM_PLANE || kind == PEN_PRIM_TRIANGLE || kind == PEN_PRIM_POLYGON;
}

/* By how much an intersection of the primitive near p may miss it. */
static double own_rounding(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    return 8 * PEN_U * pen_prim_scale(prims, prim, p);
}

static double farthest(const struct pen_vec3 *v, uint32_t count, struct pen_vec3 n,
                       struct pen_vec3 p)
{
    double far = -INFINITY;
    for (uint32_t i = 0; i < count; i++)
        far = max2(far, pen_dot(n, pen_sub(v[i], p)));
    return far;
}

/* How far the side of a round primitive reaches along unit vector n beyond point p: without end
 * where the axis is not across n, as far as the rounding of both can tell. */
static double round_reach(const struct pen_cylinder_side *s, struct pen_vec3 q, double h,
                          struct pen_vec3 n, struct pen_vec3 p)
{
    double along = pen_dot(n, s->a) / s->length;
    double rim = s->r * pen_length(pen_cross(n, s->a)) / s->length;
    if (h == INFINITY)
        along = fabs(along) <= 16 * PEN_U ? 0 : fabs(along);
    return pen_dot(n, pen_sub(q, p)) + rim + (along > 0 ? along * h : 0);
}

/* How far primitive q reaches along unit vector n beyond point p. */
static double reach(const struct pen_prims *prims, uint32_t q, struct pen_vec3 n, struct pen_vec3 p)
{
    const struct pen_prim_ref ref = prims->ref[q];
    switch ((enum pen_prim_kind)ref.kind) {
    case PEN_PRIM_SPHERE:
        return pen_dot(n, pen_sub(prims->sphere[ref.index].c, p)) + prims->sphere[ref.index].r;
    case PEN_PRIM_PLANE:
        if (pen_norm1(pen_cross(n, prims->plane[ref.index].n)) > 16 * PEN_U)
            return INFINITY;
        return pen_dot(n, pen_sub(prims->plane[ref.index].q, p));
    case PEN_PRIM_TRIANGLE:
        return farthest(prims->triangle[ref.index].v, 3, n, p);
    case PEN_PRIM_POLYGON:
        return farthest(prims->polygon[ref.index].v, prims->polygon[ref.index].count, n, p);
    case PEN_PRIM_INFINITE_CYLINDER:
        return round_reach(&prims->infinite_cylinder[ref.index].round,
                           prims->infinite_cylinder[ref.index].near, INFINITY, n, p);
    case PEN_PRIM_CYLINDER:
        return round_reach(&prims->cylinder[ref.index].round, prims->cylinder[ref.index].round.q,
                           prims->cylinder[ref.index].h, n, p);
    case PEN_PRIM_KIND_COUNT:
        break;
    }
    return INFINITY;
}

/* What is known of a primitive q at the origin of a ray that leaves another. */
struct contact {
    const struct pen_prims *prims;
    const struct pen_origin_surface *origin;
    struct pen_hit q;
    struct pen_vec3 p, n; /* the origin, and q's unit normal there */
    double slack;         /* by how much p may miss q */
    double share;         /* d runs along q, for all that is known, if d.n is no more of |d| */
};

/* Flat primitives are known to `slack` over their whole length. */
static struct contact contact_at(const struct pen_prims *prims, struct pen_hit q,
                                 const struct pen_ray *ray, const struct pen_origin_surface *origin)
{
    struct contact c = {prims, origin, q, ray->o, {0, 0, 0}, 0, 4 * PEN_U};
    const struct pen_prim_ref ref = prims->ref[q.prim];
    c.n = pen_prim_normal(prims, q, ray->o);
    c.slack = origin->bound + own_rounding(prims, q.prim, ray->o);
    if (ref.kind == PEN_PRIM_TRIANGLE)
        c.share = max2(c.share, c.slack / pen_triangle_extent(&prims->triangle[ref.index]));
    else if (ref.kind == PEN_PRIM_POLYGON)
        c.share = max2(c.share, c.slack / prims->polygon[ref.index].extent);
    return c;
}

/* d.n, or 0 if that is rounding. */
static double across(const struct contact *c, struct pen_vec3 d)
{
    double dn = pen_dot(d, c->n);
    return fabs(dn) <= c->share * pen_norm1(d) ? 0 : dn;
}

/* On which side of q a way to the origin began, as the sign of a product with n; 0 if it began as
 * near q as it ends. */
static double side_before(const struct contact *c, struct pen_vec3 toward)
{
    double wn = across(c, toward);
    return fabs(wn) <= 2 * c->slack ? 0 : wn;
}

/* The side of q that the ray comes from, as the sign of a product with n: where the way to the
 * origin began, or else the one before it. That tells little after the primitive left was passed,
 * and nothing if both began at q: then it is where that primitive lies, if it lies on one side. 0
 * if it lies on neither: there the two are one surface. */
static double side_of(const struct contact *c)
{
    double wn = side_before(c, c->origin->toward);
    if (wn == 0)
        wn = side_before(c, c->origin->before);
    if (!c->origin->through && wn != 0)
        return wn;
    bool out = reach(c->prims, c->origin->prim, c->n, c->p) > 2 * c->slack;
    bool in = reach(c->prims, c->origin->prim, pen_neg(c->n), c->p) > 2 * c->slack;
    return out && in ? wn : (double)(out - in);
}

/* Whether q extends beyond the tangent plane of what the ray leaves, where it goes. */
static bool rises(const struct contact *c, struct pen_vec3 d)
{
    struct pen_hit left = {0, c->origin->prim, c->origin->part};
    struct pen_vec3 m = pen_prim_normal(c->prims, left, c->p);
    double dm = pen_dot(d, m);
    return dm == 0 || reach(c->prims, c->q.prim, dm > 0 ? m : pen_neg(m), c->p) > c->slack;
}

/* Whether an intersection of q at the ray's origin counts. A ray along q does not get by. */
static bool origin_counts(const struct contact *c, struct pen_vec3 d)
{
    double side = side_of(c), dn = across(c, d);
    if (side == 0 || (side > 0 && dn > 0) || (side < 0 && dn < 0))
        return false;
    return rises(c, d);
}

/* The primitive that the ray leaves: it is left at the leave's part, and can be met once more if
 * the ray goes inward. */
static void cross_own(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                      uint8_t part, struct pen_intersections *out)
{
    const struct pen_prim_ref ref = prims->ref[prim];
    struct pen_interval in;
    out->count = 0;
    if (ref.kind == PEN_PRIM_SPHERE)
        out->t[0] = pen_sphere_chord(&prims->sphere[ref.index], ray);
    else if (ref.kind == PEN_PRIM_INFINITE_CYLINDER)
        out->t[0] = pen_cylinder_side_chord(&prims->infinite_cylinder[ref.index].round, ray);
    else if (ref.kind == PEN_PRIM_CYLINDER &&
             pen_cylinder_inward(&prims->cylinder[ref.index], ray, part, &in)) {
        out->t[0] = max2(in.hi, PEN_FIRST_T);
        out->part[0] = in.hi_part;
        out->count = prims->cylinder[ref.index].caps || in.hi_part == PEN_PART_SIDE;
        return;
    } else {
        return;
    }
    out->part[0] = PEN_PART_SIDE;
    out->count = out->t[0] > 0;
}

/* The intersections of a quadric whose side contains the origin. */
static void cross_chord(double chord, struct pen_intersections *out)
{
    out->t[0] = chord < 0 ? chord : 0;
    out->t[1] = chord < 0 ? 0 : chord;
    out->count = chord == 0 ? 0 : 2;
}

/* Adds an intersection at the ray's origin if it counts. */
static void add_at_origin(const struct pen_prims *prims, struct pen_hit q,
                          const struct pen_ray *ray, const struct pen_origin_surface *origin,
                          struct pen_intersections *out)
{
    const struct contact c = contact_at(prims, q, ray, origin);
    if (!origin_counts(&c, ray->d))
        return;
    out->t[out->count] = q.t;
    out->part[out->count++] = q.part;
}

/* Replaces the intersections of a cylinder that contains the origin within the bounds. Where the
 * ray merely grazes the rim of two parts it meets the cylinder nowhere else. */
static void cylinder_touching(const struct pen_prims *prims, uint32_t prim,
                              const struct pen_ray *ray, const struct pen_origin_surface *origin,
                              struct pen_intersections *out)
{
    const struct pen_cylinder *c = &prims->cylinder[prims->ref[prim].index];
    unsigned on = pen_cylinder_touches(c, ray->o, origin->bound);
    struct pen_interval in;
    if (on == 0)
        return;
    out->count = 0;
    if (pen_cylinder_interval_from(c, ray, on, &in))
        pen_interval_ends(c, &in, out);
    if (!(on & PEN_ON_SIDE && on & (PEN_ON_BASE | PEN_ON_TOP)))
        return;
    for (uint8_t part = 0; out->count == 0 && part <= PEN_PART_TOP; part++) {
        const struct contact at = contact_at(prims, (struct pen_hit){0, prim, part}, ray, origin);
        if (on >> part & 1 && (c->caps || part == PEN_PART_SIDE) && origin_counts(&at, ray->d))
            *out = (struct pen_intersections){1, {0}, {part}};
    }
}

/* Replaces the intersections of a quadric that contains the origin within the bounds: the one that
 * is the origin gets t = 0, exactly. */
static void quadric_touching(const struct pen_prims *prims, uint32_t prim,
                             const struct pen_ray *ray, const struct pen_origin_surface *origin,
                             struct pen_intersections *out)
{
    const struct pen_prim_ref ref = prims->ref[prim];
    if (ref.kind == PEN_PRIM_CYLINDER) {
        cylinder_touching(prims, prim, ray, origin, out);
    } else if (out->count == 0) {
        return;
    } else if (ref.kind == PEN_PRIM_SPHERE) {
        if (pen_sphere_touches(&prims->sphere[ref.index], ray->o, origin->bound))
            cross_chord(pen_sphere_chord(&prims->sphere[ref.index], ray), out);
    } else if (ref.kind == PEN_PRIM_INFINITE_CYLINDER) {
        const struct pen_infinite_cylinder *infinite_cylinder =
            &prims->infinite_cylinder[ref.index];
        if (pen_cylinder_side_touches(&infinite_cylinder->round, ray->o,
                                      origin->bound +
                                          pen_infinite_cylinder_rounding(infinite_cylinder)))
            cross_chord(pen_cylinder_side_chord(&infinite_cylinder->round, ray), out);
    }
}

/* The corners of a triangle or polygon. */
struct outline {
    const struct pen_vec3 *v;
    uint32_t count; /* 0 of other primitives */
};

static struct outline outline_of(const struct pen_prims *prims, uint32_t prim)
{
    const struct pen_prim_ref ref = prims->ref[prim];
    if (ref.kind == PEN_PRIM_TRIANGLE)
        return (struct outline){prims->triangle[ref.index].v, 3};
    if (ref.kind == PEN_PRIM_POLYGON)
        return (struct outline){prims->polygon[ref.index].v, prims->polygon[ref.index].count};
    return (struct outline){NULL, 0};
}

/* Whether p is within b of the segment from a to c. */
static bool near_segment(struct pen_vec3 a, struct pen_vec3 c, struct pen_vec3 p, double b)
{
    struct pen_vec3 e = pen_sub(c, a), f = pen_sub(p, a);
    double ee = pen_dot(e, e), s = ee > 0 ? pen_dot(f, e) / ee : 0;
    struct pen_vec3 off = pen_along(f, e, s < 0 ? 0 : s > 1 ? -1 : -s);
    return pen_dot(off, off) <= b * b;
}

/* Whether p is on a triangle or polygon with unit normal n, within b: on its border, or inside. */
static bool on_body(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 n,
                    struct pen_vec3 p, double b)
{
    const struct outline line = outline_of(prims, prim);
    for (uint32_t i = 0; i < line.count; i++) {
        if (near_segment(line.v[i], line.v[i + 1 < line.count ? i + 1 : 0], p, b))
            return true;
    }
    struct pen_ray across;
    struct pen_intersections c;
    if (line.count == 0 || !(fabs(pen_dot(n, pen_sub(line.v[0], p))) <= 2 * b) ||
        !pen_ray_make(&across, p, n))
        return false;
    pen_prim_intersect_line(prims, prim, &across, &c);
    return c.count > 0 && fabs(c.t[0]) <= b;
}

/* A point as seen along the ray, from its origin. */
static struct pen_vec3 seen_along(const struct pen_ray *ray, struct pen_vec3 v)
{
    struct pen_vec3 f = pen_sub(v, ray->o);
    return pen_along(f, ray->d, -pen_dot(f, ray->d) * ray->inv_dd);
}

/* Whether the ray meets the plane of a triangle or polygon near its origin, at t, and passes its
 * border within b: then it is an accident whether its line meets the primitive. */
static bool passes_border(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 n,
                          const struct pen_ray *ray, double b, double *t)
{
    const struct outline line = outline_of(prims, prim);
    if (line.count == 0)
        return false;
    double far = pen_dot(n, pen_sub(line.v[0], ray->o)), nearby = PEN_NEARBY * b;
    *t = far / pen_dot(n, ray->d);
    if (!(fabs(far) > 0.5 * b && *t > 0 && *t * *t <= nearby * nearby * ray->inv_dd))
        return false;
    struct pen_vec3 from = seen_along(ray, line.v[line.count - 1]);
    for (uint32_t i = 0; i < line.count; i++) {
        struct pen_vec3 to = seen_along(ray, line.v[i]);
        if (near_segment(from, to, pen_vec3(0, 0, 0), b))
            return true;
        from = to;
    }
    return false;
}

/* A primitive whose border is passed is met if it rises over what the ray leaves. */
static void cross_border(const struct pen_prims *prims, struct pen_hit q, const struct pen_ray *ray,
                         const struct pen_origin_surface *origin, struct pen_intersections *out)
{
    const struct contact c = contact_at(prims, q, ray, origin);
    if (!rises(&c, ray->d))
        out->count = 0;
    else if (out->count == 0)
        *out = (struct pen_intersections){1, {q.t}, {q.part}};
}

/* The intersection of a flat primitive by a ray that leaves another. A ray that starts on it may
 * miss it: at its border, or along it. */
static void cross_flat(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                       const struct pen_origin_surface *origin, struct pen_intersections *out)
{
    double scale = pen_prim_scale(prims, prim, ray->o), b = origin->bound + 8 * PEN_U * scale;
    struct pen_hit hit = {out->count ? out->t[0] : 0, prim, PEN_PART_SIDE};
    struct pen_vec3 n = pen_prim_normal(prims, hit, ray->o);
    bool touches = out->count && pen_flat_touches(n, scale, ray, hit.t, origin->bound);
    if (!touches && !(hit.t <= 0 && on_body(prims, prim, n, ray->o, b))) {
        if (passes_border(prims, prim, n, ray, b, &hit.t))
            cross_border(prims, hit, ray, origin, out);
        return;
    }
    out->count = 0;
    if (hit.t <= 0 || pen_flat_near(ray, hit.t, b))
        hit.t = PEN_FIRST_T;
    add_at_origin(prims, hit, ray, origin, out);
}

void pen_prim_intersect(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                        const struct pen_origin_surface *origin, struct pen_intersections *out)
{
    if (prim == origin->prim) {
        cross_own(prims, prim, ray, origin->part, out);
        return;
    }
    pen_prim_intersect_line(prims, prim, ray, out);
    if (origin->prim == PEN_NO_PRIM)
        return;
    if (is_flat(prims->ref[prim].kind)) {
        cross_flat(prims, prim, ray, origin, out);
        return;
    }
    quadric_touching(prims, prim, ray, origin, out);
    struct pen_intersections all = *out;
    out->count = 0;
    for (int i = 0; i < all.count; i++) {
        struct pen_hit hit = {all.t[i], prim, all.part[i]};
        if (hit.t == 0) {
            hit.t = PEN_FIRST_T;
            add_at_origin(prims, hit, ray, origin, out);
        } else {
            out->t[out->count] = hit.t;
            out->part[out->count++] = hit.part;
        }
    }
}

bool pen_prim_ends_ray(const struct pen_prims *prims, struct pen_hit hit, const struct pen_ray *ray,
                       double t_end, double bound)
{
    const struct pen_prim_ref ref = prims->ref[hit.prim];
    struct pen_vec3 x = pen_along(ray->o, ray->d, hit.t), p = pen_along(ray->o, ray->d, t_end);
    double dn = pen_dot(ray->d, pen_prim_normal(prims, hit, x));
    if (!(fabs((t_end - hit.t) * dn) <= bound + own_rounding(prims, hit.prim, p)))
        return false;
    if (ref.kind == PEN_PRIM_SPHERE)
        return pen_sphere_touches(&prims->sphere[ref.index], p, bound);
    if (ref.kind == PEN_PRIM_CYLINDER)
        return pen_cylinder_touches(&prims->cylinder[ref.index], p, bound) & 1u << hit.part;
    if (ref.kind == PEN_PRIM_INFINITE_CYLINDER) {
        const struct pen_infinite_cylinder *infinite_cylinder =
            &prims->infinite_cylinder[ref.index];
        return pen_cylinder_side_touches(&infinite_cylinder->round, p,
                                         bound + pen_infinite_cylinder_rounding(infinite_cylinder));
    }
    return true;
}
