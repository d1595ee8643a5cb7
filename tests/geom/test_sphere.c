/* SPDX-License-Identifier: MIT */
/* Spheres. */
#include "geom/quad.h"
#include "geom/rows.h"
#include "support/suite.h"

static struct world world;

static void unit_sphere(vec3 c)
{
    world_clear(&world);
    world_sphere(&world, c, 1);
}

START_TEST(test_sphere__h008_normal)
{
    struct pen_sphere s;
    ck_assert(pen_sphere_make(&s, pen_vec3(0, 0, 0), 1));
    vec3 n = pen_sphere_normal(&s, pen_vec3(1, 0, 0));
    ck_assert(n.x == 1 && n.y == 0 && n.z == 0);
}
END_TEST

START_TEST(test_sphere__h009_from_inside)
{
    double w = sqrt(.75);
    const struct row rows[] = {
        {{0, 0, 1.5}, {0, 1, 0}, 1, {{0, w, 1.5}, {0, 0, 0}}},
        {{0, .5, 1}, {0, 0, -1}, 1, {{0, .5, 1 - w}, {0, 0, 0}}},
        {{0, .5, 1}, {0, 1, 0}, 1, {{0, 1, 1}, {0, 0, 0}}},
    };
    unit_sphere(pen_vec3(0, 0, 1));
    rows_check(&world, rows, 3, 2);
}
END_TEST

START_TEST(test_sphere__h010_missed_or_behind)
{
    const struct row rows[] = {{{0, 0, 3}, {1, 1, 1}, NONE},
                               {{0, -2, 1.5}, {0, -1, 0}, NONE},
                               {{0, 2, 1}, {0, 0, 1}, NONE},
                               {{0, 2, 1}, {0, 1, 0}, NONE}};
    unit_sphere(pen_vec3(0, 0, 1));
    rows_check(&world, rows, 4, 0);
}
END_TEST

START_TEST(test_sphere__h011_two_intersections_near_first)
{
    double w = sqrt(.75);
    const struct row rows[] = {{{0, 2, 1.5}, {0, -1, 0}, 2, {{0, w, 1.5}, {0, -w, 1.5}}},
                               {{0, 2, 1}, {0, -1, 0}, 2, {{0, 1, 1}, {0, -1, 1}}}};
    unit_sphere(pen_vec3(0, 0, 1));
    rows_check(&world, rows, 2, 2);
}
END_TEST

START_TEST(test_sphere__h012_a_tangent_is_a_miss)
{
    const struct row rows[] = {{{-1, 1, 0}, {1, 0, 1}, NONE}, {{0, 1, 1}, {1, 0, 1}, NONE},
                               {{1, 1, 2}, {1, 0, 1}, NONE},  {{-1, 1, 0}, {1, 0, 0}, NONE},
                               {{0, -1, 0}, {1, 0, 0}, NONE}, {{0, 0, -1}, {1, 1, 0}, NONE}};
    unit_sphere(pen_vec3(0, 0, 0));
    rows_check(&world, rows, 6, 0);
}
END_TEST

START_TEST(test_sphere__h013_start_on_it)
{
    const struct row rows[] = {{{0, 1, 1}, {-1, -1, -1}, 1, {{-2. / 3, 1. / 3, 1. / 3}, {0, 0, 0}}},
                               {{0, 1, 1}, {1, 1, 1}, NONE},
                               {{0, 1, 1}, {0, -1, 0}, 1, {{0, -1, 1}, {0, 0, 0}}},
                               {{0, 1, 1}, {0, 1, 0}, NONE}};
    unit_sphere(pen_vec3(0, 0, 1));
    rows_check(&world, rows, 4, 4); /* without identity */
    rows_check_leaving(&world, rows, 4, 4);
}
END_TEST

START_TEST(test_sphere__h014_start_at_the_centre)
{
    struct pen_hit hit;
    struct pen_ray ray = world_ray(pen_vec3(0, 0, 1), pen_vec3(0, 1, 0));
    world_clear(&world);
    world_sphere(&world, pen_vec3(0, 0, 1), 1);
    ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, INFINITY, &hit, 1), 1);
    ck_assert(hit.t == 1);
    ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, .5, &hit, 1), 0);
}
END_TEST

START_TEST(test_sphere__h015_tmax)
{
    const struct {
        vec3 o;
        double tmax;
        int count;
    } row[] = {{{-2, 0, 0}, 4, 2}, {{-2, 0, 0}, 2.5, 1}, {{-2, 0, 0}, .5, 0},
               {{-2, 0, 0}, 1, 1}, {{.5, 0, 0}, 2, 1},   {{0, -2, 0}, 9, 0}};
    world_clear(&world);
    world_sphere(&world, pen_vec3(0, 0, 0), 1);
    for (int i = 0; i < 6; i++) {
        struct pen_ray ray = world_ray(row[i].o, pen_vec3(1, 0, 0));
        ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, row[i].tmax, NULL, 0),
                         row[i].count);
    }
}
END_TEST

START_TEST(test_sphere__bad_radii_are_refused)
{
    struct pen_sphere s;
    vec3 o = pen_vec3(0, 0, 0);
    ck_assert(!pen_sphere_make(&s, o, 0));
    ck_assert(!pen_sphere_make(&s, o, -1));
    ck_assert(!pen_sphere_make(&s, o, (double)NAN));
    ck_assert(!pen_sphere_make(&s, o, (double)INFINITY));
    ck_assert(!pen_sphere_make(&s, pen_vec3(0, (double)INFINITY, 0), 1));
}
END_TEST

/* A ray from distance D r that passes the centre at b r. */
static struct pen_ray aimed(struct random *r, const struct pen_sphere *s, double far, double b)
{
    vec3 u = random_direction(r), side = pen_normalize(pen_cross(u, random_direction(r)));
    vec3 o = pen_along(s->c, u, far * s->r);
    double sine = b < far ? b / far : 1, cosine = sqrt((1 - sine) * (1 + sine));
    vec3 d = pen_along(pen_scale(u, -cosine), side, sine);
    double length = random_below(r, 2) ? 1 : random_in(r, 0.01, 100);
    return world_ray(o, pen_scale(d, length));
}

/* <= 5 ulp of t from D >= 2 r, however far and however near a tangent; else <= 8u (|f| + r). */
START_TEST(test_sphere__intersections_match_quad)
{
    static const double distance[] = {0.5, 1 + 1e-9, 1.5, 2, 10, 1e4, 1e8};
    static const double passing[] = {0, .5, .9, .97, .99, .9999, .999999, 1 - 1e-12};
    struct random r = random_begin(1);
    double worst = 0;
    for (int i = 0; i < 42000; i++) {
        double far = distance[i % 7], b = passing[i / 7 % 8], size = i % 5 ? 1 : 1e-6;
        struct pen_sphere s;
        ck_assert(pen_sphere_make(&s, random_vec(&r, 1), size * random_in(&r, .1, 1)));
        struct pen_ray ray = aimed(&r, &s, far, b);
        quad truth[2];
        double t[2], f = pen_length(pen_sub(ray.o, s.c));
        if (quad_sphere(s.c, s.r, ray.o, ray.d, truth) <= 0)
            continue;
        ck_assert(pen_sphere_roots(&s, &ray, t));
        for (int k = 0; k < 2; k++) {
            double ulps = quad_ulps(t[k], truth[k]);
            double error = (double)quad_abs(t[k] - truth[k]) * pen_length(ray.d);
            if (far >= 2)
                worst = ulps > worst ? ulps : worst;
            ck_assert_msg(far >= 2 ? ulps <= 5 : error <= 8 * PEN_U * (f + s.r),
                          "%d: D %g b %g root %d: %g ulp, error %g", i, far, b, k, ulps, error);
        }
    }
    ck_assert_msg(worst > 0.4, "not a test: %g", worst);
}
END_TEST

/* The bounds hold the sphere, and little more. */
START_TEST(test_sphere__bounds)
{
    struct random r = random_begin(5);
    for (int i = 0; i < 1000; i++) {
        vec3 c = random_vec(&r, i % 2 ? 1 : 1e6);
        struct pen_sphere s;
        ck_assert(pen_sphere_make(&s, c, pow(10, random_in(&r, -6, 3))));
        struct pen_box b = pen_kinds[PEN_PRIM_SPHERE].fn->bounds(&s);
        double spare = 128 * PEN_U * (pen_norm1(c) + s.r);
        for (int axis = 0; axis < 3; axis++) {
            quad m = pen_component(c, axis), lo = pen_component(b.lo, axis);
            quad hi = pen_component(b.hi, axis);
            ck_assert(lo <= m - s.r && hi >= m + s.r);
            ck_assert(lo >= m - s.r - spare && hi <= m + s.r + spare);
        }
    }
}
END_TEST

/* Hit or miss is wrong only where a movement of the inputs by 8u changes it. */
START_TEST(test_sphere__grazing_decisions_match_quad)
{
    struct random r = random_begin(5);
    int hits = 0, misses = 0;
    for (int i = 0; i < 10000; i++) {
        double far = pow(10, random_in(&r, 0.1, 8));
        double k = pow(10, -random_in(&r, 3, 12)), b = i & 1 ? 1 - k : 1 + k;
        struct pen_sphere s;
        ck_assert(pen_sphere_make(&s, random_vec(&r, 1), 1));
        struct pen_ray ray = aimed(&r, &s, far, b);
        quad truth[2], disc = quad_sphere(s.c, s.r, ray.o, ray.d, truth);
        double t[2];
        bool hit = pen_sphere_roots(&s, &ray, t);
        quad margin = disc / (quad_dot(quad3(ray.d), quad3(ray.d)) * (quad)2); /* about r - b */
        if (quad_abs(margin) > 8 * (quad)PEN_U)
            ck_assert_msg(hit == (disc > 0), "%d: D %g k %g", i, far, k);
        hits += hit;
        misses += !hit;
    }
    ck_assert(hits > 4000 && misses > 4000);
}
END_TEST

START_TEST(test_sphere__h083_horizon_of_a_planet)
{
    struct pen_sphere s;
    double t[2], high = 2, r = 6.4e6;
    ck_assert(pen_sphere_make(&s, pen_vec3(0, -r, 0), r));
    /* The tangent from height h touches at distance sqrt(2 r h + h^2). */
    double touch = sqrt(2 * r * high + high * high);
    vec3 d = pen_vec3(touch / (r + high), -1, 0); /* across : down = touch / r at the eye ... */
    d = pen_vec3(r / (r + high), -touch / (r + high), 0);
    struct pen_ray below = world_ray(pen_vec3(0, high, 0), pen_vec3(d.x, d.y * (1 + 1e-9), 0));
    struct pen_ray above = world_ray(pen_vec3(0, high, 0), pen_vec3(d.x, d.y * (1 - 1e-9), 0));
    ck_assert(pen_sphere_roots(&s, &below, t));
    ck_assert(fabs(t[0] / touch - 1) < 1e-3);
    ck_assert(!pen_sphere_roots(&s, &above, t));
}
END_TEST

/* Everything scales exactly by powers of two. */
START_TEST(test_sphere__h074_power_of_two_scale)
{
    struct random r = random_begin(6);
    for (int i = 0; i < 10000; i++) {
        static const int power[] = {-200, -40, -1, 20, 200};
        struct pen_sphere s, big;
        double k = ldexp(1, power[i % 5]), t[2], u[2];
        ck_assert(pen_sphere_make(&s, random_vec(&r, 1), random_in(&r, .1, 1)));
        ck_assert(pen_sphere_make(&big, pen_scale(s.c, k), s.r * k));
        struct pen_ray ray = aimed(&r, &s, 3, random_in(&r, 0, 1.1));
        struct pen_ray far = world_ray(pen_scale(ray.o, k), pen_scale(ray.d, k));
        bool hit = pen_sphere_roots(&s, &ray, t);
        ck_assert(pen_sphere_roots(&big, &far, u) == hit);
        if (hit)
            ck_assert(t[0] == u[0] && t[1] == u[1]);
    }
}
END_TEST

START_TEST(test_sphere__h085_subnormal_directions)
{
    struct pen_sphere s;
    double t[2];
    ck_assert(pen_sphere_make(&s, pen_vec3(0, 0, 0), 1));
    struct pen_ray a = world_ray(pen_vec3(-2, 0, 0), pen_vec3(1, 5e-324, 0));
    struct pen_ray b = world_ray(pen_vec3(-2, 0, 0), pen_vec3(1, -1e-310, 0));
    ck_assert(pen_sphere_roots(&s, &a, t) && t[0] == 1 && t[1] == 3);
    ck_assert(pen_sphere_roots(&s, &b, t) && t[0] == 1 && t[1] == 3);
}
END_TEST

START_TEST(test_ray__h088_poisoned_rays_are_refused)
{
    struct pen_ray ray;
    vec3 o = pen_vec3(0, 0, 0), d = pen_vec3(1, 0, 0);
    double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    for (int i = 0; i < 3; i++) {
        ck_assert(!pen_ray_make(&ray, pen_vec3(0, bad[i], 0), d));
        ck_assert(!pen_ray_make(&ray, o, pen_vec3(1, bad[i], 0)));
        ck_assert(!pen_ray_make(&ray, o, pen_vec3(1, 0, bad[i])));
    }
    ck_assert(!pen_ray_make(&ray, o, o));
    ck_assert(!pen_ray_make(&ray, o, pen_vec3(0, -0.0, 1e-200)));
    ck_assert(pen_ray_make(&ray, o, pen_vec3(0, -0.0, 1e-100)));
}
END_TEST

PEN_SUITE("sphere", test_sphere__bounds, test_sphere__h008_normal, test_sphere__h009_from_inside,
          test_sphere__h010_missed_or_behind, test_sphere__h011_two_intersections_near_first,
          test_sphere__h012_a_tangent_is_a_miss, test_sphere__h013_start_on_it,
          test_sphere__h014_start_at_the_centre, test_sphere__h015_tmax,
          test_sphere__bad_radii_are_refused, test_sphere__intersections_match_quad,
          test_sphere__grazing_decisions_match_quad, test_sphere__h083_horizon_of_a_planet,
          test_sphere__h074_power_of_two_scale, test_sphere__h085_subnormal_directions,
          test_ray__h088_poisoned_rays_are_refused)
