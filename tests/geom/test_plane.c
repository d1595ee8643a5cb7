/* SPDX-License-Identifier: MIT */
/* Planes. */
#include "geom/quad.h"
#include "support/suite.h"
#include "support/world.h"

typedef struct pen_vec3 vec3;

static struct world world;

/* How many intersections the ray has with the plane z = height, up to tmax; the first goes to *t.
 */
static int cross_z(double height, vec3 o, vec3 d, double tmax, double *t)
{
    struct pen_hit hit = {0, 0, 0};
    struct pen_ray ray = world_ray(o, d);
    world_clear(&world);
    world_plane(&world, pen_vec3(0, 0, height), pen_vec3(0, 0, 1));
    int count = world_intersections(&world, &ray, &pen_origin_none, tmax, &hit, 1);
    *t = hit.t;
    return count;
}

/* The plane through three points, by the triangle's normal. */
static bool plane_through(struct pen_plane *p, vec3 a, vec3 b, vec3 c)
{
    struct pen_triangle tri;
    return pen_triangle_make(&tri, a, b, c) && pen_plane_make(p, a, tri.facet.n);
}

START_TEST(test_plane__h001_normal_of_three_points)
{
    struct pen_plane p;
    vec3 a = pen_vec3(0, 0, 1), b = pen_vec3(1, 0, 0), c = pen_vec3(0, 1, 0);
    ck_assert(plane_through(&p, a, b, c));
    ck_assert(quad_ulps(p.n.x, 1 / quad_sqrt(3)) <= 2);
    ck_assert(p.n.x == p.n.y && p.n.y == p.n.z);
    ck_assert(fabs(pen_dot(p.n, pen_sub(b, a))) <= 2 * PEN_U);
    ck_assert(fabs(pen_dot(p.n, pen_sub(c, a))) <= 2 * PEN_U);
}
END_TEST

START_TEST(test_plane__h002_repeated_points_are_refused)
{
    struct pen_plane p;
    vec3 a = pen_vec3(1, 2, 3), b = pen_vec3(-1, 0, 2), c = pen_vec3(1, 1, 1);
    ck_assert(!plane_through(&p, a, a, b));
    ck_assert(!plane_through(&p, a, b, a));
    ck_assert(!plane_through(&p, b, a, a));
    ck_assert(!plane_through(&p, c, c, c));
}
END_TEST

START_TEST(test_plane__h003_points_on_a_line_are_refused)
{
    struct pen_plane p;
    vec3 o = pen_vec3(0, 0, 0);
    ck_assert(!plane_through(&p, o, pen_vec3(1, 1, 1), pen_vec3(2, 2, 2)));
    ck_assert(!plane_through(&p, o, pen_vec3(.1, .2, .3), pen_vec3(.2, .4, .6)));
    ck_assert(plane_through(&p, o, pen_vec3(1, 1, 1), pen_vec3(2, 2, nextafter(2, 3))));
}
END_TEST

START_TEST(test_plane__zero_and_infinite_normals_are_refused)
{
    struct pen_plane p;
    vec3 o = pen_vec3(0, 0, 0);
    ck_assert(!pen_plane_make(&p, o, o));
    ck_assert(!pen_plane_make(&p, o, pen_vec3(0, (double)INFINITY, 0)));
    ck_assert(!pen_plane_make(&p, pen_vec3((double)NAN, 0, 0), pen_vec3(0, 1, 0)));
    ck_assert(pen_plane_make(&p, o, pen_vec3(0, 5e-324, 0)) && p.n.y == 1);
    ck_assert(pen_plane_make(&p, o, pen_vec3(0, -1e308, 1e308)));
    ck_assert(quad_ulps(p.n.z, quad_sqrt(0.5)) <= 2);
}
END_TEST

START_TEST(test_plane__h004_met_and_turned_away_from)
{
    double t;
    vec3 o = pen_vec3(0, 0, 0);
    ck_assert_int_eq(cross_z(1, o, pen_vec3(0, 0, 1), INFINITY, &t), 1);
    ck_assert(t == 1);
    ck_assert_int_eq(cross_z(1, o, pen_vec3(0, 0, -1), INFINITY, &t), 0);
}
END_TEST

START_TEST(test_plane__h005_parallel_rays)
{
    double t;
    ck_assert_int_eq(cross_z(1, pen_vec3(0, 0, 1), pen_vec3(1, 1, 0), INFINITY, &t), 0);
    ck_assert_int_eq(cross_z(1, pen_vec3(0, 0, 2), pen_vec3(1, 0, 0), INFINITY, &t), 0);
    ck_assert_int_eq(cross_z(1, pen_vec3(0, 0, 0), pen_vec3(1, 0, 0), INFINITY, &t), 0);
}
END_TEST

START_TEST(test_plane__h006_rays_that_start_on_it)
{
    double t;
    vec3 up = pen_vec3(0, 0, 1);
    ck_assert_int_eq(cross_z(1, pen_vec3(0, 0, 1), up, INFINITY, &t), 0);
    ck_assert_int_eq(cross_z(1, pen_vec3(0, 0, 2), up, INFINITY, &t), 0);
    ck_assert_int_eq(cross_z(1, pen_vec3(.5, .5, 1), pen_vec3(1, 1, 1), INFINITY, &t), 0);
    ck_assert_int_eq(cross_z(1, pen_vec3(0, 0, 1), pen_vec3(1, 2, -3), INFINITY, &t), 0);
}
END_TEST

START_TEST(test_plane__h007_tmax_is_inclusive)
{
    double t;
    vec3 o = pen_vec3(0, 0, 0), up = pen_vec3(0, 0, 1);
    ck_assert_int_eq(cross_z(1, o, up, 2, &t), 1);
    ck_assert_int_eq(cross_z(10, o, up, 5, &t), 0);
    ck_assert_int_eq(cross_z(5, o, up, 5, &t), 1);
    ck_assert_int_eq(cross_z(5, o, up, nextafter(5, 0), &t), 0);
}
END_TEST

START_TEST(test_plane__h087_grazing_rays_have_finite_intersections_or_none)
{
    double t;
    vec3 o = pen_vec3(0, 0, 0);
    ck_assert_int_eq(cross_z(1, o, pen_vec3(1, 0, 1e-15), INFINITY, &t), 1);
    ck_assert(quad_ulps(t, 1 / (quad)1e-15) <= 1);
    ck_assert_int_eq(cross_z(1, o, pen_vec3(1, 0, 0x1p-129), INFINITY, &t), 1);
    ck_assert(t > 0 && t <= DBL_MAX);
    /* Components of a direction below PEN_LEAST_DIRECTION count as 0, so this ray runs along the
     * plane. */
    ck_assert_int_eq(cross_z(1, o, pen_vec3(1, 0, 1e-300), INFINITY, &t), 0);
}
END_TEST

/* The intersection loses no digits to the slope, nor to a point of the plane that is far away. */
START_TEST(test_plane__intersections_match_quad)
{
    struct random r = random_begin(21);
    for (int i = 0; i < 10000; i++) {
        vec3 n = random_direction(&r), o = random_vec(&r, 1), d = random_direction(&r);
        vec3 across = pen_cross(n, random_direction(&r));
        if (i & 1) /* nearly parallel */
            d = pen_along(pen_normalize(across), n, pow(10, random_in(&r, -9, -1)));
        struct pen_plane p;
        struct pen_ray ray = world_ray(o, d);
        double t;
        ck_assert(pen_plane_make(&p, pen_along(random_vec(&r, 1), across, i & 2 ? 1e3 : 1), n));
        ck_assert(pen_plane_root(&p, &ray, &t));
        struct quad3 g = quad3(p.g), f = quad_sub(quad3(p.q), quad3(o));
        quad truth = quad_dot(g, f) / quad_dot(g, quad3(d));
        quad size = quad_abs(g.x * f.x) + quad_abs(g.y * f.y) + quad_abs(g.z * f.z);
        quad bound = 4 * (quad)PEN_U * size / quad_abs(quad_dot(g, quad3(d)));
        ck_assert_msg(quad_abs(t - truth) <= bound + 4 * (quad)PEN_U * quad_abs(truth),
                      "%d: t %a, error %g", i, t, (double)(t - truth));
    }
}
END_TEST

PEN_SUITE("plane", test_plane__h001_normal_of_three_points,
          test_plane__h002_repeated_points_are_refused,
          test_plane__h003_points_on_a_line_are_refused,
          test_plane__zero_and_infinite_normals_are_refused,
          test_plane__h004_met_and_turned_away_from, test_plane__h005_parallel_rays,
          test_plane__h006_rays_that_start_on_it, test_plane__h007_tmax_is_inclusive,
          test_plane__h087_grazing_rays_have_finite_intersections_or_none,
          test_plane__intersections_match_quad)
