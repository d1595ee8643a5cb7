/* SPDX-License-Identifier: MIT */
/* The crossings of a ray that starts on a surface: the rule stated in pen/geom/prims.h. */
#include <float.h>

#include "kinds.h"

/* A crossing at the origin that counts is reported here: behind nothing, before everything. */
static const double first_t = DBL_TRUE_MIN;

static double max2(double a, double b)
{
    return a > b ? a : b;
}

static bool is_flat(uint32_t kind)
{
    return kind == PEN_PRIM_PLANE || kind == PEN_PRIM_TRIANGLE || kind == PEN_PRIM_POLYGON;
}

/* By how much a crossing of the primitive near p may miss it. */
static double own_rounding(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p)
{
    return 8 * PEN_U * pen_prim_scale(prims, prim, p);
}

/* How far primitive q reaches along unit vector n beyond point p. */
static double reach(const struct pen_prims *prims, uint32_t q, struct pen_vec3 n, struct pen_vec3 p)
{
    const struct pen_prim_ref ref = prims->ref[q];
    double far = -INFINITY;
    if (ref.kind == PEN_PRIM_SPHERE) {
        const struct pen_sphere *s = &prims->sphere[ref.index];
        return pen_dot(n, pen_sub(s->c, p)) + s->r;
    }
    if (ref.kind == PEN_PRIM_TRIANGLE) {
        for (int i = 0; i < 3; i++)
            far = max2(far, pen_dot(n, pen_sub(prims->triangle[ref.index].v[i], p)));
        return far;
    }
    if (ref.kind == PEN_PRIM_POLYGON) {
        const struct pen_polygon *pg = &prims->polygon[ref.index];
        for (uint32_t i = 0; i < pg->count; i++)
            far = max2(far, pen_dot(n, pen_sub(pg->v[i], p)));
        return far;
    }
    if (ref.kind == PEN_PRIM_CYLINDER) {
        const struct pen_cylinder *c = &prims->cylinder[ref.index];
        double along = pen_dot(n, c->round.a) / c->round.length;
        double rim = c->round.r * pen_length(pen_cross(n, c->round.a)) / c->round.length;
        return pen_dot(n, pen_sub(c->round.q, p)) + rim + max2(0, along * c->h);
    }
    return INFINITY;
}

/* Whether a crossing of q at the ray's origin counts. */
static bool origin_counts(const struct pen_prims *prims, struct pen_hit q,
                          const struct pen_ray *ray, const struct pen_leave *leave)
{
    struct pen_vec3 n = pen_prim_normal(prims, q, ray->o);
    double dn = pen_dot(ray->d, n), wn = pen_dot(leave->toward, n);
    bool same_side = (dn > 0 && wn > 0) || (dn < 0 && wn < 0);
    bool across = (dn > 0 && wn < 0) || (dn < 0 && wn > 0);
    if (leave->through ? !same_side : !across)
        return false;
    struct pen_hit left = {0, leave->prim, leave->part};
    struct pen_vec3 m = pen_prim_normal(prims, left, ray->o);
    double dm = pen_dot(ray->d, m);
    double slack = leave->bound + own_rounding(prims, q.prim, ray->o);
    return dm == 0 || reach(prims, q.prim, dm > 0 ? m : pen_neg(m), ray->o) > slack;
}

/* The primitive that the ray leaves: it is left at the leave's part, and can be met once more if
 * the ray goes inward. */
static void cross_own(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                      uint8_t part, struct pen_crossings *out)
{
    const struct pen_prim_ref ref = prims->ref[prim];
    struct pen_inside in;
    out->count = 0;
    if (ref.kind == PEN_PRIM_SPHERE)
        out->t[0] = pen_sphere_chord(&prims->sphere[ref.index], ray);
    else if (ref.kind == PEN_PRIM_TUBE)
        out->t[0] = pen_round_chord(&prims->tube[ref.index].round, ray);
    else if (ref.kind == PEN_PRIM_CYLINDER &&
             pen_cylinder_inward(&prims->cylinder[ref.index], ray, part, &in)) {
        out->t[0] = max2(in.hi, first_t);
        out->part[0] = in.hi_part;
        out->count = prims->cylinder[ref.index].caps || in.hi_part == PEN_PART_SIDE;
        return;
    } else {
        return;
    }
    out->part[0] = PEN_PART_SIDE;
    out->count = out->t[0] > 0;
}

/* The crossings of a quadric whose side contains the origin. */
static void cross_chord(double chord, struct pen_crossings *out)
{
    out->t[0] = chord < 0 ? chord : 0;
    out->t[1] = chord < 0 ? 0 : chord;
    out->count = chord == 0 ? 0 : 2;
}

/* Replaces the crossings of a quadric that contains the origin within the bounds: the one that
 * is the origin gets t = 0, exactly. */
static void quadric_touching(const struct pen_prims *prims, uint32_t prim,
                             const struct pen_ray *ray, double bound, struct pen_crossings *out)
{
    const struct pen_prim_ref ref = prims->ref[prim];
    if (ref.kind == PEN_PRIM_SPHERE) {
        if (pen_sphere_touches(&prims->sphere[ref.index], ray->o, bound))
            cross_chord(pen_sphere_chord(&prims->sphere[ref.index], ray), out);
    } else if (ref.kind == PEN_PRIM_TUBE) {
        const struct pen_tube *tube = &prims->tube[ref.index];
        if (pen_round_touches(&tube->round, ray->o, bound + pen_tube_rounding(tube)))
            cross_chord(pen_round_chord(&tube->round, ray), out);
    } else if (ref.kind == PEN_PRIM_CYLINDER) {
        const struct pen_cylinder *c = &prims->cylinder[ref.index];
        unsigned on = pen_cylinder_touches(c, ray->o, bound);
        struct pen_inside in;
        if (on == 0)
            return;
        out->count = 0;
        if (pen_cylinder_inside_from(c, ray, on, &in))
            pen_inside_ends(c, &in, out);
    }
}

/* Whether the crossing of a flat body is the ray's origin, within the bounds. */
static bool flat_touches(const struct pen_prims *prims, struct pen_hit hit,
                         const struct pen_ray *ray, double bound)
{
    return pen_flat_touches(pen_prim_normal(prims, hit, ray->o),
                            pen_prim_scale(prims, hit.prim, ray->o), ray, hit.t, bound);
}

void pen_prim_cross(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                    const struct pen_leave *leave, struct pen_crossings *out)
{
    if (prim == leave->prim) {
        cross_own(prims, prim, ray, leave->part, out);
        return;
    }
    pen_prim_cross_line(prims, prim, ray, out);
    if (leave->prim == PEN_NO_PRIM || out->count == 0)
        return;
    struct pen_crossings all = *out;
    bool flat = is_flat(prims->ref[prim].kind);
    if (!flat)
        quadric_touching(prims, prim, ray, leave->bound, &all);
    out->count = 0;
    for (int i = 0; i < all.count; i++) {
        struct pen_hit hit = {all.t[i], prim, all.part[i]};
        if (flat ? flat_touches(prims, hit, ray, leave->bound) : hit.t == 0) {
            if (!origin_counts(prims, hit, ray, leave))
                continue;
            hit.t = max2(hit.t, first_t);
        }
        out->t[out->count] = hit.t;
        out->part[out->count++] = hit.part;
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
    if (ref.kind == PEN_PRIM_TUBE) {
        const struct pen_tube *tube = &prims->tube[ref.index];
        return pen_round_touches(&tube->round, p, bound + pen_tube_rounding(tube));
    }
    return true;
}
