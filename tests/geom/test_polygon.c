/* SPDX-License-Identifier: MIT */
/* Polygons. */
#include "geom/quad.h"
#include "geom/rows.h"
#include "support/suite.h"

static struct world world;

static const vec3 quad_corners[4] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 1, 1}};
static const vec3 square[4] = {{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};

START_TEST(test_polygon__h027_any_outline_with_an_area)
{
    struct pen_polygon p;
    const vec3 concave[4] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {.5, .25, .25}};
    const vec3 line[4] = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}};
    const vec3 bad[3] = {{0, 0, 0}, {1, (double)INFINITY, 0}, {0, 1, 0}};
    ck_assert(pen_polygon_make(&p, quad_corners, 4));
    ck_assert(pen_polygon_make(&p, concave, 4));
    ck_assert(!pen_polygon_make(&p, line, 4));
    ck_assert(!pen_polygon_make(&p, quad_corners, 2));
    ck_assert(!pen_polygon_make(&p, bad, 3));
}
END_TEST

/* H028: a vertex on a side changes nothing. */
START_TEST(test_polygon__h028_vertex_on_a_side)
{
    const vec3 v[5] = {{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {0, 1, 1}, {-1, 1, 1}};
    struct pen_polygon p, q;
    ck_assert(pen_polygon_make(&p, v, 5) && pen_polygon_make(&q, square, 4));
    for (int i = -5; i <= 5; i++) {
        for (int j = -5; j <= 5; j++) {
            struct pen_ray ray = world_ray(pen_vec3(i / 4., j / 4., 0), pen_vec3(0, 0, 1));
            double t = 0, u = 0;
            ck_assert(pen_polygon_root(&p, &ray, &t) == pen_polygon_root(&q, &ray, &u) && t == u);
        }
    }
}
END_TEST

START_TEST(test_polygon__h029_normal)
{
    struct pen_polygon p;
    ck_assert(pen_polygon_make(&p, quad_corners, 4));
    ck_assert(quad_ulps(p.facet.n.x, 1 / quad_sqrt(3)) <= 2 && p.facet.n.x == p.facet.n.y &&
              p.facet.n.y == p.facet.n.z);
    for (int i = 0; i < 4; i++)
        ck_assert(fabs(pen_dot(p.facet.n, pen_sub(quad_corners[(i + 1) % 4], quad_corners[i]))) <=
                  4 * PEN_U);
}
END_TEST

static int at(double x, double y)
{
    return world_count(&world, pen_vec3(x, y, -1), pen_vec3(0, 0, 1));
}

START_TEST(test_polygon__h030_inside_outside_and_rim)
{
    world_clear(&world);
    world_polygon(&world, square, 4);
    ck_assert(at(0, 0) == 1 && at(2, 2) == 0 && at(1, 0) == 0 && at(1, 1) == 0);
    const double tmax[] = {5, 2, nextafter(2, 0), .5};
    for (int i = 0; i < 4; i++) {
        struct pen_ray in = world_ray(pen_vec3(0, 0, -1), pen_vec3(0, 0, 1));
        struct pen_ray out = world_ray(pen_vec3(2, 2, -1), pen_vec3(0, 0, 1));
        ck_assert_int_eq(world_intersections(&world, &in, &pen_origin_none, tmax[i], NULL, 0),
                         i < 2);
        ck_assert_int_eq(world_intersections(&world, &out, &pen_origin_none, tmax[i], NULL, 0), 0);
    }
}
END_TEST

START_TEST(test_polygon__h031_the_rest_of_the_rim)
{
    world_clear(&world);
    world_polygon(&world, square, 4);
    ck_assert(at(-1, 0) == 1 && at(0, -1) == 1 && at(-1, -1) == 1);
    ck_assert(at(0, 1) == 0 && at(1, -1) == 0 && at(-1, 1) == 0);
    /* Nine squares, neighbours on all sides: every point of a border belongs to one of them. */
    for (int i = -1; i <= 1; i++) {
        for (int j = -1; j <= 1; j++) {
            vec3 v[4];
            for (int k = 0; k < 4; k++)
                v[k] = pen_add(square[k], pen_vec3(2 * i, 2 * j, 0));
            if (i || j)
                world_polygon(&world, v, 4);
        }
    }
    for (int i = -8; i <= 8; i++) {
        for (int j = -8; j <= 8; j++)
            ck_assert_int_eq(at(i / 8., j / 8.), 1);
    }
}
END_TEST

/* Inside by exact arithmetic: vertices and points are integers; 0 on the rim. */
static int inside_exactly(const int (*v)[2], int count, int x, int y)
{
    bool odd = false;
    for (int i = 0; i < count; i++) {
        int ax = v[i][0] - x, ay = v[i][1] - y;
        int bx = v[(i + 1) % count][0] - x, by = v[(i + 1) % count][1] - y;
        int side = ax * by - ay * bx;
        if (side == 0 && ax * bx <= 0 && ay * by <= 0)
            return 0;
        if ((ay > 0) != (by > 0) && (by > ay ? side > 0 : side < 0))
            odd = !odd;
    }
    return odd ? 1 : -1;
}

/* H052: a star with notches, on a slanted plane x + y + z = 0 seen along z. */
START_TEST(test_polygon__h052_concave_star)
{
    static const int star[10][2] = {{0, 16}, {4, 5},    {15, 5},  {6, -2},  {9, -13},
                                    {0, -6}, {-9, -13}, {-6, -2}, {-15, 5}, {-4, 5}};
    vec3 v[10];
    int counts[3] = {0};
    for (int i = 0; i < 10; i++)
        v[i] = pen_vec3(star[i][0], star[i][1], -star[i][0] - star[i][1]);
    world_clear(&world);
    world_polygon(&world, v, 10);
    for (int x = -17; x <= 17; x++) {
        for (int y = -17; y <= 17; y++) {
            struct pen_ray ray = world_ray(pen_vec3(x, y, -100), pen_vec3(0, 0, 1));
            struct pen_hit hit;
            int truth = inside_exactly(star, 10, x, y);
            int count = world_intersections(&world, &ray, &pen_origin_none, INFINITY, &hit, 1);
            ck_assert_msg(truth == 0 || count == (truth > 0), "%d %d", x, y);
            if (count > 0)
                ck_assert(fabs(hit.t - (100 - x - y)) <= 100 * 8 * PEN_U);
            counts[truth + 1]++;
        }
    }
    ck_assert(counts[0] > 100 && counts[1] > 10 && counts[2] > 100);
}
END_TEST

enum { ROUND = 10000 };

/* A circle, its corners by a rational formula. */
static void make_circle(vec3 v[ROUND])
{
    for (int i = 0; i < ROUND; i++) {
        double s = tan((i + .5 - ROUND / 2.) * 3.14159265358979323846 / ROUND);
        v[i] = pen_vec3((1 - s * s) / (1 + s * s), 2 * s / (1 + s * s), 0);
    }
}

/* t does not depend on where the outline starts, nor on its direction, at its corners either. */
START_TEST(test_polygon__any_start_and_direction)
{
    static const double outline[7][2] = {{0, 0}, {4, 0}, {4, 3}, {3, 3}, {2, 1}, {1, 4}, {0, 3}};
    struct random r = random_begin(69);
    for (int i = 0; i < 10000; i++) {
        vec3 o = random_vec(&r, 1), e = random_direction(&r),
             w = pen_cross(e, random_direction(&r));
        vec3 v[7], u[7];
        for (int k = 0; k < 7; k++)
            v[k] = pen_along(pen_along(o, e, outline[k][0]), w, outline[k][1]);
        int start = (int)random_below(&r, 7), step = i & 1 ? 1 : 6;
        for (int k = 0; k < 7; k++)
            u[k] = v[(start + step * k) % 7];
        vec3 to = i & 2 ? v[i % 7] : pen_along(pen_along(o, e, random_in(&r, 0, 4)), w, 1);
        vec3 from = pen_add(o, random_vec(&r, 9));
        struct pen_ray ray = world_ray(from, pen_sub(to, from));
        struct pen_polygon p, q;
        double t = 0, s = 0;
        ck_assert(pen_polygon_make(&p, v, 7) && pen_polygon_make(&q, u, 7));
        ck_assert(pen_polygon_root(&p, &ray, &t) == pen_polygon_root(&q, &ray, &s));
        ck_assert_msg(t == s, "%d: %a %a; seed %llu", i, t, s, (unsigned long long)r.seed);
    }
}
END_TEST

/* H055: ten thousand corners: the area is right, and each point of the rim belongs either to the
 * circle or to a square with the circle as its hole (one outline, cut open at the first corner). */
START_TEST(test_polygon__h055_ten_thousand_corners)
{
    static vec3 v[ROUND + 7];
    const vec3 frame[6] = {{-2, 0, 0}, {-2, 2, 0}, {2, 2, 0}, {2, -2, 0}, {-2, -2, 0}, {-2, 0, 0}};
    struct pen_polygon circle, rest;
    struct random r = random_begin(55);
    make_circle(v);
    v[ROUND] = v[0];
    for (int k = 0; k < 6; k++)
        v[ROUND + 1 + k] = frame[k];
    ck_assert(pen_polygon_make(&circle, v, ROUND) && circle.facet.n.z == 1);
    ck_assert(pen_polygon_make(&rest, v, ROUND + 7));
    int hits = 0;
    double t;
    for (int i = 0; i < 2000; i++) {
        struct pen_ray ray =
            world_ray(pen_vec3(random_in(&r, -1, 1), random_in(&r, -1, 1), 1), pen_vec3(0, 0, -1));
        hits += pen_polygon_root(&circle, &ray, &t);
    }
    ck_assert(fabs(hits / 2000. - .785398) < 5 * sqrt(.785398 * .2146 / 2000));
    for (int i = 0; i < ROUND - 1; i += 5) { /* at a corner, and in the middle of a side */
        vec3 c = i & 1 ? v[i] : pen_scale(pen_add(v[i], v[i + 1]), .5);
        struct pen_ray ray = world_ray(pen_vec3(c.x, c.y, 1), pen_vec3(0, 0, -1));
        ck_assert_int_eq(pen_polygon_root(&circle, &ray, &t) + pen_polygon_root(&rest, &ray, &t),
                         1);
    }
}
END_TEST

/* Where vertices are off one plane, as an offset rounds them, a low ray that passes inside the
 * outline meets the polygon inside it, and not where it meets the mean plane: beyond the border
 * there may be the next wall of a closed room. */
START_TEST(test_polygon__bent_outline_is_not_left)
{
    struct random r = random_begin(54);
    for (int i = 0; i < 20000; i++) {
        double off = pow(10, random_in(&r, -13, -7)), x = random_in(&r, .1, .9),
               sine = pow(10, random_in(&r, -2, 0));
        vec3 v[4] = {{0, 0, off}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
        struct pen_polygon bent;
        ck_assert(pen_polygon_make(&bent, v, 4));
        bool up = random_below(&r, 2);
        vec3 at = pen_vec3(x, pow(10, random_in(&r, -15, -13)), off * (1 - x));
        vec3 d = pen_vec3(0, up ? 1 : -1, -sine);
        double t;
        struct pen_ray ray = world_ray(pen_sub(at, d), d);
        if (!pen_polygon_root(&bent, &ray, &t))
            continue;
        double y = pen_along(ray.o, d, t).y;
        ck_assert_msg(y >= -1e-14 && y <= 1 + 1e-14, "%g off, sine %g: y = %g", off, sine, y);
    }
}
END_TEST

/* ---- Polygons that are cut into triangles ---- */

enum { BENT = 12 };

/* A star-shaped outline of 4 to 12 corners, some of them in line, turned at random, its corners off
 * the plane by up to `off`. */
static uint32_t bent_outline(struct random *r, double off, vec3 v[BENT])
{
    uint32_t count = 4 + random_below(r, BENT - 3);
    vec3 n = random_direction(r), x = pen_normalize(pen_cross(n, random_direction(r)));
    vec3 y = pen_cross(n, x), o = random_vec(r, 1);
    for (uint32_t i = 0; i < count; i++) {
        double a = 6.283185307179586 * i / count, s = random_in(r, .4, 1);
        v[i] = pen_along(pen_along(o, x, s * cos(a)), y, s * sin(a));
        if (count > 4 && i > 1 && random_below(r, 4) == 0)
            v[i - 1] = pen_scale(pen_add(v[i - 2], v[i]), .5);
    }
    for (uint32_t i = 0; i < count; i++)
        v[i] = pen_along(v[i], n, random_in(r, -off, off));
    return count;
}

static double height(const struct pen_triangle *tri, vec3 n)
{
    return pen_dot(n, pen_cross(pen_sub(tri->v[1], tri->v[0]), pen_sub(tri->v[2], tri->v[0])));
}

static bool has_corner(const struct pen_triangle *tri, vec3 p)
{
    for (int i = 0; i < 3; i++)
        if (tri->v[i].x == p.x && tri->v[i].y == p.y && tri->v[i].z == p.z)
            return true;
    return false;
}

/* The triangles tile the outline, and are the same wherever it starts and whichever way it runs. */
static void check_pieces(const struct pen_polygon *p, const struct pen_polygon *q)
{
    double area = 0, whole = 0;
    ck_assert(p->piece && q->piece && p->scale == 0 && !p->flat);
    for (uint32_t i = 0; i + 2 < p->count; i++) {
        const struct pen_triangle *tri = &p->piece[i];
        bool found = false;
        ck_assert(height(tri, p->facet.n) > -1e-15);
        area += height(tri, p->facet.n);
        for (uint32_t k = 0; k + 2 < q->count; k++) {
            const struct pen_triangle *other = &q->piece[k];
            found = found || (has_corner(other, tri->v[0]) && has_corner(other, tri->v[1]) &&
                              has_corner(other, tri->v[2]));
        }
        ck_assert(found);
    }
    for (uint32_t i = 0; i < p->count; i++)
        whole += pen_dot(p->facet.n, pen_cross(pen_sub(p->v[i], p->v[0]),
                                               pen_sub(p->v[(i + 1) % p->count], p->v[0])));
    ck_assert_msg(fabs(area - whole) < 1e-13, "%g, not %g", area, whole);
}

START_TEST(test_polygon__h134_cut_the_same_way)
{
    struct random r = random_begin(134);
    for (int i = 0; i < 2000; i++) {
        vec3 v[BENT], u[BENT];
        uint32_t count = bent_outline(&r, pow(10, random_in(&r, -12, -6)), v);
        uint32_t start = random_below(&r, count), step = i & 1 ? 1 : count - 1;
        for (uint32_t k = 0; k < count; k++)
            u[k] = v[(start + step * k) % count];
        world_clear(&world);
        world_polygon(&world, v, count);
        world_polygon(&world, u, count);
        check_pieces(&world.polygon[0], &world.polygon[1]);
    }
}
END_TEST

/* What is flat up to rounding stays whole; what has three corners is flat. */
START_TEST(test_polygon__h134_not_cut)
{
    struct random r = random_begin(135);
    for (int i = 0; i < 1000; i++) {
        vec3 v[BENT];
        uint32_t count = bent_outline(&r, 0, v);
        for (uint32_t k = 0; k < count;
             k++) /* no corner is near the origin, where doubles are finer */
            v[k] = pen_add(v[k], pen_vec3(4, 4, 4));
        world_clear(&world);
        world_polygon(&world, v, count);
        v[0] = pen_along(v[0], random_direction(&r), 1e-7);
        world_polygon(&world, v, 3);
        ck_assert(!world.polygon[0].piece && !world.polygon[1].piece);
    }
}
END_TEST

/* Whether a triangle is steep: narrow, with a corner off the plane. It may hide others. */
static bool has_steep_piece(const struct pen_polygon *p)
{
    for (uint32_t i = 0; i + 2 < p->count; i++)
        if (pen_dot(p->piece[i].facet.n, p->facet.n) < .9999)
            return true;
    return false;
}

/* A line that passes inside the outline meets the polygon once: on a triangle, within rounding. At
 * the diagonals too, though neighbours differ in slope. */
START_TEST(test_polygon__h134_met_once)
{
    struct random r = random_begin(136);
    int hits = 0;
    for (int i = 0; i < 20000; i++) {
        vec3 v[BENT];
        uint32_t count = bent_outline(&r, 1e-7, v);
        world_clear(&world);
        world_polygon(&world, v, count);
        const struct pen_polygon *p = &world.polygon[0];
        const struct pen_triangle *tri = &p->piece[random_below(&r, count - 2)];
        double s = random_below(&r, 3) / 2., t = random_below(&r, 2) ? 0 : random_unit(&r);
        vec3 to = pen_along(tri->v[0], pen_sub(tri->v[1], tri->v[0]), s);
        to = pen_along(to, pen_sub(tri->v[2], to), t);
        vec3 o = pen_add(to, random_direction(&r));
        struct pen_ray ray = world_ray(o, pen_sub(to, o));
        if (fabs(pen_dot(ray.d, p->facet.n)) < .02 || has_steep_piece(p))
            continue;
        struct pen_hit hit;
        int met = world_intersections(&world, &ray, &pen_origin_none, INFINITY, &hit, 1);
        ck_assert_int_eq(met, pen_polygon_entered(p, &ray));
        if (met == 0)
            continue;
        vec3 x = pen_along(o, ray.d, hit.t), on = pen_prim_point(&world.prims, hit, &ray);
        ck_assert_msg(pen_norm1(pen_sub(x, on)) < 1e-14, "%g off", pen_norm1(pen_sub(x, on)));
        hits++;
    }
    ck_assert(hits > 10000);
}
END_TEST

/* A ray leaves the polygon for good, unless it is so low that another triangle rises before it; one
 * that goes through leaves it in any case. */
/* Of a ridge or valley that a low ray passes twice or not at all, whichever way it comes, the first
 * crossing counts. */
START_TEST(test_polygon__h134_first_crossing)
{
    const double h = 1e-7;
    const vec3 v[4] = {{-1, 0, 0}, {0, -1, h}, {1, 0, 0}, {0, 1, h}};
    world_clear(&world);
    world_polygon(&world, v, 4);
    ck_assert(world.polygon[0].piece != NULL);
    for (int way = -1; way <= 1; way += 2) {
        struct pen_ray ray = world_ray(pen_vec3(-3 * way, 0, .5 * h), pen_vec3(way, 0, 0));
        struct pen_hit hit;
        ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, INFINITY, &hit, 1), 1);
        ck_assert_msg(fabs(hit.t - 2.5) < 1e-6, "t %g", hit.t);
        ray = world_ray(pen_vec3(0, 0, .5 * h), pen_vec3(way, 0, 0));
        ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, INFINITY, &hit, 1), 1);
        ck_assert_msg(fabs(hit.t - .5) < 1e-6, "from inside: t %g", hit.t);
    }
}
END_TEST

START_TEST(test_polygon__h134_left)
{
    struct random r = random_begin(137);
    for (int i = 0; i < 20000; i++) {
        vec3 v[BENT];
        world_clear(&world);
        world_polygon(&world, v, bent_outline(&r, 1e-8, v));
        const struct pen_triangle *tri = &world.polygon[0].piece[0];
        vec3 to = pen_along(tri->v[0], pen_sub(tri->v[1], tri->v[0]), random_unit(&r));
        to = random_below(&r, 2) ? pen_along(to, pen_sub(tri->v[2], to), random_unit(&r)) : to;
        vec3 o = pen_add(to, random_direction(&r)), d = pen_sub(to, o);
        struct pen_ray ray = world_ray(o, d);
        struct pen_hit hit;
        if (world_intersections(&world, &ray, &pen_origin_none, INFINITY, &hit, 1) == 0)
            continue;
        vec3 p = pen_prim_point(&world.prims, hit, &ray), n = pen_prim_normal(&world.prims, hit, p);
        vec3 next = random_direction(&r);
        bool through = (pen_dot(next, n) < 0) == (pen_dot(d, n) < 0);
        struct pen_origin_surface origin =
            world_origin_surface(&world, hit, p, pen_scale(d, hit.t), through);
        ray = world_ray(p, next);
        if (through || fabs(pen_dot(next, n)) > 1e-3)
            ck_assert_int_eq(world_intersections(&world, &ray, &origin, INFINITY, NULL, 0), 0);
    }
}
END_TEST

/* In a valley a low ray from one triangle meets the other: nothing gets out below the next wall. */
START_TEST(test_polygon__h134_valley)
{
    for (int i = 4; i < 10; i++) {
        double off = pow(10, -i);
        const vec3 v[4] = {{-1, -1, off}, {1, -1, 0}, {1, 1, off}, {-1, 1, 0}};
        world_clear(&world);
        world_polygon(&world, v, 4);
        const struct pen_polygon *p = &world.polygon[0];
        vec3 inner = pen_scale(
            pen_add(p->piece[0].v[0], pen_add(p->piece[0].v[1], p->piece[0].v[2])), 1 / 3.);
        vec3 far = pen_scale(pen_add(p->piece[1].v[0], pen_add(p->piece[1].v[1], p->piece[1].v[2])),
                             1 / 3.);
        struct pen_ray ray = world_ray(pen_add(inner, pen_vec3(0, 0, 2)), pen_vec3(0, 0, -1));
        struct pen_hit hit;
        ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, INFINITY, &hit, 1), 1);
        vec3 at = pen_prim_point(&world.prims, hit, &ray);
        struct pen_origin_surface origin =
            world_origin_surface(&world, hit, at, pen_scale(ray.d, hit.t), false);
        double rise = pen_dot(p->piece[0].facet.n, pen_sub(far, at));
        vec3 low = pen_along(pen_sub(far, at), p->piece[0].facet.n, -.5 * rise);
        ray = world_ray(at, pen_scale(low, 2));
        int met = world_intersections(&world, &ray, &origin, INFINITY, NULL, 0);
        ck_assert_int_eq(met, rise > 0);
    }
}
END_TEST

/* Two with the same corners are layers, whatever the order of their corners. */
START_TEST(test_polygon__h134_layers)
{
    struct random r = random_begin(138);
    int layers = 0;
    for (int i = 0; i < 5000; i++) {
        vec3 v[BENT], u[BENT];
        uint32_t count = bent_outline(&r, 1e-7, v), start = random_below(&r, count);
        for (uint32_t k = 0; k < count; k++)
            u[k] = v[(start + (i & 1 ? k : count - k)) % count];
        world_clear(&world);
        world_polygon(&world, v, count);
        world_polygon(&world, u, count);
        const struct pen_triangle *tri = &world.polygon[0].piece[random_below(&r, count - 2)];
        vec3 to = pen_along(tri->v[0], pen_sub(tri->v[1], tri->v[0]), random_in(&r, .1, .9));
        to = pen_along(to, pen_sub(tri->v[2], to), random_in(&r, .1, .9));
        vec3 o = pen_add(to, random_direction(&r)), d = pen_sub(to, o);
        struct pen_ray ray = world_ray(o, d);
        struct pen_hit hit[2];
        if (fabs(pen_dot(d, tri->facet.n)) < .01 || height(tri, tri->facet.n) < 1e-3)
            continue;
        ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, INFINITY, hit, 2), 2);
        hit[0].prim = random_below(&r, 2);
        vec3 p = pen_prim_point(&world.prims, hit[0], &ray);
        for (int through = 0; through < 2; through++) {
            struct pen_origin_surface origin =
                world_origin_surface(&world, hit[0], p, pen_scale(d, hit[0].t), through);
            struct pen_ray next = world_ray(p, through ? d : pen_neg(d));
            struct pen_hit met;
            int count_met = world_intersections(&world, &next, &origin, INFINITY, &met, 1);
            ck_assert_int_eq(count_met, (uint32_t)through != hit[0].prim);
            ck_assert(count_met == 0 || met.t == 2 * PEN_FIRST_T);
            layers += count_met;
        }
    }
    ck_assert(layers > 3000);
}
END_TEST

PEN_SUITE("polygon", test_polygon__bent_outline_is_not_left,
          test_polygon__h027_any_outline_with_an_area, test_polygon__h028_vertex_on_a_side,
          test_polygon__h029_normal, test_polygon__h030_inside_outside_and_rim,
          test_polygon__h031_the_rest_of_the_rim, test_polygon__h052_concave_star,
          test_polygon__any_start_and_direction, test_polygon__h055_ten_thousand_corners,
          test_polygon__h134_cut_the_same_way, test_polygon__h134_not_cut,
          test_polygon__h134_met_once, test_polygon__h134_first_crossing, test_polygon__h134_left,
          test_polygon__h134_valley, test_polygon__h134_layers)
