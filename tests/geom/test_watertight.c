/* SPDX-License-Identifier: MIT */
/* Closed surfaces have no leaks and no double intersections. Rays are aimed at vertices, edges and
 * points of edges that are exact in binary, near the coordinate origin and far from it. */
#include <check.h>

#include "geom/rows.h"
#include "support/suite.h"

static struct world world;

static const vec3 offset[3] = {{0, 0, 0}, {1e6, -3.7e5, 1.7e6}, {1e9, -1e9, 1e9}};

/* A point of the surface: in general, a vertex, on an edge, or exactly on an edge if its ends
 * allow (a multiple of 1/8 of the way). */
static vec3 target(struct random *r, int what)
{
    const struct pen_triangle *t = &world.triangle[random_below(r, world.prims.count)];
    vec3 a = t->v[0], e = pen_sub(t->v[1], a);
    if (what == 0)
        return pen_along(pen_along(a, e, random_in(r, 0, .5)), pen_sub(t->v[2], a),
                         random_in(r, 0, .5));
    if (what == 1)
        return t->v[random_below(r, 3)];
    return pen_along(a, e, what == 2 ? random_unit(r) : random_below(r, 9) / 8.);
}

START_TEST(test_watertight__h038_h039_bumpy_sphere)
{
    struct random r = random_begin(38);
    vec3 middle = offset[_i];
    world_bumpy(&world, &r, middle);
    for (int i = 0; i < random_some(10000, 3000); i++) {
        vec3 o = pen_along(middle, random_direction(&r), .5);
        vec3 d = pen_sub(target(&r, i % 4), o);
        int count = world_count(&world, o, i & 8 ? d : pen_normalize(d));
        ck_assert_msg(count % 2 == 1, "offset %d, ray %d: %d intersections; seed %llu", _i, i,
                      count, (unsigned long long)r.seed);
    }
}
END_TEST

/* H040, and H058 for the parity: a cube of n x n squares a side, as polygons and triangles mixed,
 * far off; from inside one intersection, through it two. */
START_TEST(test_watertight__h040_h058_cube)
{
    enum { N = 8 };
    struct random r = random_begin(40);
    vec3 middle = _i ? pen_vec3(148376, 1234, -223423) : pen_vec3(0, 0, 0);
    world_clear(&world);
    for (int face = 0; face < 6; face++) {
        for (int k = 0; k < N * N; k++) {
            vec3 v[4];
            for (int c = 0; c < 4; c++) {
                double p[3];
                p[face / 2] = face & 1 ? 1 : -1;
                p[(face / 2 + 1) % 3] = 2. * (k % N + (c == 1 || c == 2)) / N - 1;
                p[(face / 2 + 2) % 3] = 2. * (k / N + (c >= 2)) / N - 1;
                v[c] = pen_add(middle, pen_vec3(p[0], p[1], p[2]));
            }
            if (random_below(&r, 2)) {
                world_polygon(&world, v, 4);
            } else {
                world_triangle(&world, v[0], v[1], v[2]);
                world_triangle(&world, v[0], v[2], v[3]);
            }
        }
    }
    for (int i = 0; i < random_some(10000, 3000); i++) {
        double fine = i & 1 ? 4 : 1; /* vertices and edges, or between them */
        vec3 p = random_vec(&r, 1.25);
        p = pen_vec3(round(p.x * N * fine) / (N * fine), round(p.y * N * fine) / (N * fine),
                     i & 2 ? p.z : 1);
        vec3 o = pen_add(middle, random_vec(&r, .5)), far = pen_add(middle, pen_vec3(3, 2, 5));
        vec3 to = pen_add(middle, p);
        ck_assert_int_eq(world_count(&world, o, pen_sub(to, o)), 1);
        int through = world_count(&world, far, pen_sub(to, far));
        ck_assert_msg(through == 0 || through == 2, "ray %d: %d; seed %llu", i, through,
                      (unsigned long long)r.seed);
    }
}
END_TEST

/* H049: squares split along either diagonal: each lattice point belongs to one triangle. */
START_TEST(test_watertight__h049_coplanar_tiling)
{
    enum { N = 16 };
    world_clear(&world);
    for (int k = 0; k < N * N; k++) {
        double x = k % N, y = k / N; /* NOLINT: rows on purpose */
        vec3 v[4] = {{x, y, 0}, {x + 1, y, 0}, {x + 1, y + 1, 0}, {x, y + 1, 0}};
        int s = (k ^ k / N) & 1;
        world_triangle(&world, v[s], v[s + 1], v[s + 2]);
        world_triangle(&world, v[s], v[s + 2], v[(s + 3) % 4]);
    }
    static const vec3 d[] = {{0, 0, 1}, {.5, .25, 1}, {1, -1, 1}, {-.25, .125, -.5}, {1, 2, .5}};
    for (int direction = 0; direction < 5; direction++) {
        for (int i = 2; i < 4 * N - 2; i++) {
            for (int j = 2; j < 4 * N - 2; j += direction ? 7 : 1) {
                vec3 o = pen_along(pen_vec3(i / 4., j / 4., 0), d[direction], -4);
                ck_assert_int_eq(world_count(&world, o, d[direction]), 1);
            }
        }
    }
}
END_TEST

/* H050: a folded sheet of squares, triangles, pentagons and concave Ls: strips of unit squares of
 * which some are cut into an L and a small square, over a height that folds it. */
static vec3 lift(struct random *r, double x, double y, vec3 at)
{
    (void)r;
    double fold = fabs(fmod(x, 4) - 2); /* creases along x = 0, 2, 4 ... */
    return pen_add(at, pen_vec3(x + .1 * y, y, .7 * fold + .2 * y));
}

static void make_sheet(struct random *r, vec3 at)
{
    world_clear(&world);
    for (int i = 0; i < 12; i++) {
        for (int j = 0; j < 8; j++) {
            double x = i, y = j, m = .5;
            vec3 a = lift(r, x, y, at), b = lift(r, x + 1, y, at), c = lift(r, x + 1, y + 1, at);
            vec3 d = lift(r, x, y + 1, at), e = lift(r, x + m, y + m, at);
            vec3 s = lift(r, x + m, y, at), w = lift(r, x, y + m, at);
            vec3 n = lift(r, x + m, y + 1, at), o = lift(r, x + 1, y + m, at);
            /* All corners of neighbours are corners here too: no vertex rests on an edge. */
            const vec3 ell[8] = {a, s, b, o, e, n, d, w}, square[4] = {e, o, c, n};
            const vec3 house[7] = {a, s, b, o, c, e, w}, rest[4] = {e, c, n, d};
            const vec3 whole[8] = {a, s, b, o, c, n, d, w};
            switch (random_below(r, 3)) {
            case 0:
                world_polygon(&world, ell, 8);
                world_polygon(&world, square, 4);
                break;
            case 1:
                world_polygon(&world, house, 7);
                world_polygon(&world, rest, 4);
                world_triangle(&world, e, d, w);
                break;
            default:
                world_polygon(&world, whole, 8);
            }
        }
    }
}

START_TEST(test_watertight__h050_h057_folded_sheet_of_all_kinds)
{
    struct random r = random_begin(50);
    int hits = 0;
    vec3 at = offset[_i];
    make_sheet(&r, at);
    for (int i = 0; i < random_some(10000, 3000); i++) {
        /* Corners and points of edges, well inside; from above each is seen once. */
        double x = 1 + random_below(&r, 20) / 2., y = 1 + random_below(&r, 12) / 2.;
        vec3 to = lift(&r, x, y, at), next = lift(&r, x + .5 * (i & 1), y + .5 * !(i & 1), at);
        if (i & 2)
            to = pen_along(to, pen_sub(next, to),
                           i & 4 ? random_unit(&r) : random_below(&r, 9) / 8.);
        vec3 o = pen_add(to, pen_add(pen_vec3(0, 0, 30), random_vec(&r, 3)));
        int count = world_count(&world, o, pen_sub(to, o));
        ck_assert_msg(count == 1, "offset %d, ray %d: %d intersections; seed %llu", _i, i, count,
                      (unsigned long long)r.seed);
        hits += count;
    }
    ck_assert_int_eq(hits, random_some(10000, 3000));
}
END_TEST

/* H044: needles that meet in a point: it belongs to one of them. */
START_TEST(test_watertight__h044_needle_fan)
{
    enum { N = 500 };
    struct random r = random_begin(44);
    vec3 apex = pen_vec3(.1, .2, .3), rim[N];
    for (int i = 0; i < N; i++) {
        double s = (i - N / 2) * 1e-7;
        rim[i] = pen_add(apex, pen_vec3((1 - s * s) / (1 + s * s), 2 * s / (1 + s * s), 0));
    }
    world_clear(&world);
    for (int i = 0; i + 1 < N; i++)
        world_triangle(&world, apex, rim[i], rim[i + 1]);
    world_triangle(&world, apex, rim[N - 1], pen_add(apex, pen_vec3(-1, 3, 0)));
    world_triangle(&world, apex, pen_add(apex, pen_vec3(-1, 3, 0)),
                   pen_add(apex, pen_vec3(-1, -3, 0)));
    world_triangle(&world, apex, pen_add(apex, pen_vec3(-1, -3, 0)), rim[0]);
    for (int i = 0; i < 2000; i++) {
        vec3 o = pen_add(apex, pen_vec3(random_in(&r, -1, 1), random_in(&r, -1, 1), 2));
        ck_assert_int_eq(world_count(&world, o, pen_sub(apex, o)), 1);
        vec3 to = pen_scale(pen_add(apex, rim[i % N]), .5);
        ck_assert_int_eq(world_count(&world, o, pen_sub(to, o)), 1);
    }
}
END_TEST

/* H056: an edge of 1e6 beside an edge of 1e-6: a tetrahedron with one tiny face. */
START_TEST(test_watertight__h056_huge_beside_small)
{
    struct random r = random_begin(56);
    vec3 a = {0, 0, 0}, b = {1e-6, 0, 0}, c = {0, 1e-6, 0}, top = {3e5, 2e5, 1e6};
    world_clear(&world);
    world_triangle(&world, a, c, b);
    world_triangle(&world, a, b, top);
    world_triangle(&world, b, c, top);
    world_triangle(&world, c, a, top);
    vec3 corner[4] = {a, b, c, top};
    vec3 middle = pen_scale(pen_add(pen_add(a, b), pen_add(c, pen_scale(top, 1e-12))), 1. / 4);
    for (int i = 0; i < random_some(10000, 3000); i++) {
        vec3 p = corner[random_below(&r, 4)], q = corner[random_below(&r, 4)];
        vec3 to = i & 1 ? p : pen_along(p, pen_sub(q, p), random_below(&r, 9) / 8.);
        vec3 d = pen_sub(to, middle);
        if (pen_norm1(d) == 0)
            continue;
        int count = world_count(&world, middle, d);
        ck_assert_msg(count % 2 == 1, "ray %d: %d intersections; seed %llu", i, count,
                      (unsigned long long)r.seed);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("watertight");
    TCase *tcase = tcase_create("watertight");
    tcase_set_timeout(tcase, 300);
    tcase_add_loop_test(tcase, test_watertight__h038_h039_bumpy_sphere, 0, 3);
    tcase_add_loop_test(tcase, test_watertight__h040_h058_cube, 0, 2);
    tcase_add_test(tcase, test_watertight__h049_coplanar_tiling);
    tcase_add_loop_test(tcase, test_watertight__h050_h057_folded_sheet_of_all_kinds, 0, 3);
    tcase_add_test(tcase, test_watertight__h044_needle_fan);
    tcase_add_test(tcase, test_watertight__h056_huge_beside_small);
    suite_add_tcase(suite, tcase);
    SRunner *runner = srunner_create(suite);
    srunner_run_all(runner, CK_NORMAL);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed != 0;
}
