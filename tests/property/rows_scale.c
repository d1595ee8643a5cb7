/* SPDX-License-Identifier: MIT */
/* Primitives of any kind and one ray, before and after a change that must not matter: scaled by a
 * power of two, moved by a sum that is exact, seen along a direction with a subnormal component. */
#include "property/oracle.h"
#include "property/rows.h"
#include "property/shape.h"

/* H074, H084: times 2^k, k in -200 ... 200; the direction with it or not. */
static void draw_scaled(struct row_draw *d, struct row_case *c)
{
    struct shape s = shape_draw(&d->random, (enum shape_kind)(d->index % SHAPE_KINDS), false);
    row_fixed(c, (double)random_below(&d->random, 401) - 200);
    row_fixed(c, random_below(&d->random, 2));
    shape_put(c, &s);
}

static void judge_scaled(const struct row_case *c, struct row_verdict *v)
{
    int at = 0, power = (int)row_next(c, &at);
    bool with = row_next(c, &at) != 0;
    struct shape_map m = shape_map_identity;
    struct shape s, t;
    struct pen_intersections a, b;
    if (!shape_get(c, &at, &s) || !shape_cross(&s, &a)) {
        row_skip(v);
        return;
    }
    m.factor = ldexp(1, power);
    t = shape_mapped(&m, &s);
    if (with)
        t.d = pen_scale(t.d, m.factor);
    if (row_require(v, shape_cross(&t, &b), "not made when scaled"))
        shape_require_equal(v, s.kind, &a, &b, with ? 1 : m.factor);
}

void rows_scaled(struct pen_row_run *run)
{
    row_each(run, draw_scaled, judge_scaled);
}

/* H076: multiples of 2^-12, moved by 2^20 or 2^30: every sum is exact. Planes and infinite
 * cylinders are made anew near the origin: they are a row of pictures. */
static void draw_moved(struct row_draw *d, struct row_case *c)
{
    static const enum shape_kind kinds[] = {SHAPE_SPHERE, SHAPE_CYLINDER, SHAPE_TRIANGLE,
                                            SHAPE_POLYGON};
    struct shape s = shape_draw(&d->random, kinds[d->index % 4], true);
    row_fixed(c, random_below(&d->random, 2) ? 20 : 30);
    shape_put(c, &s);
}

static bool is_snapped(const struct shape *s)
{
    for (int i = 0; i < shape_points(s->kind); i++)
        if (pen_norm1(pen_sub(shape_snap(s->p[i], true), s->p[i])) != 0)
            return false;
    return pen_norm1(pen_sub(shape_snap(s->o, true), s->o)) == 0 && pen_norm1(s->o) < 1024;
}

static void judge_moved(const struct row_case *c, struct row_verdict *v)
{
    int at = 0, power = (int)row_next(c, &at);
    struct shape_map m = shape_map_identity;
    struct shape s, t;
    struct pen_intersections a, b;
    if (!shape_get(c, &at, &s) || s.kind == SHAPE_INFINITE_CYLINDER || s.kind == SHAPE_PLANE ||
        !is_snapped(&s) || !shape_cross(&s, &a)) {
        row_skip(v);
        return;
    }
    m.shift = pen_scale(pen_vec3(1, -3, .5), ldexp(1, power));
    t = shape_mapped(&m, &s);
    if (row_require(v, shape_cross(&t, &b), "not made when moved"))
        shape_require_equal(v, s.kind, &a, &b, 1);
}

void rows_moved(struct pen_row_run *run)
{
    row_each(run, draw_moved, judge_moved);
}

/* H085: d = (1, 5e-324, 0), (1, -1e-310, 0) and their permutations: as without that component. */
static void draw_subnormal(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    struct shape s = shape_draw(r, (enum shape_kind)(d->index % SHAPE_KINDS), false);
    int turn = (int)random_below(r, 3);
    struct shape_map m = shape_map_identity;
    m.turn = turn;
    s.d = shape_map_way(
        &m, pen_vec3(random_below(r, 2) ? 1 : -1, random_below(r, 2) ? 5e-324 : -1e-310, 0));
    vec3 to = s.kind == SHAPE_TRIANGLE || s.kind == SHAPE_POLYGON
                  ? pen_scale(pen_add(pen_add(s.p[0], s.p[1]), s.p[2]), 1. / 3)
                  : pen_along(s.p[0], random_direction(r), s.r * random_unit(r));
    s.o = pen_sub(to, pen_scale(shape_map_way(&m, pen_vec3(random_in(r, -9, 9), 0, 0)), 1));
    shape_put(c, &s);
}

static double without_subnormal(double x)
{
    return fabs(x) < 0x1p-1000 ? 0 : x;
}

static void judge_subnormal(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    struct shape s, t;
    struct pen_intersections a, b;
    if (!shape_get(c, &at, &s) || !shape_cross(&s, &a)) {
        row_skip(v);
        return;
    }
    t = s;
    t.d = pen_vec3(without_subnormal(s.d.x), without_subnormal(s.d.y), without_subnormal(s.d.z));
    for (int i = 0; i < a.count; i++)
        row_require(v, isfinite(a.t[i]), "t is not finite");
    struct truth depth;
    struct oracle_ray line = {t.o, t.d};
    if (s.kind == SHAPE_PLANE ? !oracle_plane_at(s.p[0], s.a, line, &depth)
                              : s.kind >= SHAPE_TRIANGLE && !oracle_plane(s.p, line, &depth)) {
        row_skip(v); /* what was nearly parallel is so exactly */
        return;
    }
    if (shape_on_border(&s) || !row_require(v, shape_cross(&t, &b), "not made without it"))
        return;
    row_require(v, a.count == b.count, "hit or miss changed");
    for (int i = 0; i < a.count && i < b.count; i++)
        row_measure(v, "t with a subnormal component against t without [ulp]",
                    truth_ulps(a.t[i], (struct truth){b.t[i], 0}), 4);
}

void rows_subnormal(struct pen_row_run *run)
{
    row_each(run, draw_subnormal, judge_subnormal);
}
