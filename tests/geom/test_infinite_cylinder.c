/* SPDX-License-Identifier: MIT */
/* Infinite cylinders. The first cases use two: around (1, 1, *) along z, and around (1, *, 1) along
 * y, both of radius 1. */
#include "geom/quad.h"
#include "geom/rows.h"
#include "support/suite.h"

static struct world world;

static void tube_z(double r, vec3 at)
{
    world_clear(&world);
    world_infinite_cylinder(&world, at, pen_vec3(0, 0, 1), r);
}

START_TEST(test_infinite_cylinder__h016_normal)
{
    struct pen_infinite_cylinder t;
    ck_assert(pen_infinite_cylinder_make(&t, pen_vec3(1, 0, 0), pen_vec3(1, 0, 0), 1));
    vec3 n = pen_cylinder_side_normal(&t.round, pen_vec3(2, 1, 0));
    ck_assert(n.x == 0 && n.y == 1 && n.z == 0);
    n = pen_cylinder_side_normal(&t.round,
                                 pen_vec3(1, 0, 0)); /* on the axis: some unit vector across */
    ck_assert(n.x == 0 && fabs(pen_dot(n, n) - 1) < 4 * PEN_U);
}
END_TEST

static const struct row along[] = {
    {{.5, .5, .5}, {0, 0, 1}, NONE}, {{.5, -.5, .5}, {0, 0, 1}, NONE},
    {{2, 1, .5}, {0, 0, 1}, NONE},   {{.5, .5, 1}, {0, 0, 1}, NONE},
    {{.5, -.5, 1}, {0, 0, 1}, NONE}, {{2, 1, 1}, {0, 0, 1}, NONE},
    {{1, 1, 1}, {0, 0, 1}, NONE}};

static const struct row outside[] = {
    {{0, 2, 2}, {1, 1, 0}, NONE}, {{0, 2, 1}, {1, 1, 0}, NONE}, {{0, 2, 1}, {1, 1, 1}, NONE}};

static const struct row tangent[] = {
    {{0, 2, 2}, {1, 0, 0}, NONE}, {{1, 2, 2}, {1, 0, 0}, NONE}, {{2, 2, 2}, {1, 0, 0}, NONE},
    {{0, 2, 1}, {1, 0, 0}, NONE}, {{1, 2, 1}, {1, 0, 0}, NONE}, {{2, 2, 1}, {1, 0, 0}, NONE},
    {{0, 2, 1}, {0, 2, 1}, NONE}, {{1, 2, 1}, {1, 0, 1}, NONE}, {{2, 2, 1}, {1, 0, 1}, NONE}};

#define V (1 - 0.70710678118654752440)
#define W (1 + 0.70710678118654752440)

static const struct row inward[] = {
    {{.4, .2, 2}, {2, 1, 0}, ONE(2, 1, 2)},     {{.4, .2, 1}, {2, 1, 0}, ONE(2, 1, 1)},
    {{1, 0, 2}, {0, 1, 0}, ONE(1, 2, 2)},       {{1, 0, 1}, {0, 1, 0}, ONE(1, 2, 1)},
    {{.4, 1.8, 1}, {2, -1, 1}, ONE(2, 1, 1.8)}, {{V, V, 2 + V}, {1, 1, 1}, ONE(W, W, 2 + W)},
    {{V, V, V}, {1, 1, 1}, ONE(W, W, W)}};

static const struct row inside[] = {
    {{1, .5, .5}, {2, 1, 1}, ONE(2, 1, 1)},  {{1, .5, 2}, {2, 1, 0}, ONE(2, 1, 2)},
    {{1, .5, 1}, {2, 1, 0}, ONE(2, 1, 1)},   {{1, .5, 2}, {0, 1, 0}, ONE(1, 2, 2)},
    {{1, 1, 2}, {0, 1, 0}, ONE(1, 2, 2)},    {{1, .5, 1}, {0, 1, 0}, ONE(1, 2, 1)},
    {{1, 1, 1}, {0, 1, 0}, ONE(1, 2, 1)},    {{1, 1.5, 1}, {2, -1, 1}, ONE(2, 1, 1.5)},
    {{1, 1, 1}, {0, 1, 1}, ONE(1, 2, 2)},    {{.5, .5, 2.5}, {1, 1, 1}, ONE(W, W, 2 + W)},
    {{.5, .5, .5}, {1, 1, 1}, ONE(W, W, W)}, {{1, 1, 3}, {1, 1, 1}, ONE(W, W, 2 + W)}};

static const struct row outward[] = {
    {{2, 1, 2}, {2, 1, 0}, NONE}, {{4, 2, 2}, {2, 1, 0}, NONE},     {{2, 1, 1}, {2, 1, 0}, NONE},
    {{4, 2, 1}, {2, 1, 0}, NONE}, {{1, 2, 2}, {0, 1, 0}, NONE},     {{1, 3, 2}, {0, 1, 0}, NONE},
    {{1, 2, 1}, {0, 1, 0}, NONE}, {{1, 3, 1}, {0, 1, 0}, NONE},     {{2, 1, 1}, {2, -1, 1}, NONE},
    {{2, 1, 2}, {2, 1, 1}, NONE}, {{W, W, 2 + W}, {1, 1, 1}, NONE}, {{W, W, W}, {1, 1, 1}, NONE}};

START_TEST(test_infinite_cylinder__h017_parallel_rays)
{
    tube_z(1, pen_vec3(1, 1, -7));
    rows_check(&world, along, ROWS(along), 0);
}
END_TEST

START_TEST(test_infinite_cylinder__h018_outside)
{
    const struct row along_y[] = {{{1, 1, 2}, {1, 1, 0}, NONE}};
    world_clear(&world);
    world_infinite_cylinder(&world, pen_vec3(1, 1, 1), pen_vec3(0, 1, 0), 1);
    rows_check(&world, along_y, 1, 0); /* tangent at r */
    tube_z(1, pen_vec3(1, 1, -7));
    rows_check(&world, outside, ROWS(outside), 0);
}
END_TEST

START_TEST(test_infinite_cylinder__h019_tangent)
{
    const struct row unit[] = {{{1, 1, 0}, {0, 1, 0}, NONE}};
    tube_z(1, pen_vec3(1, 1, -7));
    rows_check(&world, tangent, ROWS(tangent), 0);
    tube_z(1, pen_vec3(0, 0, 0));
    rows_check(&world, unit, 1, 0);
}
END_TEST

START_TEST(test_infinite_cylinder__h020_start_on_it_inward)
{
    tube_z(1, pen_vec3(1, 1, -7));
    rows_check_leaving(&world, inward, ROWS(inward), 4);
    for (int i = 0; i < ROWS(inward); i++) /* as a ray from free space: it is never lost */
        ck_assert_int_ge(world_count(&world, inward[i].o, inward[i].d), 1);
}
END_TEST

START_TEST(test_infinite_cylinder__h021_from_inside)
{
    tube_z(1, pen_vec3(1, 1, -7));
    rows_check(&world, inside, ROWS(inside), 4);
    tube_z(1, pen_vec3(0, 0, 0));
    struct pen_hit hit;
    struct pen_ray ray = world_ray(pen_vec3(0, 0, 0), pen_vec3(1, 0, 0));
    ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, 1.5, &hit, 1), 1);
    ck_assert(hit.t == 1);
}
END_TEST

START_TEST(test_infinite_cylinder__h022_start_on_it_outward)
{
    tube_z(1, pen_vec3(1, 1, -7));
    rows_check_leaving(&world, outward, ROWS(outward), 0);
}
END_TEST

START_TEST(test_infinite_cylinder__h023_tmax)
{
    const struct {
        double tmax;
        int count;
    } row[] = {{3, 1 + 1}, {.5, 0}, {1, 1}, {nextafter(1, 0), 0}};
    tube_z(1, pen_vec3(0, 0, 0));
    struct pen_ray ray = world_ray(pen_vec3(2, 0, -1), pen_vec3(-1, 0, 1));
    for (int i = 0; i < 4; i++)
        ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, row[i].tmax, NULL, 0),
                         row[i].count);
    ray = world_ray(pen_vec3(2, 2, 0), pen_vec3(1, 0, 0));
    ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, 10, NULL, 0), 0);
    /* The same along a unit vector: t is the square root of 2, as it is computed. */
    struct pen_hit hit;
    ray = world_ray(pen_vec3(2, 0, -1), pen_normalize(pen_vec3(-1, 0, 1)));
    ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, 3, &hit, 1), 1);
    ck_assert(quad_ulps(hit.t, quad_sqrt(2)) <= 2);
    ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, .5, NULL, 0), 0);
    ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, hit.t, NULL, 0), 1);
    ck_assert_int_eq(
        world_intersections(&world, &ray, &pen_origin_none, nextafter(hit.t, 0), NULL, 0), 0);
}
END_TEST

START_TEST(test_infinite_cylinder__h024_has_no_head)
{
    static const double head[] = {1, 2, 1e9, -1e9};
    for (int i = 0; i < 4; i++) {
        tube_z(1, pen_vec3(1, 1, head[i]));
        rows_check(&world, along, ROWS(along), 0);
        rows_check(&world, outside, ROWS(outside), 0);
        rows_check(&world, tangent, ROWS(tangent), 0);
        rows_check_leaving(&world, inward, ROWS(inward), 4);
        rows_check(&world, inside, ROWS(inside), 4);
        rows_check_leaving(&world, outward, ROWS(outward), 0);
    }
}
END_TEST

/* An axis of any direction whose given point is far away loses nothing but that point's ulp. */
START_TEST(test_infinite_cylinder__h024_far_heads_of_slanted_tubes)
{
    struct random r = random_begin(24);
    for (int i = 0; i < 1000; i++) {
        vec3 a = random_direction(&r), q = random_vec(&r, 1);
        struct pen_infinite_cylinder t;
        ck_assert(pen_infinite_cylinder_make(&t, pen_along(q, a, 1e9), a, 1));
        ck_assert(pen_norm1(t.near) < 4);
        vec3 off = pen_cross(pen_sub(t.near, q), a);
        ck_assert(pen_length(off) <= 4 * PEN_U * 1e9);
    }
}
END_TEST

START_TEST(test_infinite_cylinder__bad_input_is_refused)
{
    struct pen_infinite_cylinder t;
    vec3 o = pen_vec3(0, 0, 0), z = pen_vec3(0, 0, 1);
    ck_assert(!pen_infinite_cylinder_make(&t, o, o, 1));
    ck_assert(!pen_infinite_cylinder_make(&t, o, z, 0));
    ck_assert(!pen_infinite_cylinder_make(&t, o, z, -1));
    ck_assert(!pen_infinite_cylinder_make(&t, pen_vec3(0, (double)NAN, 0), z, 1));
    ck_assert(!pen_infinite_cylinder_make(&t, o, pen_vec3((double)INFINITY, 0, 0), 1));
}
END_TEST

/* A ray that passes the axis at b r, from D r away, at `angle` to the axis. */
static struct pen_ray aimed(struct random *r, const struct pen_infinite_cylinder *t,
                            const double in[3])
{
    vec3 a = pen_normalize(t->round.a), e = pen_normalize(pen_cross(a, random_direction(r)));
    vec3 f = pen_cross(a, e);
    double far = in[0], sine = in[1] < far ? in[1] / far : 1;
    vec3 o = pen_along(pen_along(t->round.q, e, far * t->round.r), a, random_in(r, -1, 1));
    vec3 across = pen_along(pen_scale(e, -sqrt((1 - sine) * (1 + sine))), f, sine);
    return world_ray(o, pen_along(pen_scale(across, in[2]), a, sqrt((1 - in[2]) * (1 + in[2]))));
}

/* <= 16 ulp of t from D >= 2 r, at any angle and radius; else <= 8u (|f| + r) across the axis. */
START_TEST(test_infinite_cylinder__intersections_match_quad)
{
    static const double distance[] = {0.3, 1 + 1e-9, 1.5, 2, 10, 1e4};
    static const double passing[] = {0, .5, .9, .99, .9999, .999999},
                        angle[] = {.8, 1e-2, 1e-4, 1e-6, 1e-8};
    struct random r = random_begin(31);
    for (int i = 0; i < 30000; i++) {
        double in[3] = {distance[i % 6], passing[i / 6 % 6], angle[i / 36 % 5]};
        struct pen_infinite_cylinder infinite_cylinder;
        double size = i % 3 == 0 ? 1 : i % 3 == 1 ? 1e-3 : 1e-6;
        ck_assert(pen_infinite_cylinder_make(&infinite_cylinder, random_vec(&r, 1),
                                             random_direction(&r), size));
        struct pen_ray ray = aimed(&r, &infinite_cylinder, in);
        quad truth[2];
        double t[2];
        bool parallel;
        quad disc = quad_tube(infinite_cylinder.round.q, infinite_cylinder.round.a, size, ray.o,
                              ray.d, truth);
        if (disc <= 0)
            continue;
        ck_assert(pen_cylinder_side_roots(&infinite_cylinder.round, &ray, t, &parallel));
        for (int k = 0; k < 2; k++) {
            double ulps = quad_ulps(t[k], truth[k]);
            double error = (double)quad_abs(t[k] - truth[k]) * in[2];
            ck_assert_msg(in[0] >= 2 ? ulps <= 16 : error <= 8 * PEN_U * (in[0] + 1) * size,
                          "%d: D %g b %g angle %g r %g: %g ulp, error %g", i, in[0], in[1], in[2],
                          size, ulps, error);
        }
    }
}
END_TEST

PEN_SUITE("infinite_cylinder", test_infinite_cylinder__h016_normal,
          test_infinite_cylinder__h017_parallel_rays, test_infinite_cylinder__h018_outside,
          test_infinite_cylinder__h019_tangent, test_infinite_cylinder__h020_start_on_it_inward,
          test_infinite_cylinder__h021_from_inside,
          test_infinite_cylinder__h022_start_on_it_outward, test_infinite_cylinder__h023_tmax,
          test_infinite_cylinder__h024_has_no_head,
          test_infinite_cylinder__h024_far_heads_of_slanted_tubes,
          test_infinite_cylinder__bad_input_is_refused,
          test_infinite_cylinder__intersections_match_quad)
