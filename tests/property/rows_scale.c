/* SPDX-License-Identifier: MIT */
/* Primitives of any kind and one ray, before and after a change that must not matter: scaled by a
 * power of two, moved by a sum that is exact, mirrored, with axes permuted, seen along a direction
 * with a subnormal component. And rays at the ends of the range: far cameras, planets, mixed
 * scales. */
#include <string.h>

#include "property/bodies.h"
#include "property/gen.h"
#include "property/oracle.h"
#include "property/rows.h"

static struct world world;

enum kind { SPHERE, TUBE, CYLINDER, TRIANGLE, POLYGON, PLANE, KINDS };

/* A body: points (centre, base, a point of the plane, corners), a direction, lengths; and a ray. */
struct shape {
    enum kind kind;
    vec3 p[4], a;
    double r, h;
    vec3 o, d;
};

static int points_of(enum kind kind)
{
    return kind == TRIANGLE ? 3 : kind == POLYGON ? 4 : 1;
}

static void put_shape(struct row_case *c, const struct shape *s)
{
    row_fixed(c, s->kind);
    for (int i = 0; i < points_of(s->kind); i++)
        row_arg3(c, s->p[i]);
    row_arg3(c, s->a);
    row_arg(c, s->r);
    row_arg(c, s->h);
    row_arg3(c, s->o);
    row_arg3(c, s->d);
}

static bool get_shape(const struct row_case *c, int *at, struct shape *s)
{
    s->kind = (enum kind)row_next(c, at);
    if (s->kind >= KINDS)
        return false;
    for (int i = 0; i < points_of(s->kind); i++)
        s->p[i] = row_next3(c, at);
    s->a = row_next3(c, at);
    s->r = fabs(row_next(c, at));
    s->h = fabs(row_next(c, at));
    s->o = row_next3(c, at);
    s->d = row_next3(c, at);
    return true;
}

/* Multiples of 2^-12 if `snapped`. */
static vec3 snap(vec3 p, bool snapped)
{
    return snapped ? pen_vec3(ldexp(nearbyint(ldexp(p.x, 12)), -12),
                              ldexp(nearbyint(ldexp(p.y, 12)), -12),
                              ldexp(nearbyint(ldexp(p.z, 12)), -12))
                   : p;
}

static struct shape draw_shape(struct random *r, enum kind kind, bool snapped)
{
    struct shape s = {.kind = kind};
    vec3 at = snap(random_vec(r, 2), snapped), x, y;
    s.a = random_below(r, 4) ? random_direction(r) : gen_axial(r);
    s.r = random_in(r, .1, 1);
    s.h = random_in(r, .2, 2);
    gen_frame(r, pen_normalize(s.a), &x, &y);
    s.p[0] = at;
    s.p[1] = snap(pen_along(at, x, random_in(r, .5, 1)), snapped);
    s.p[2] = snap(pen_along(s.p[1], y, random_in(r, .5, 1)), snapped);
    s.p[3] = pen_add(at, pen_sub(s.p[2], s.p[1]));
    vec3 to = pen_add(at, random_vec(r, .8));
    if (kind == TRIANGLE || kind == POLYGON) {
        double i = random_below(r, 3) ? random_unit(r) : random_below(r, 3) / 2.;
        to = pen_along(pen_along(at, pen_sub(s.p[1], at), i), pen_sub(s.p[2], s.p[1]),
                       i * random_unit(r));
    }
    s.o = snap(pen_along(at, random_direction(r), gen_power(r, 0, 1)), snapped);
    s.d = gen_toward(r, s.o, to);
    return s;
}

/* What is done to coordinates: the sign of each, a cyclic permutation, a factor, a shift. */
struct map {
    vec3 sign, shift;
    int turn;
    double factor;
};

static const struct map identity = {{1, 1, 1}, {0, 0, 0}, 0, 1};

static vec3 map_way(const struct map *m, vec3 v)
{
    v = pen_mul(v, m->sign);
    return m->turn == 0 ? v : m->turn == 1 ? pen_vec3(v.y, v.z, v.x) : pen_vec3(v.z, v.x, v.y);
}

static vec3 map_point(const struct map *m, vec3 p)
{
    return pen_add(pen_scale(map_way(m, p), m->factor), m->shift);
}

static struct shape map_shape(const struct map *m, const struct shape *s)
{
    struct shape t = *s;
    for (int i = 0; i < 4; i++)
        t.p[i] = map_point(m, s->p[i]);
    t.a = map_way(m, s->a);
    t.r = s->r * m->factor;
    t.h = s->h * m->factor;
    t.o = map_point(m, s->o);
    t.d = map_way(m, s->d);
    return t;
}

/* The crossings of the shape's own ray; false if the body or the ray can not be made. */
static bool cross(const struct shape *s, struct pen_crossings *out)
{
    struct pen_ray ray;
    bool made;
    world_clear(&world);
    world.prims.count = 1;
    world.ref[0].kind = (uint32_t)(s->kind == SPHERE     ? PEN_PRIM_SPHERE
                                   : s->kind == TUBE     ? PEN_PRIM_TUBE
                                   : s->kind == CYLINDER ? PEN_PRIM_CYLINDER
                                   : s->kind == TRIANGLE ? PEN_PRIM_TRIANGLE
                                   : s->kind == POLYGON  ? PEN_PRIM_POLYGON
                                                         : PEN_PRIM_PLANE) &
                        15u;
    world.ref[0].index = 0;
    switch (s->kind) {
    case SPHERE:
        made = pen_sphere_make(&world.sphere[0], s->p[0], s->r);
        break;
    case TUBE:
        made = pen_tube_make(&world.tube[0], s->p[0], s->a, s->r);
        break;
    case CYLINDER:
        made = pen_cylinder_make(&world.cylinder[0], s->p[0], s->a, s->r, s->h, true);
        break;
    case TRIANGLE:
        made = pen_triangle_make(&world.triangle[0], s->p[0], s->p[1], s->p[2]);
        break;
    case POLYGON:
        memcpy(world.corner, s->p, sizeof s->p);
        made = pen_polygon_make(&world.polygon[0], world.corner, 4);
        break;
    default:
        made = pen_plane_make(&world.plane[0], s->p[0], s->a);
    }
    if (!made || !pen_ray_make(&ray, s->o, s->d))
        return false;
    pen_prim_cross(&world.prims, 0, &ray, &pen_leave_nothing, out);
    return true;
}

static const char *const kind_name[] = {"sphere",   "tube",    "cylinder",
                                        "triangle", "polygon", "plane"};

/* The same crossings, t multiplied by `factor`, bit for bit. */
static void require_equal(struct row_verdict *v, enum kind kind, const struct pen_crossings *a,
                          const struct pen_crossings *b, double factor)
{
    if (a->count != b->count) {
        row_fail(v, "%s: %d crossings became %d", kind_name[kind], a->count, b->count);
        return;
    }
    for (int i = 0; i < a->count; i++) {
        if (a->t[i] * factor != b->t[i])
            row_fail(v, "%s: t = %a became %a", kind_name[kind], a->t[i], b->t[i]);
        if (a->part[i] != b->part[i])
            row_fail(v, "%s: the part changed", kind_name[kind]);
    }
}

/* H074, H084: times 2^k, k in -200 ... 200; the direction with it or not. */
static void draw_scaled(struct row_draw *d, struct row_case *c)
{
    struct shape s = draw_shape(&d->random, (enum kind)(d->index % KINDS), false);
    row_fixed(c, (double)random_below(&d->random, 401) - 200);
    row_fixed(c, random_below(&d->random, 2));
    put_shape(c, &s);
}

static void judge_scaled(const struct row_case *c, struct row_verdict *v)
{
    int at = 0, power = (int)row_next(c, &at);
    bool with = row_next(c, &at) != 0;
    struct map m = identity;
    struct shape s, t;
    struct pen_crossings a, b;
    if (!get_shape(c, &at, &s) || !cross(&s, &a)) {
        row_skip(v);
        return;
    }
    m.factor = ldexp(1, power);
    t = map_shape(&m, &s);
    if (with)
        t.d = pen_scale(t.d, m.factor);
    if (row_require(v, cross(&t, &b), "not made when scaled"))
        require_equal(v, s.kind, &a, &b, with ? 1 : m.factor);
}

void rows_scaled(struct pen_row_run *run)
{
    row_each(run, draw_scaled, judge_scaled);
}

/* H076: multiples of 2^-12, moved by 2^20 or 2^30: every sum is exact. Planes and tubes are made
 * anew near the origin: they are a row of pictures. */
static void draw_moved(struct row_draw *d, struct row_case *c)
{
    static const enum kind kinds[] = {SPHERE, CYLINDER, TRIANGLE, POLYGON};
    struct shape s = draw_shape(&d->random, kinds[d->index % 4], true);
    row_fixed(c, random_below(&d->random, 2) ? 20 : 30);
    put_shape(c, &s);
}

static bool is_snapped(const struct shape *s)
{
    for (int i = 0; i < points_of(s->kind); i++)
        if (pen_norm1(pen_sub(snap(s->p[i], true), s->p[i])) != 0)
            return false;
    return pen_norm1(pen_sub(snap(s->o, true), s->o)) == 0 && pen_norm1(s->o) < 1024;
}

static void judge_moved(const struct row_case *c, struct row_verdict *v)
{
    int at = 0, power = (int)row_next(c, &at);
    struct map m = identity;
    struct shape s, t;
    struct pen_crossings a, b;
    if (!get_shape(c, &at, &s) || s.kind == TUBE || s.kind == PLANE || !is_snapped(&s) ||
        !cross(&s, &a)) {
        row_skip(v);
        return;
    }
    m.shift = pen_scale(pen_vec3(1, -3, .5), ldexp(1, power));
    t = map_shape(&m, &s);
    if (row_require(v, cross(&t, &b), "not made when moved"))
        require_equal(v, s.kind, &a, &b, 1);
}

void rows_moved(struct pen_row_run *run)
{
    row_each(run, draw_moved, judge_moved);
}

/* Whether the outline passes the ray so near that either answer may be given. */
static bool on_border(const struct shape *s)
{
    bool unsure = false;
    if (s->kind == TRIANGLE || s->kind == POLYGON)
        oracle_winding(s->p, points_of(s->kind), (struct oracle_ray){s->o, s->d}, 8, &unsure);
    return unsure;
}

/* H078: any coordinates negated. Triangles are a row of their own. */
static void draw_mirrored_kind(struct random *r, enum kind kind, struct row_case *c)
{
    struct shape s = draw_shape(r, kind, false);
    row_fixed(c, 1 + random_below(r, 7));
    put_shape(c, &s);
}

static void draw_mirrored(struct row_draw *d, struct row_case *c)
{
    static const enum kind kinds[] = {SPHERE, TUBE, CYLINDER, POLYGON, PLANE};
    draw_mirrored_kind(&d->random, kinds[d->index % 5], c);
}

static void draw_mirrored_triangle(struct row_draw *d, struct row_case *c)
{
    draw_mirrored_kind(&d->random, TRIANGLE, c);
}

static void judge_mirrored(const struct row_case *c, struct row_verdict *v)
{
    int at = 0, bits = (int)row_next(c, &at);
    struct map m = identity;
    struct shape s, t;
    struct pen_crossings a, b;
    m.sign = pen_vec3(bits & 1 ? -1 : 1, bits & 2 ? -1 : 1, bits & 4 ? -1 : 1);
    if (!get_shape(c, &at, &s) || !cross(&s, &a) || on_border(&s)) {
        row_skip(v);
        return;
    }
    t = map_shape(&m, &s);
    if (row_require(v, cross(&t, &b), "not made in the mirror"))
        require_equal(v, s.kind, &a, &b, 1);
}

void rows_mirrored(struct pen_row_run *run)
{
    row_each(run, draw_mirrored, judge_mirrored);
}

void rows_mirrored_triangle(struct pen_row_run *run)
{
    row_each(run, draw_mirrored_triangle, judge_mirrored);
}

/* H079: (x, y, z) to (y, z, x) and on. */
static void draw_turned_kind(struct random *r, enum kind kind, struct row_case *c)
{
    struct shape s = draw_shape(r, kind, false);
    row_fixed(c, 1 + random_below(r, 2));
    put_shape(c, &s);
}

static void draw_turned(struct row_draw *d, struct row_case *c)
{
    static const enum kind kinds[] = {SPHERE, TUBE, POLYGON};
    draw_turned_kind(&d->random, kinds[d->index % 3], c);
}

static void draw_turned_sums(struct row_draw *d, struct row_case *c)
{
    static const enum kind kinds[] = {TRIANGLE, CYLINDER, PLANE};
    draw_turned_kind(&d->random, kinds[d->index % 3], c);
}

/* Rays that graze, or start near what they meet, are rows of their own. */
static bool well_conditioned(const struct shape *s)
{
    struct oracle_round b = {s->p[0], s->kind == SPHERE ? pen_vec3(0, 0, 0) : s->a, s->r, s->h};
    struct oracle_ray line = {s->o, s->d};
    vec3 n =
        s->kind == PLANE ? s->a : pen_cross(pen_sub(s->p[1], s->p[0]), pen_sub(s->p[2], s->p[0]));
    if (s->kind <= CYLINDER)
        return oracle_distance(&b, line) > 2 && oracle_passing(&b, line) < .9;
    if (fabs(pen_dot(n, pen_sub(s->p[0], s->o))) <
        .5 * pen_length(n) * (pen_length(s->p[0]) + pen_length(s->o)))
        return false;
    return fabs(pen_dot(n, s->d)) > .1 * pen_length(n) * pen_length(s->d);
}

static void judge_turned(const struct row_case *c, struct row_verdict *v)
{
    static const char *const name[] = {"sphere, t [ulp]",   "tube, t [ulp]",    "cylinder, t [ulp]",
                                       "triangle, t [ulp]", "polygon, t [ulp]", "plane, t [ulp]"};
    int at = 0;
    struct map m = identity;
    struct shape s, t;
    struct pen_crossings a, b;
    m.turn = (int)row_next(c, &at);
    if (!get_shape(c, &at, &s) || !cross(&s, &a) || on_border(&s) || !well_conditioned(&s)) {
        row_skip(v);
        return;
    }
    t = map_shape(&m, &s);
    if (!row_require(v, cross(&t, &b), "not made with axes permuted"))
        return;
    if (!row_require(v, a.count == b.count, "hit or miss changed with the axes"))
        return;
    for (int i = 0; i < a.count; i++)
        row_measure(v, name[s.kind], truth_ulps(b.t[i], (struct truth){a.t[i], 0}), 2);
}

void rows_turned(struct pen_row_run *run)
{
    row_each(run, draw_turned, judge_turned);
}

void rows_turned_sums(struct pen_row_run *run)
{
    row_each(run, draw_turned_sums, judge_turned);
}

/* H085: d = (1, 5e-324, 0), (1, -1e-310, 0) and their permutations: as without that component. */
static void draw_subnormal(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    struct shape s = draw_shape(r, (enum kind)(d->index % KINDS), false);
    int turn = (int)random_below(r, 3);
    struct map m = identity;
    m.turn = turn;
    s.d = map_way(&m,
                  pen_vec3(random_below(r, 2) ? 1 : -1, random_below(r, 2) ? 5e-324 : -1e-310, 0));
    vec3 to = s.kind == TRIANGLE || s.kind == POLYGON
                  ? pen_scale(pen_add(pen_add(s.p[0], s.p[1]), s.p[2]), 1. / 3)
                  : pen_along(s.p[0], random_direction(r), s.r * random_unit(r));
    s.o = pen_sub(to, pen_scale(map_way(&m, pen_vec3(random_in(r, -9, 9), 0, 0)), 1));
    put_shape(c, &s);
}

static double without_subnormal(double x)
{
    return fabs(x) < 0x1p-1000 ? 0 : x;
}

static void judge_subnormal(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    struct shape s, t;
    struct pen_crossings a, b;
    if (!get_shape(c, &at, &s) || !cross(&s, &a)) {
        row_skip(v);
        return;
    }
    t = s;
    t.d = pen_vec3(without_subnormal(s.d.x), without_subnormal(s.d.y), without_subnormal(s.d.z));
    for (int i = 0; i < a.count; i++)
        row_require(v, isfinite(a.t[i]), "t is not finite");
    struct truth depth;
    struct oracle_ray line = {t.o, t.d};
    if (s.kind == PLANE ? !oracle_plane_at(s.p[0], s.a, line, &depth)
                        : s.kind >= TRIANGLE && !oracle_plane(s.p, line, &depth)) {
        row_skip(v); /* what was nearly parallel is so exactly */
        return;
    }
    if (on_border(&s) || !row_require(v, cross(&t, &b), "not made without it"))
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
