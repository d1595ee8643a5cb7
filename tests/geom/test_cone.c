/* SPDX-License-Identifier: MIT */
/* Cones: pointed and truncated, capped and open. */
#include "geom/quad.h"
#include "geom/rows.h"
#include "support/suite.h"

static struct pen_vec3 cone_normal(const struct pen_cone *c, uint8_t part, struct pen_vec3 p)
{
    return pen_kinds[PEN_PRIM_CONE].fn->normal(c, part, p);
}

static struct pen_vec3 cone_project(const struct pen_cone *c, uint8_t part, struct pen_vec3 p)
{
    return pen_kinds[PEN_PRIM_CONE].fn->project(c, part, p);
}

static struct pen_box cone_bounds(const struct pen_cone *c)
{
    return pen_kinds[PEN_PRIM_CONE].fn->bounds(c);
}

static struct world world;

/* Base radius 2 at 0, along z; pointed of height 2, or truncated to radius 1 at height 1: the side
 * is at 45 degrees. */
static void standing(bool pointed, bool caps)
{
    const double radius[2] = {2, pointed ? 0 : 1};
    world_clear(&world);
    world_cone(&world, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), radius, pointed ? 2 : 1, caps);
}

START_TEST(test_cone__normals_go_by_part)
{
    static const struct {
        vec3 p;
        uint8_t part;
        vec3 n;
    } row[] = {{{0, 1, 1}, PEN_PART_SIDE, {0, M_SQRT1_2, M_SQRT1_2}},
               {{-1.5, 0, .5}, PEN_PART_SIDE, {-M_SQRT1_2, 0, M_SQRT1_2}},
               {{.5, 0, 0}, PEN_PART_BASE, {0, 0, -1}},
               {{2, 0, 0}, PEN_PART_BASE, {0, 0, -1}},
               {{0, 0, 2}, PEN_PART_SIDE, {0, 0, 1}},        /* the apex */
               {{0, 0x1p-52, 2}, PEN_PART_SIDE, {0, 0, 1}}}; /* within rounding of it */
    standing(true, true);
    for (int i = 0; i < ROWS(row); i++) {
        vec3 n = pen_sub(cone_normal(&world.cone[0], row[i].part, row[i].p), row[i].n);
        ck_assert_msg(pen_norm1(n) <= 4 * PEN_U, "row %d", i);
    }
    const double radius[2] = {1, 3};
    struct pen_cone wide;
    ck_assert(
        pen_cone_make(&wide, pen_vec3(0, 0, 0), pen_vec3(0, 2, 0), radius[0], radius[1], 1, true));
    vec3 n = cone_normal(&wide, PEN_PART_SIDE, pen_vec3(2, .5, 0));
    ck_assert_double_eq_tol(n.x, 1 / sqrt(5), 4 * PEN_U);
    ck_assert_double_eq_tol(n.y, -2 / sqrt(5), 4 * PEN_U);
    n = cone_normal(&wide, PEN_PART_TOP, pen_vec3(2, 1, 0));
    ck_assert(n.x == 0 && n.y == 1 && n.z == 0);
}
END_TEST

START_TEST(test_cone__a_pointed_one_is_met)
{
    const struct row rows[] = {
        {{0, 0, -1}, {0, 0, 1}, 2, {{0, 0, 0}, {0, 0, 2}}}, /* along the axis, out at the apex */
        {{.5, .5, 5}, {0, 0, -2}, 2, {{.5, .5, 2 - M_SQRT1_2}, {.5, .5, 0}}},
        {{-3, 0, 1}, {1, 0, 0}, 2, {{-1, 0, 1}, {1, 0, 1}}},
        {{0, 0, 1}, {1, 0, 0}, ONE(1, 0, 1)},
        {{0, 0, 1}, {0, 0, 1}, ONE(0, 0, 2)},
        {{0, 0, 1}, {0, 0, -1}, ONE(0, 0, 0)},
        {{0, 0, 1}, {1, 0, 1}, ONE(.5, 0, 1.5)}, /* across the slant */
        {{0, 0, 1}, {1, 0, -1}, ONE(1, 0, 0)},   /* parallel to the side: the other root is far */
        {{0, 0, 1}, {1, 0, -2}, ONE(.5, 0, 0)},  /* steeper than the side */
        {{-1, 0, 4}, {1, 0, -1}, NONE},          /* in the plane that touches the side: beside */
        {{0, 0, 3}, {1, 0, -1}, NONE},           /* parallel to the side, outside */
        {{-1, 0, 3}, {1, 0, -1}, NONE},          /* along the side, through the apex */
        {{-3, 0, 3}, {1, 0, 0}, NONE},           /* the other nappe is not there */
        {{0, 0, 3}, {1, 0, 0}, NONE},            /* nor from inside it */
        {{0, 0, 4}, {1, 0, 8}, NONE},
        {{0, 0, 3},
         {.25, 0, -1},
         2,
         {{1.0 / 3, 0, 5.0 / 3}, {.75, 0, 0}}},               /* through both nappes */
        {{-3, 0, 2}, {1, 0, 0}, NONE},                        /* touches the apex */
        {{-2, 0, -1}, {1, 0, 0}, NONE},                       /* below */
        {{-3, 0, 0}, {1, 0, 0}, 2, {{-2, 0, 0}, {2, 0, 0}}}}; /* in the base's plane */
    standing(true, true);
    rows_check(&world, rows, ROWS(rows), 2);
}
END_TEST

START_TEST(test_cone__a_truncated_one_is_met)
{
    const struct row rows[] = {
        {{0, 0, -1}, {0, 0, 1}, 2, {{0, 0, 0}, {0, 0, 1}}},
        {{1.5, 0, 5}, {0, 0, -1}, 2, {{1.5, 0, .5}, {1.5, 0, 0}}},
        {{-3, 0, .5}, {1, 0, 0}, 2, {{-1.5, 0, .5}, {1.5, 0, .5}}},
        {{0, 0, 2}, {.25, 0, -1}, 2, {{.25, 0, 1}, {.5, 0, 0}}}, /* near where the apex would be */
        {{0, 0, 2}, {1, 0, 0}, NONE},
        {{-3, 0, 1}, {1, 0, 0}, NONE}, /* in the top's plane */
        {{0, 0, .5}, {1, 0, 1}, ONE(.5, 0, 1)}};
    standing(false, true);
    rows_check(&world, rows, ROWS(rows), 2);
}
END_TEST

START_TEST(test_cone__an_open_one_has_no_caps)
{
    const struct row rows[] = {{{0, 0, -1}, {0, 0, 1}, NONE},
                               {{0, 0, .5}, {1, 0, 0}, ONE(1.5, 0, .5)},
                               {{1.5, 0, 5}, {0, 0, -1}, ONE(1.5, 0, .5)}, /* out at the base */
                               {{-3, 0, .5}, {1, 0, 0}, 2, {{-1.5, 0, .5}, {1.5, 0, .5}}},
                               {{0, 0, 2}, {1.5, 0, -1}, NONE}}; /* in at the top, out at the rim */
    standing(false, false);
    rows_check(&world, rows, ROWS(rows) - 1, 2);
    standing(true, false);
    const struct row pointed[] = {{{0, 0, -1}, {0, 0, 1}, ONE(0, 0, 2)}, /* the apex from inside */
                                  {{0, 0, 5}, {0, 0, -1}, ONE(0, 0, 2)},
                                  {{.5, 0, 5}, {0, 0, -1}, ONE(.5, 0, 1.5)}};
    rows_check(&world, pointed, ROWS(pointed), 2);
}
END_TEST

START_TEST(test_cone__bad_input_is_refused)
{
    struct pen_cone c;
    vec3 o = pen_vec3(0, 0, 0), z = pen_vec3(0, 0, 1);
    ck_assert(pen_cone_make(&c, o, z, 1, 0, 1, true));
    ck_assert(!pen_cone_make(&c, o, o, 1, 0, 1, true));
    ck_assert(!pen_cone_make(&c, o, z, 0, 1, 1, true));
    ck_assert(!pen_cone_make(&c, o, z, 1, -1, 1, true));
    ck_assert(!pen_cone_make(&c, o, z, 1, (double)NAN, 1, true));
    ck_assert(!pen_cone_make(&c, o, z, (double)NAN, 1, 1, true));
    ck_assert(!pen_cone_make(&c, o, z, 1, 0, 0, true));
    ck_assert(!pen_cone_make(&c, o, z, 1, 0, (double)INFINITY, true));
    ck_assert(!pen_cone_make(&c, o, z, 0x1p-300, 0, 1, true)); /* as steep as this */
    ck_assert(!pen_cone_make(&c, o, z, 0x1p300, 1, 1, true));  /* as shallow */
    ck_assert(!pen_cone_make(&c, o, z, 1, 0x1p-401, 1, true));
}
END_TEST

/* Equal radii, which a group's scale may round to, make a cylinder. */
START_TEST(test_cone__equal_radii_are_a_cylinder)
{
    struct random r = random_begin(51);
    struct pen_cylinder cylinder;
    struct pen_cone cone;
    int met = 0;
    for (int i = 0; i < 5000; i++) {
        vec3 base = random_vec(&r, 1), axis = i % 5 ? random_direction(&r) : pen_vec3(0, 0, 1);
        double radius = random_in(&r, .1, 1), h = random_in(&r, .1, 3);
        ck_assert(pen_cylinder_make(&cylinder, base, axis, radius, h, true));
        ck_assert(pen_cone_make(&cone, base, axis, radius, radius, h, true));
        vec3 o = random_vec(&r, 3), d = i % 3 ? pen_sub(random_vec(&r, 1), o) : axis;
        struct pen_ray ray = world_ray(o, d);
        struct pen_interval a, b;
        bool in = pen_cylinder_interval(&cylinder, &ray, &a);
        ck_assert_int_eq(in, pen_cone_interval(&cone, &ray, &b));
        met += in;
        if (in)
            ck_assert(fabs(a.lo - b.lo) <= 1e-12 && fabs(a.hi - b.hi) <= 1e-12);
    }
    ck_assert_int_gt(met, 500);
}
END_TEST

static double random_power(struct random *r, int lo, int hi)
{
    static const double ten[] = {1,    .1,   .01,  1e-3,  1e-4,  1e-5, 1e-6,
                                 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12};
    return ten[lo + (int)random_below(r, (uint32_t)(hi - lo + 1))];
}

/* Some cone of about size 1: pointed, truncated, nearly a cylinder, flat, a needle; either way up.
 */
static struct pen_cone some_cone(struct random *r, bool caps)
{
    struct pen_cone c;
    double radius[2] = {1, random_below(r, 2) ? 0 : random_in(r, .01, .99)};
    double h = random_in(r, .2, 3);
    switch (random_below(r, 6)) {
    case 0:
        radius[1] = 1 - random_power(r, 1, 9);
        break;
    case 1:
        h = random_power(r, 1, 6);
        break;
    case 2:
        radius[0] = random_power(r, 1, 6);
        radius[1] *= radius[0];
        break;
    default:
        break;
    }
    bool turn = radius[1] > 0 && random_below(r, 2);
    ck_assert(pen_cone_make(&c, random_vec(r, 1), random_direction(r), radius[turn], radius[!turn],
                            h, caps));
    return c;
}

/* A direction across the cone's axis. */
static vec3 across(struct random *r, const struct pen_cone *c)
{
    return pen_normalize(pen_cross(c->hull.round.a, random_direction(r)));
}

static vec3 axis_of(const struct pen_cone *c)
{
    return pen_normalize(c->hull.round.a);
}

/* A point of the side, a rim or a cap, for rays to be aimed at. */
static vec3 surface_point(struct random *r, const struct pen_cone *c)
{
    static const double near[] = {0, 1e-12, 1e-9, 1e-6, 1e-3};
    double s = random_in(r, 0, 1), share = 1;
    switch (random_below(r, 6)) {
    case 0:
        s = random_below(r, 2); /* a rim, or the apex */
        break;
    case 1:
        s = 1 - near[random_below(r, 5)]; /* near the top */
        break;
    case 2:
        s = random_below(r, 2);
        share = random_in(r, 0, 1); /* a cap */
        break;
    default:
        break;
    }
    double radius = share * (c->base_radius + s * (c->top_radius - c->base_radius));
    return pen_along(pen_along(c->hull.round.q, axis_of(c), s * c->hull.h), across(r, c), radius);
}

static double size_of(const struct pen_cone *c)
{
    return c->hull.round.r + c->hull.h;
}

/* Rays aimed at the surface have an entry and an exit, or neither; from inside they have one exit.
 */
START_TEST(test_cone__intersections_pair_up)
{
    struct random r = random_begin(52);
    int hits = 0;
    for (int i = 0; i < 40000; i++) {
        world_clear(&world);
        struct pen_cone c = world.cone[0] = some_cone(&r, true);
        double radius[2] = {c.base_radius, c.top_radius};
        world_cone(&world, c.hull.round.q, c.hull.round.a, radius, c.hull.h, true);
        vec3 middle = pen_along(c.hull.round.q, axis_of(&c), .3 * c.hull.h);
        vec3 at = surface_point(&r, &c), out = pen_along(middle, random_direction(&r), 10);
        int from_outside = world_count(&world, out, pen_sub(at, out));
        int from_inside = world_count(&world, middle, pen_sub(at, middle));
        ck_assert_msg(from_outside % 2 == 0, "%d: %d from outside", i, from_outside);
        ck_assert_msg(from_inside == 1, "%d: %d from inside", i, from_inside);
        hits += from_outside / 2;
    }
    ck_assert(hits > 10000 && hits < 38000);
}
END_TEST

/* The quadratic equation of the side, in quad: a t^2 + 2 b t + c < 0 inside. */
struct equation {
    quad a, b, c, k, w;
};

static struct equation equation_quad(const struct pen_cone *cone, const struct pen_ray *ray)
{
    struct quad3 a = quad3(cone->hull.round.a), d = quad3(ray->d);
    struct quad3 f = quad_sub(quad3(ray->o), quad3(cone->hull.round.q));
    struct quad3 m = quad_cross(d, a), n = quad_cross(f, a);
    quad slope = ((quad)cone->top_radius - cone->base_radius) / cone->hull.h;
    struct equation e;
    e.k = slope * quad_dot(d, a);
    e.w = cone->base_radius * quad_sqrt(quad_dot(a, a)) + slope * quad_dot(f, a);
    e.a = quad_dot(m, m) - e.k * e.k;
    e.b = quad_dot(m, n) - e.k * e.w;
    e.c = quad_dot(n, n) - e.w * e.w;
    return e;
}

/* The interval of the ray's line inside, in quad; false if rounding of the inputs could change hit
 * or miss. */
static bool inside_quad(const struct pen_cone *c, const struct pen_ray *ray, quad t[2],
                        uint8_t part[2], bool *met)
{
    struct equation e = equation_quad(c, ray);
    struct quad3 a = quad3(c->hull.round.a), f = quad_sub(quad3(ray->o), quad3(c->hull.round.q));
    quad da = quad_dot(quad3(ray->d), a), fa = quad_dot(f, a), far = 1e30L;
    quad top = (c->hull.h * quad_sqrt(quad_dot(a, a)) - fa) / da, base = -fa / da;
    quad lo = da > 0 ? base : top, hi = da > 0 ? top : base, side[2] = {-far, far}, root[2];
    quad disc = quad_roots(e.a, e.b, e.c, root), slack = (quad)1e-9 * (hi - lo);
    *met = disc > 0;
    if (!*met)
        return quad_abs(disc) > (quad)1e-9 * e.b * e.b;
    bool swapped = root[0] > root[1];
    quad least = root[swapped], most = root[!swapped];
    if (e.a > 0) {
        side[0] = least;
        side[1] = most;
    } else if (e.k > 0) {
        side[0] = most;
    } else {
        side[1] = least;
    }
    t[0] = lo > side[0] ? lo : side[0];
    t[1] = hi < side[1] ? hi : side[1];
    part[0] = lo <= side[0] ? PEN_PART_SIDE : da > 0 ? PEN_PART_BASE : PEN_PART_TOP;
    part[1] = hi >= side[1] ? PEN_PART_SIDE : da > 0 ? PEN_PART_TOP : PEN_PART_BASE;
    *met = t[0] < t[1];
    return quad_abs(disc) > (quad)1e-9 * e.b * e.b && quad_abs(t[1] - t[0]) > slack &&
           quad_abs(lo - side[0]) > slack && quad_abs(hi - side[1]) > slack;
}

/* The error of an end of the interval, measured towards the part, in units of u (|f| + size). */
static double departure(const struct pen_cone *c, const struct pen_ray *ray, double t, quad truth,
                        uint8_t part)
{
    vec3 n = cone_normal(c, part, pen_along(ray->o, ray->d, t));
    double f = pen_length(pen_sub(ray->o, c->hull.round.q));
    double error = (double)quad_abs(t - truth) * fabs(pen_dot(n, ray->d));
    return error / (PEN_U * (f + size_of(c)));
}

/* <= 16 ulp of t, or <= 4u (|f| + size) towards the part; wherever the ray starts and however it
 * meets the cone. */
START_TEST(test_cone__intersections_match_quad)
{
    struct random r = random_begin(53);
    int met_count = 0;
    for (int i = 0; i < 60000; i++) {
        static const double away[] = {0, 1, 10, 1e3, 1e6};
        struct pen_cone c = some_cone(&r, true);
        vec3 to = surface_point(&r, &c);
        vec3 o = pen_along(to, random_direction(&r), away[i % 5] * random_in(&r, .5, 2));
        vec3 d = away[i % 5] > 0 ? pen_sub(to, o) : random_direction(&r);
        if (i % 7 == 0) /* along the axis or a line of the side, nearly */
            d = pen_along(pen_along(axis_of(&c), across(&r, &c), i & 1 ? c.slope : 0),
                          random_direction(&r), random_power(&r, 1, 12));
        struct pen_ray ray;
        struct pen_interval in;
        quad truth[2];
        uint8_t part[2];
        bool met;
        if (!pen_ray_make(&ray, o, d) || !inside_quad(&c, &ray, truth, part, &met))
            continue;
        ck_assert_msg(pen_cone_interval(&c, &ray, &in) == met, "%d", i);
        if (!met)
            continue;
        met_count++;
        ck_assert_msg(in.lo_part == part[0] && in.hi_part == part[1], "%d", i);
        double t[2] = {in.lo, in.hi};
        for (int k = 0; k < 2; k++) {
            double ulps = quad_ulps(t[k], truth[k]);
            double off = departure(&c, &ray, t[k], truth[k], part[k]);
            ck_assert_msg(ulps <= 16 || off <= 4, "%d: %g ulp, %g u", i, ulps, off);
        }
    }
    ck_assert_int_gt(met_count, 20000);
}
END_TEST

/* Whether a ray from p, a point of the part, surely goes into the cone (1), surely does not (0), or
 * rounding decides (-1), because it runs along the surface or p is near the apex. At the apex the
 * cone of directions decides, elsewhere the normal. */
static int goes_into(const struct pen_cone *c, uint8_t part, vec3 p, vec3 d)
{
    vec3 axis = axis_of(c), apex = pen_along(c->hull.round.q, axis, c->hull.h);
    double away = c->top_radius == 0 ? pen_norm1(pen_sub(p, apex)) / size_of(c) : 1;
    double down = -pen_dot(d, axis), aside = pen_length(pen_cross(d, axis));
    double into = away <= 8 * PEN_U ? (-c->slope * down - aside) / c->slant
                                    : -pen_dot(cone_normal(c, part, p), d);
    bool sure = fabs(into) >= 1e-5 && (away <= 8 * PEN_U || away >= 1e-9);
    return sure ? into > 0 : -1;
}

/* Rays that start where an earlier ray met the cone: outward ones do not meet it again, inward ones
 * meet it once (at most once if the cone is open). */
START_TEST(test_cone__is_not_met_where_it_is_left)
{
    struct random r = random_begin(54);
    int seen[2] = {0, 0};
    for (int i = 0; i < 60000; i++) {
        struct pen_cone c = some_cone(&r, i % 3 > 0);
        double radius[2] = {c.base_radius, c.top_radius};
        world_clear(&world);
        world_cone(&world, c.hull.round.q, c.hull.round.a, radius, c.hull.h, c.hull.caps);
        vec3 from = pen_along(c.hull.round.q, random_direction(&r), 5), d = random_direction(&r);
        vec3 v = pen_sub(surface_point(&r, &c), from);
        struct pen_ray ray = world_ray(from, v);
        struct pen_hit hit[3];
        if (world_intersections(&world, &ray, &pen_origin_none, INFINITY, hit, 3) == 0)
            continue;
        vec3 p = pen_prim_point(&world.prims, hit[0], &ray);
        vec3 n = pen_prim_normal(&world.prims, hit[0], p);
        bool through = (pen_dot(n, d) < 0) != (pen_dot(n, v) > 0);
        struct pen_origin_surface origin = world_origin_surface(&world, hit[0], p, v, through);
        ray = world_ray(p, d);
        int into = goes_into(&c, hit[0].part, p, d);
        int count = world_intersections(&world, &ray, &origin, INFINITY, hit, 3);
        if (into < 0)
            continue;
        seen[into]++;
        ck_assert_msg(count == into || (count < into && !c.hull.caps), "%d: met %d times, not %d",
                      i, count, into);
    }
    ck_assert(seen[0] > 10000 && seen[1] > 10000);
}
END_TEST

/* A ray that goes inward from the side comes out where quad puts it, up to the bound of p. */
START_TEST(test_cone__comes_out_where_quad_says)
{
    struct random r = random_begin(55);
    int done = 0;
    for (int i = 0; i < 40000; i++) {
        struct pen_cone c = some_cone(&r, true);
        double radius[2] = {c.base_radius, c.top_radius};
        world_clear(&world);
        world_cone(&world, c.hull.round.q, c.hull.round.a, radius, c.hull.h, true);
        vec3 p = cone_project(&c, PEN_PART_SIDE, surface_point(&r, &c));
        vec3 n = cone_normal(&c, PEN_PART_SIDE, p), d = random_direction(&r);
        struct pen_hit on = {0, 0, PEN_PART_SIDE}, hit[2];
        struct pen_origin_surface origin = world_origin_surface(&world, on, p, n, true);
        struct pen_ray ray = world_ray(p, d);
        quad truth[2];
        uint8_t part[2];
        bool met;
        if (!(pen_dot(n, d) < -.1) || !inside_quad(&c, &ray, truth, part, &met) || !met ||
            part[0] != PEN_PART_SIDE)
            continue;
        if (!(truth[1] > (quad)1e-6 * size_of(&c)))
            continue;
        ck_assert_int_eq(world_intersections(&world, &ray, &origin, INFINITY, hit, 2), 1);
        ck_assert_msg(hit[0].part == part[1], "%d", i);
        double off = departure(&c, &ray, hit[0].t, truth[1], part[1]);
        ck_assert_msg(off <= 64, "%d: %g u", i, off);
        done++;
    }
    ck_assert_int_gt(done, 5000);
}
END_TEST

/* A point projected on the surface lies on it, within the bound that rays from there assume. */
START_TEST(test_cone__points_are_put_on_the_surface)
{
    struct random r = random_begin(56);
    for (int i = 0; i < 20000; i++) {
        struct pen_cone c = some_cone(&r, true);
        vec3 p = pen_along(surface_point(&r, &c), random_direction(&r), 1e-9);
        p = cone_project(&c, PEN_PART_SIDE, p);
        struct pen_ray ray = world_ray(p, pen_vec3(1, 0, 0));
        struct equation e = equation_quad(&c, &ray); /* c = n^2 - w^2 at p */
        double slant = sqrt(1 + c.slope * c.slope) * pen_length(c.hull.round.a);
        double off = (double)((quad_sqrt(e.c + e.w * e.w) - quad_abs(e.w)) / slant);
        double bound = 16 * PEN_U * (pen_norm1(p) + size_of(&c));
        ck_assert_msg(fabs(off) <= bound, "%d: off %g, bound %g", i, off, bound);
    }
}
END_TEST

/* Every intersection is in the box. */
START_TEST(test_cone__bounds_hold_what_is_met)
{
    struct random r = random_begin(57);
    for (int i = 0; i < 20000; i++) {
        struct pen_cone c = some_cone(&r, true);
        struct pen_box b = cone_bounds(&c);
        vec3 p = surface_point(&r, &c);
        ck_assert(p.x >= b.lo.x && p.y >= b.lo.y && p.z >= b.lo.z);
        ck_assert(p.x <= b.hi.x && p.y <= b.hi.y && p.z <= b.hi.z);
        vec3 size = pen_sub(b.hi, b.lo);
        ck_assert(size.x <= 2.001 * size_of(&c));
    }
    const double radius[2] = {1, 2};
    standing(true, true);
    struct pen_box b = pen_prim_bounds(&world.prims, 0);
    ck_assert(fabs(b.hi.z - 2) < 1e-12 && fabs(b.lo.z) < 1e-12 && fabs(b.hi.x - 2) < 1e-12);
    world_cone(&world, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), radius, 1, true);
    b = pen_prim_bounds(&world.prims, 1);
    ck_assert(fabs(b.hi.y - 2) < 1e-12 && fabs(b.lo.y + 2) < 1e-12 && fabs(b.hi.z - 1) < 1e-12);
}
END_TEST

PEN_SUITE("cone", test_cone__normals_go_by_part, test_cone__a_pointed_one_is_met,
          test_cone__a_truncated_one_is_met, test_cone__an_open_one_has_no_caps,
          test_cone__bad_input_is_refused, test_cone__equal_radii_are_a_cylinder,
          test_cone__intersections_pair_up, test_cone__intersections_match_quad,
          test_cone__is_not_met_where_it_is_left, test_cone__comes_out_where_quad_says,
          test_cone__points_are_put_on_the_surface, test_cone__bounds_hold_what_is_met)
