/* SPDX-License-Identifier: MIT */
/* Triangles. */
#include "geom/quad.h"
#include "geom/rows.h"
#include "support/suite.h"

static struct world world;

START_TEST(test_triangle__h032_inside_rim_and_outside)
{
    static const struct {
        double x, y;
        int count;
    } row[] = {{0, .5, 1}, {1, .5, 0}, {0, 1.5, 0}, {.5, .5, 0}, {1, 0, 0},
               {2, -1, 0}, {-1, 0, 1}, {0, 0, 1},   {-.5, .5, 1}};
    world_clear(&world);
    world_triangle(&world, pen_vec3(0, 1, 0), pen_vec3(1, 0, 0), pen_vec3(-1, 0, 0));
    for (int i = 0; i < 9; i++)
        ck_assert_msg(world_count(&world, pen_vec3(row[i].x, row[i].y, -1), pen_vec3(0, 0, 1)) ==
                          row[i].count,
                      "row %d", i);
    struct pen_ray ray = world_ray(pen_vec3(0, .5, -1), pen_vec3(0, 0, 1));
    static const double tmax[] = {3, 1, .5};
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, tmax[i], NULL, 0),
                         i < 2);
}
END_TEST

START_TEST(test_triangle__normal_is_on_the_counter_clockwise_side)
{
    struct pen_triangle tri;
    ck_assert(pen_triangle_make(&tri, pen_vec3(0, 0, 5), pen_vec3(2, 0, 5), pen_vec3(0, 3, 5)));
    ck_assert(tri.facet.n.x == 0 && tri.facet.n.y == 0 && tri.facet.n.z == 1);
}
END_TEST

/* H045: a triangle without area is refused; one with an area, however small, is not. */
START_TEST(test_triangle__h045_degenerate)
{
    struct pen_triangle tri;
    vec3 o = pen_vec3(0, 0, 0), x = pen_vec3(1, 0, 0);
    ck_assert(!pen_triangle_make(&tri, o, x, pen_vec3(2, 0, 0)));
    ck_assert(!pen_triangle_make(&tri, o, x, o));
    ck_assert(!pen_triangle_make(&tri, x, x, x));
    ck_assert(!pen_triangle_make(&tri, o, pen_vec3(1e-200, 0, 0), pen_vec3(0, 1e-200, 0)));
    ck_assert(!pen_triangle_make(&tri, o, x, pen_vec3(0, (double)NAN, 0)));
    ck_assert(pen_triangle_make(&tri, o, x, pen_vec3(2, 1e-20, 0)));
    ck_assert(tri.facet.n.z == 1);
    struct random r = random_begin(45);
    for (int i = 0; i < 10000; i++) { /* points on a line through two random ones */
        vec3 a = random_vec(&r, 1), b = random_vec(&r, 1), e = pen_sub(b, a);
        b = pen_add(a, e);
        vec3 c = pen_add(b, e);
        struct quad3 p = quad_sub(quad3(b), quad3(a)), q = quad_sub(quad3(c), quad3(a));
        struct quad3 n = quad_cross(p, q);
        bool flat = n.x == 0 && n.y == 0 && n.z == 0;
        ck_assert(pen_triangle_make(&tri, a, b, c) != flat);
    }
}
END_TEST

/* A triangle without area: refused, and not met if it were there. */
START_TEST(test_triangle__h046_pbrt_bad_case)
{
    const vec3 v[3] = {{-1113.45459, -79.049614, -56.2431908},
                       {-1113.45459, -87.0922699, -56.2431908},
                       {-1113.45459, -79.2090149, -56.2431908}};
    struct pen_ray ray = world_ray(pen_vec3(-1081.47925, 99.9999542, 87.7701111),
                                   pen_vec3(-32.1072998, -183.355865, -144.607635));
    struct pen_triangle tri;
    double t;
    ck_assert(!pen_triangle_make(&tri, v[0], v[1], v[2]));
    for (int i = 0; i < 6; i++) {
        tri =
            (struct pen_triangle){.v = {v[i % 3], v[(i + 1 + i / 3) % 3], v[(i + 2 - i / 3) % 3]}};
        ck_assert(!pen_triangle_root(&tri, &ray, &t));
    }
}
END_TEST

/* H048: a ray in the triangle's plane. */
START_TEST(test_triangle__h048_edge_on)
{
    world_clear(&world);
    world_triangle(&world, pen_vec3(-1, 0, 0), pen_vec3(1, 0, 0), pen_vec3(0, 0, 1));
    ck_assert_int_eq(world_count(&world, pen_vec3(-3, 0, .25), pen_vec3(1, 0, 0)), 0);
    ck_assert_int_eq(world_count(&world, pen_vec3(0, 0, -3), pen_vec3(0, 0, 1)), 0);
    ck_assert_int_eq(world_count(&world, pen_vec3(-3, 0, -2.75), pen_vec3(1, 0, 1)), 0);
    ck_assert_int_eq(world_count(&world, pen_vec3(-3, 0, 0), pen_vec3(1, 0, 0)), 0); /* an edge */
}
END_TEST

/* H042: a vertex is the same point of ray space in every role; contraction would tell them apart.
 * So t is the same whatever the order of vertices. */
START_TEST(test_triangle__h042_roles)
{
    static const int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {2, 1, 0}, {1, 0, 2}, {0, 2, 1}};
    struct random r = random_begin(42);
    int hits = 0;
    for (int i = 0; i < 10000; i++) {
        vec3 corner[3] = {random_vec(&r, 1), random_vec(&r, 1), random_vec(&r, 1)};
        struct pen_ray ray = world_ray(random_vec(&r, 2), random_direction(&r));
        struct pen_sheared p[3] = {pen_shear(&ray, &corner[0]), {0, 0, 0}, {0, 0, 0}};
        double at[6][2];
        bool hit[6][2];
        for (int k = 0; k < 6; k++) {
            struct pen_triangle tri;
            struct pen_polygon pg;
            vec3 v[3] = {corner[order[k][0]], corner[order[k][1]], corner[order[k][2]]};
            ck_assert(pen_triangle_make(&tri, v[0], v[1], v[2]) && pen_polygon_make(&pg, v, 3));
            hit[k][0] = pen_triangle_root(&tri, &ray, &at[k][0]);
            hit[k][1] = pen_polygon_root(&pg, &ray, &at[k][1]);
            ck_assert(hit[k][0] == hit[0][0] && hit[k][1] == hit[0][0]);
            ck_assert(!hit[k][0] || (at[k][0] == at[0][0] && at[k][1] == at[0][1]));
            for (int j = 0; j < 3; j++) {
                if (order[k][j] == 0)
                    p[1] = pen_shear(&ray, &v[j]);
            }
            ck_assert(p[0].x == p[1].x && p[0].y == p[1].y && p[0].z == p[1].z);
        }
        hits += hit[0][0];
        /* H041: an edge has opposite signs in its two directions. */
        struct pen_sheared e = pen_shear(&ray, &corner[1]);
        double there = pen_edge(p[0], e), back = pen_edge(e, p[0]);
        ck_assert((there > 0) == (back < 0) && (there < 0) == (back > 0));
    }
    ck_assert_int_gt(hits, 200);
}
END_TEST

/* A triangle of that aspect, and a ray at an inner point of it, now and then nearly in its plane.
 */
static struct pen_ray aim(struct random *r, double aspect, bool cap, vec3 v[3])
{
    vec3 e = random_direction(r), w = pen_normalize(pen_cross(e, random_direction(r)));
    v[0] = random_vec(r, 1);
    v[1] = pen_add(v[0], e);
    v[2] = pen_along(cap ? pen_along(v[0], e, random_unit(r)) : v[0], w, aspect);
    double a = random_in(r, .05, .9), b = random_in(r, .05, 1) * (.95 - a);
    vec3 to = pen_along(pen_along(v[0], pen_sub(v[1], v[0]), a), pen_sub(v[2], v[0]), b);
    vec3 n = pen_cross(e, w), from = random_direction(r);
    if (random_below(r, 3) == 0)
        from = pen_along(from, n, pow(10, random_in(r, -6, -1)) - pen_dot(from, n));
    vec3 o = pen_along(to, from, random_in(r, .1, 3));
    return world_ray(o, pen_sub(to, o));
}

/* H043: t of needles is as exact as that of any triangle. */
START_TEST(test_triangle__h043_needles)
{
    static const double aspect[] = {1, 1e-3, 1e-6, 1e-9, 1e-12};
    struct random r = random_begin(43);
    for (int i = 0; i < 20000; i++) {
        vec3 v[3];
        struct pen_ray ray = aim(&r, aspect[i % 5], i / 5 & 1, v);
        struct pen_triangle tri;
        struct pen_polygon pg;
        double t[2];
        int inside;
        quad truth = quad_triangle(v, ray.o, ray.d, &inside);
        ck_assert(pen_triangle_make(&tri, v[0], v[1], v[2]) && pen_polygon_make(&pg, v, 3));
        bool hit = pen_triangle_root(&tri, &ray, &t[0]);
        ck_assert(hit || inside <= 0 || aspect[i % 5] < 1e-11);
        ck_assert(pen_polygon_root(&pg, &ray, &t[1]) == hit);
        /* Polygons are held to this where the ray is not nearly in their plane. */
        double cosine = fabs(pen_dot(tri.facet.n, ray.d)) / pen_length(ray.d);
        for (int k = 0; hit && inside > 0 && k < (cosine < .3 ? 1 : 2); k++) {
            double error = (double)quad_abs((t[k] - truth) / truth) / PEN_U;
            ck_assert_msg(error <= 16, "%d: aspect %g, way %d: %g u", i, aspect[i % 5], k, error);
        }
    }
}
END_TEST

/* H047: thin and grazing: hits match, and t lies among the vertices' depths. */
START_TEST(test_triangle__h047_grazing)
{
    struct random r = random_begin(47);
    for (int i = 0; i < 10000; i++) {
        vec3 e = random_direction(&r), w = pen_normalize(pen_cross(e, random_direction(&r)));
        vec3 n = pen_cross(e, w), v[3];
        v[0] = random_vec(&r, 10);
        v[1] = pen_along(v[0], e, 11.2);
        v[2] = pen_along(pen_along(v[0], e, 9.661), w, .869); /* edges 11.2, 9.7, 1.4 or so */
        double a = random_in(&r, -.2, 1.2), b = random_in(&r, -.2, 1.2 - a);
        vec3 to = pen_along(pen_along(v[0], pen_sub(v[1], v[0]), a), pen_sub(v[2], v[0]), b);
        vec3 flat = pen_normalize(pen_cross(n, random_direction(&r)));
        vec3 d = pen_along(flat, n, 0.0091);
        struct pen_ray ray = world_ray(pen_along(to, d, -random_in(&r, 1, 40)), d);
        struct pen_triangle tri;
        double t;
        int inside;
        quad truth = quad_triangle(v, ray.o, ray.d, &inside);
        ck_assert(pen_triangle_make(&tri, v[0], v[1], v[2]));
        bool hit = pen_triangle_root(&tri, &ray, &t);
        ck_assert(inside == 0 || hit == (inside > 0));
        if (!hit)
            continue;
        ck_assert((double)quad_abs((t - truth) / truth) < 16 * PEN_U / 0.0091);
        double lo = INFINITY, hi = -INFINITY;
        for (int k = 0; k < 3; k++) {
            double depth = pen_shear(&ray, &tri.v[k]).z * ray.sz;
            lo = fmin(lo, depth);
            hi = fmax(hi, depth);
        }
        ck_assert(t >= lo - 4 * PEN_U * fabs(lo) && t <= hi + 4 * PEN_U * fabs(hi));
    }
}
END_TEST

PEN_SUITE("triangle", test_triangle__h032_inside_rim_and_outside,
          test_triangle__normal_is_on_the_counter_clockwise_side, test_triangle__h045_degenerate,
          test_triangle__h046_pbrt_bad_case, test_triangle__h048_edge_on, test_triangle__h042_roles,
          test_triangle__h043_needles, test_triangle__h047_grazing)
