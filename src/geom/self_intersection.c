/* SPDX-License-Identifier: MIT */
/* The intersections of a ray that starts on a surface, by the self-intersection rule, for each kind
 * of shape. src/geom/SELF_INTERSECTION.md states the rule with a figure and a decision table. P is
 * the primitive that the ray starts on, Q another one. internal/contact.h judges Q where the ray
 * starts. */
#include "geom/internal/contact.h"

/* The intersections with P itself: a flat primitive is not met again, a round one at most once. */
static void intersect_own(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                          uint8_t part, struct pen_intersections *out)
{
    struct pen_triangle room;
    const struct pen_kind *kind = pen_prim_row(prims, prim);
    out->count = 0;
    if (kind->shape == PEN_KIND_ROUND)
        kind->fn->intersect_own(pen_prim_self(prims, prim, &room), ray, part, out);
}

/* Adds an intersection at the ray's origin if it counts. */
static void add_at_origin(const struct pen_prims *prims, struct pen_hit q, struct pen_surface s,
                          const struct pen_ray *ray, const struct pen_origin_surface *origin,
                          struct pen_intersections *out)
{
    const struct pen_contact c = pen_contact_at(prims, q, s, ray, origin);
    double t = pen_contact_t(&c, ray->d);
    if (t > 0)
        pen_intersections_add(out, t, q.part);
}

/* Replaces the intersections of a round primitive that contains the origin within the bounds: the
 * intersection at the origin gets t = 0 exactly. */
static void intersect_touching(const struct pen_prims *prims, uint32_t prim,
                               const struct pen_ray *ray, const struct pen_origin_surface *origin,
                               struct pen_intersections *out)
{
    struct pen_triangle room;
    const struct pen_surface s = pen_surface_at(prims, prim, ray->o, &room);
    unsigned rim = s.fn->intersect_touching(s.self, ray, origin->bound, out);
    for (uint8_t part = 0; out->count == 0 && rim >> part != 0; part++) {
        const struct pen_contact at =
            pen_contact_at(prims, (struct pen_hit){PEN_FIRST_T, prim, part}, s, ray, origin);
        if (rim >> part & 1 && pen_contact_t(&at, ray->d) > 0)
            *out = (struct pen_intersections){1, {0}, {part}};
    }
}

/* A point relative to the ray's origin, projected along the ray. */
static struct pen_vec3 projected(const struct pen_ray *ray, struct pen_vec3 v)
{
    struct pen_vec3 f = pen_sub(v, ray->o);
    return pen_along(f, ray->d, -pen_dot(f, ray->d) * ray->inv_dd);
}

/* Whether the ray passes the border of a triangle or polygon near its origin within b. Then
 * rounding decides whether its line meets the primitive. *t is where it meets the plane; if it
 * begins in the plane, where it passes the border. *far is the distance of its origin from the
 * plane. */
static bool passes_border(struct pen_surface s, struct pen_vec3 n, const struct pen_ray *ray,
                          double b, double *t, double *far)
{
    const struct pen_outline line = pen_surface_outline(s);
    if (line.count == 0)
        return false;
    double nearby = PEN_NEARBY * b, end = nearby * nearby * ray->inv_dd;
    const struct pen_vec3 to_corner = pen_sub(line.v[0], ray->o);
    double dn = pen_dot(n, ray->d), roughly = pen_dot(n, to_corner), t_roughly = roughly / dn;
    /* One corner excludes most: t is off by a quarter at most, and is behind the origin or far
     * away. */
    if (fabs(roughly) > b + 32 * PEN_U * pen_norm1(to_corner) &&
        !(t_roughly > 0 && t_roughly * t_roughly <= 2 * end))
        return false;
    *far = -pen_height_above(s, n, ray->o);
    *t = *far / dn;
    bool off = fabs(*far) > 0.5 * b;
    if (off && !(*t > 0 && *t * *t <= end))
        return false;
    for (uint32_t i = 0; i < line.count; i++) {
        struct pen_vec3 from = line.v[i], to = line.v[i + 1 < line.count ? i + 1 : 0];
        struct pen_vec3 x = projected(ray, from), y = projected(ray, to), e = pen_sub(y, x);
        if (!pen_near_segment(x, y, pen_vec3(0, 0, 0), b))
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

/* Decides whether a primitive whose border the ray passes is met, in its plane. It is met if it
 * rises over P near p. If p is in its plane within rounding, it is met if it rises over P and the
 * ray does not return. */
static void intersect_border(const struct pen_prims *prims, struct pen_hit q, struct pen_surface s,
                             const struct pen_ray *ray, const struct pen_origin_surface *origin,
                             double far, struct pen_intersections *out)
{
    const struct pen_contact c = pen_contact_at(prims, q, s, ray, origin);
    bool met = fabs(far) <= 2 * c.slack ? pen_contact_counts(&c, ray->d)
                                        : pen_contact_rises_nearby(&c, ray->d);
    if (!met)
        out->count = 0;
    else if (out->count == 0)
        *out = (struct pen_intersections){1, {q.t}, {q.part}};
}

/* Replaces the intersection with a flat surface of Q that is not P's. The line of a ray that starts
 * on Q may still miss Q: at its border, or if it is parallel. */
static void intersect_flat(const struct pen_prims *prims, uint32_t prim, struct pen_surface s,
                           const struct pen_ray *ray, const struct pen_origin_surface *origin,
                           struct pen_intersections *out)
{
    double scale = pen_prim_scale(prims, prim, ray->o), b = origin->bound + 8 * PEN_U * scale;
    struct pen_hit hit = {out->count ? out->t[0] : 0, prim, PEN_PART_SIDE};
    struct pen_vec3 n = s.fn->normal(s.self, hit.part, ray->o);
    /* For a grazing ray, t may be that of the edge past which the ray is seen to enter Q. */
    bool touches = out->count && (pen_flat_touches(n, scale, ray, hit.t, origin->bound) ||
                                  (hit.t > 0 && fabs(pen_height_above(s, n, ray->o)) <= b));
    if (!touches && !(hit.t <= 0 && pen_surface_contains(s, n, ray->o, b))) {
        double far;
        if (passes_border(s, n, ray, b, &hit.t, &far))
            intersect_border(prims, hit, s, ray, origin, far, out);
        return;
    }
    out->count = 0;
    if (hit.t <= 0 || pen_flat_near(ray, hit.t, b) ||
        (pen_grazes(n, ray->d) && pen_surface_contains(s, n, ray->o, b)))
        hit.t = PEN_FIRST_T;
    add_at_origin(prims, hit, s, ray, origin, out);
}

/* Whether the polygon is a layer of P at the ray's origin. If so, adds the intersection there if
 * the ray meets it. */
static bool is_cut_layer(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                         const struct pen_origin_surface *origin, struct pen_intersections *out)
{
    struct pen_triangle room;
    const struct pen_surface s = pen_surface_at(prims, prim, ray->o, &room);
    const struct pen_contact c =
        pen_contact_at(prims, (struct pen_hit){0, prim, PEN_PART_SIDE}, s, ray, origin);
    if (!pen_surface_contains(s, c.n, c.p, c.slack) || !pen_contact_is_layer(&c))
        return false;
    double t = pen_contact_layer_t(&c, ray->d);
    if (t > 0)
        pen_intersections_add(out, t, PEN_PART_SIDE);
    return true;
}

/* A cut polygon is met where the first of its triangles is met. Each triangle is judged like a
 * primitive: P is the one at the ray's origin, and a ray may meet others of the same polygon. A ray
 * that goes through the polygon has met it, and it counts once. */
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
        const struct pen_surface s = pen_surface_of_piece(&polygon->piece[i]);
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
 * passes_border. at->t, at->part are as in the kind's function. If p is on that part, continued
 * without end, the ray does not reach the rim. */
static bool passes_rim(const struct pen_prims *prims, const struct pen_ray *ray,
                       const struct pen_origin_surface *origin, struct pen_hit *at)
{
    struct pen_triangle room;
    const struct pen_kind_functions *fn = pen_prim_row(prims, at->prim)->fn;
    const void *self = pen_prim_self(prims, at->prim, &room);
    double b = origin->bound + pen_own_rounding(prims, at->prim, ray->o), nearby = PEN_NEARBY * b;
    if (!fn->passes_rim || !fn->passes_rim(self, ray, b, &at->t, &at->part) ||
        !(at->t * at->t <= nearby * nearby * ray->inv_dd))
        return false;
    struct pen_vec3 x = pen_along(ray->o, ray->d, at->t), n = fn->normal(self, at->part, x);
    return fabs(at->t * pen_dot(ray->d, n)) > 0.5 * b && !fn->touches(self, ray->o, origin->bound);
}

/* Decides at a rim that the ray passes. It meets the primitive if that rises over P: an open one at
 * its side, only there. A closed one that the line misses is met at its cap and at once at its
 * side. */
static void intersect_rim(const struct pen_prims *prims, struct pen_hit q,
                          const struct pen_ray *ray, const struct pen_origin_surface *origin,
                          struct pen_intersections *out)
{
    struct pen_triangle room;
    const struct pen_surface s = pen_surface_at(prims, q.prim, ray->o, &room);
    const struct pen_contact c = pen_contact_at(prims, q, s, ray, origin);
    const struct pen_intersections all = *out;
    bool closed = q.part != PEN_PART_SIDE;
    int i = 0;
    if (closed && all.count > 0)
        return;
    out->count = 0;
    for (; i < all.count && all.t[i] < q.t; i++)
        pen_intersections_add(out, all.t[i], all.part[i]);
    if (pen_contact_rises(&c, ray->d))
        pen_intersections_add(out, q.t, q.part);
    if (closed && out->count > 0)
        pen_intersections_add(out, q.t, PEN_PART_SIDE);
    for (; i < all.count; i++) {
        if (all.t[i] != q.t)
            pen_intersections_add(out, all.t[i], all.part[i]);
    }
}

/* Whether a primitive with rims that does not contain p is left near the ray's origin although it
 * does not rise over P. Then the ray has passed a rim at which a neighbour of P ends, and met the
 * primitive by rounding. Proof: a primitive that does not rise has a chord within the slack of P's
 * tangent plane. The chord is no longer than the slack over the sine of the ray, which is nearby
 * (PEN_HORIZON_SINE). */
static bool ends_below(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                       const struct pen_origin_surface *origin, const struct pen_intersections *met)
{
    struct pen_triangle room;
    const struct pen_kind_functions *fn = pen_prim_row(prims, prim)->fn;
    if (!fn->passes_rim || met->count == 0)
        return false;
    const int last = met->count - 1;
    double t = met->t[last], b = origin->bound + pen_own_rounding(prims, prim, ray->o),
           nearby = PEN_NEARBY * b;
    if (!(t > 0 && t * t <= nearby * nearby * ray->inv_dd) ||
        fn->touches(pen_prim_self(prims, prim, &room), ray->o, origin->bound))
        return false;
    const struct pen_hit q = {t, prim, met->part[last]};
    const struct pen_contact c =
        pen_contact_at(prims, q, pen_surface_at(prims, prim, ray->o, &room), ray, origin);
    return !pen_contact_rises(&c, ray->d);
}

void pen_prim_intersect(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                        const struct pen_origin_surface *origin, struct pen_intersections *out)
{
    struct pen_triangle room;
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
    if (pen_prim_flat(pen_prim_kind(prims, prim))) {
        intersect_flat(prims, prim, pen_surface_at(prims, prim, ray->o, &room), ray, origin, out);
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
                          pen_surface_at(prims, prim, ray->o, &room), ray, origin, out);
        else
            pen_intersections_add(out, all.t[i], all.part[i]);
    }
}

double pen_prim_viewer_side(const struct pen_prims *prims, struct pen_hit hit, struct pen_vec3 p,
                            struct pen_vec3 v, const struct pen_origin_surface *origin)
{
    struct pen_triangle room;
    const struct pen_ray here = {.o = p};
    const struct pen_contact c =
        pen_contact_at(prims, hit, pen_surface_at(prims, hit.prim, p, &room), &here, origin);
    bool layer = hit.t > PEN_FIRST_T && hit.t <= PEN_LAST_LAYER_T;
    double side = layer ? -pen_contact_across(&c, v) : 0;
    if (side == 0)
        side = pen_contact_path_side(&c);
    return side != 0 ? side : -pen_dot(v, c.n);
}

bool pen_prim_ends_ray(const struct pen_prims *prims, struct pen_hit hit, const struct pen_ray *ray,
                       double t_end, double bound)
{
    struct pen_triangle room;
    if (hit.t <= PEN_LAST_LAYER_T)
        return false;
    struct pen_vec3 x = pen_along(ray->o, ray->d, hit.t), p = pen_along(ray->o, ray->d, t_end);
    struct pen_vec3 n = pen_prim_normal(prims, hit, x);
    double b = bound + pen_own_rounding(prims, hit.prim, p);
    if (!(fabs((t_end - hit.t) * pen_dot(ray->d, n)) <= b))
        return false;
    if (!pen_prim_flat(pen_prim_kind(prims, hit.prim)))
        return pen_prim_touches(prims, hit.prim, p, bound) >> hit.part & 1;
    const struct pen_surface s = pen_surface_at(prims, hit.prim, p, &room);
    return pen_surface_contains(s, s.fn->normal(s.self, hit.part, p), p, b);
}
