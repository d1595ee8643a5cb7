/* SPDX-License-Identifier: MIT */
/* Cylinders with two ends. */
#include "geom/quad.h"
#include "geom/rows.h"
#include "support/suite.h"

static struct world world;

/* Radius 1, height 2, from 0 along z. */
static void standing(bool caps)
{
    world_clear(&world);
    world_cylinder(&world, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), 1, 2, caps);
}

START_TEST(test_cylinder__h025_normals_go_by_part)
{
    static const struct {
        vec3 p;
        uint8_t part;
        vec3 n;
    } row[] = {{{0, 1, 1}, PEN_PART_SIDE, {0, 1, 0}},  {{.5, 0, 0}, PEN_PART_BASE, {0, 0, -1}},
               {{-.5, 0, 2}, PEN_PART_TOP, {0, 0, 1}}, {{0, 0, 0}, PEN_PART_BASE, {0, 0, -1}},
               {{0, 0, 2}, PEN_PART_TOP, {0, 0, 1}},   {{1, 0, 0}, PEN_PART_BASE, {0, 0, -1}},
               {{1, 0, 2}, PEN_PART_TOP, {0, 0, 1}}};
    standing(true);
    for (int i = 0; i < 7; i++) {
        vec3 n = pen_cylinder_normal(&world.cylinder[0], row[i].part, row[i].p);
        ck_assert(n.x == row[i].n.x && n.y == row[i].n.y && n.z == row[i].n.z);
    }
}
END_TEST

START_TEST(test_cylinder__h025_at_a_rim_the_cap_wins)
{
    /* Down and up along the side, just inside of it, and through the rim from the side. */
    const vec3 o[] = {{0, 0, 3}, {2, 0, 1}, {2, 0, 3}}, d[] = {{0, 0, -1}, {-1, 0, 1}, {-1, 0, -1}};
    standing(true);
    for (int i = 0; i < 3; i++) {
        struct pen_hit hit[2];
        struct pen_ray ray = world_ray(o[i], d[i]);
        int count = world_intersections(&world, &ray, &pen_origin_none, INFINITY, hit, 2);
        ck_assert_int_eq(count, i == 1 ? 0 : 2); /* (2,0,1)+(-1,0,1) only touches the rim */
        if (count > 0)
            ck_assert_int_eq(hit[0].part, PEN_PART_TOP);
    }
}
END_TEST

/* Of two cylinders that share a cap, exactly one owns a line in its plane, whichever way their axes
 * and the line run. A pair owns the lines of one of its outer caps. */
START_TEST(test_cylinder__h148_half_open_caps)
{
    for (int i = 0; i < 3 * 8 * 8; i++) {
        const int up = i % 3;
        const double low = i / 3 & 1 ? -1 : 1, high = i / 6 & 1 ? -1 : 1;
        const struct pen_vec3 axis = pen_vec3(up == 0 ? 1 : 0, up == 1 ? 1 : 0, up == 2 ? 1 : 0);
        const double c = cos(0.1 + i / 24 * 0.7), s = sin(0.1 + i / 24 * 0.7);
        const struct pen_vec3 d = up == 0   ? pen_vec3(0, c, s)
                                  : up == 1 ? pen_vec3(c, 0, s)
                                            : pen_vec3(c, s, 0);
        int count[3];
        world_clear(&world);
        world_cylinder(&world, pen_scale(axis, low > 0 ? -2 : 0), pen_scale(axis, low), 1, 2, true);
        world_cylinder(&world, pen_scale(axis, high > 0 ? 0 : 3), pen_scale(axis, high), 1, 3,
                       true);
        for (int k = 0; k < 3; k++) {
            const double at = k == 0 ? 0 : k == 1 ? -2 : 3;
            struct pen_hit hit[4];
            struct pen_ray ray = world_ray(pen_along(pen_scale(d, -4), axis, at), d);
            count[k] = world_intersections(&world, &ray, &pen_origin_none, INFINITY, hit, 4);
        }
        ck_assert_int_eq(count[0], 2);
        ck_assert_int_eq(count[1] + count[2], 2);
    }
}
END_TEST

START_TEST(test_cylinder__h026_tmax)
{
    static const struct {
        double tmax;
        int count;
    } row[] = {{10, 2}, {5, 2}, {.99, 0}, {1, 1}, {2, 1}, {3, 2}, {0, 0}};
    world_clear(&world);
    world_cylinder(&world, pen_vec3(1, 0, 0), pen_vec3(1, 0, 0), 1, 1, true);
    struct pen_ray ray = world_ray(pen_vec3(1.5, 0, -2), pen_vec3(0, 0, 1));
    struct pen_hit hit[2];
    for (int i = 0; i < 7; i++)
        ck_assert_int_eq(world_intersections(&world, &ray, &pen_origin_none, row[i].tmax, hit, 2),
                         row[i].count);
    world_intersections(&world, &ray, &pen_origin_none, 10, hit, 2);
    ck_assert(hit[0].t == 1 && hit[1].t == 3);
}
END_TEST

START_TEST(test_cylinder__caps_are_met_along_the_axis)
{
    const struct row rows[] = {
        {{0, 0, -1}, {0, 0, 1}, 2, {{0, 0, 0}, {0, 0, 2}}},
        {{.5, .25, 5}, {0, 0, -2}, 2, {{.5, .25, 2}, {.5, .25, 0}}},
        {{0, 0, 0},
         {0, 0, 1},
         ONE(0, 0, 2)}, /* the base centre is no intersection of its own (D6) */
        {{0, 0, 1}, {0, 0, -1}, ONE(0, 0, 0)},
        {{1, 0, -1}, {0, 0, 1}, NONE},                       /* in the side */
        {{2, 0, -1}, {0, 0, 1}, NONE},                       /* beside it */
        {{-2, 0, 0}, {1, 0, 0}, 2, {{-1, 0, 0}, {1, 0, 0}}}, /* in the base's plane */
        {{-2, 0, 2}, {1, 0, 0}, NONE},                       /* in the top's plane */
        {{-2, 0, 1}, {1, 0, 0}, 2, {{-1, 0, 1}, {1, 0, 1}}},
        {{0, 0, 1}, {1, 0, 0}, ONE(1, 0, 1)},
        {{-2, 0, 2.5}, {1, 0, -1}, 2, {{-1, 0, 1.5}, {.5, 0, 0}}}};
    standing(true);
    rows_check(&world, rows, ROWS(rows), 1);
}
END_TEST

START_TEST(test_cylinder__an_open_one_has_no_caps)
{
    const struct row rows[] = {{{0, 0, -1}, {0, 0, 1}, NONE},
                               {{0, 0, 1}, {1, 0, 0}, ONE(1, 0, 1)},
                               {{-2, 0, 1}, {1, 0, 0}, 2, {{-1, 0, 1}, {1, 0, 1}}},
                               {{0, 0, 3}, {.5, 0, -1}, ONE(1, 0, 1)}, /* in at the top */
                               {{-2, 0, 0}, {1, 0, 1}, ONE(-1, 0, 1)}, /* out at the top */
                               {{-2, 0, 4}, {1, 0, -1}, ONE(1, 0, 1)}};
    standing(false);
    rows_check(&world, rows, ROWS(rows), 1);
}
END_TEST

START_TEST(test_cylinder__bad_input_is_refused)
{
    struct pen_cylinder c;
    vec3 o = pen_vec3(0, 0, 0), z = pen_vec3(0, 0, 1);
    ck_assert(!pen_cylinder_make(&c, o, o, 1, 1, true));
    ck_assert(!pen_cylinder_make(&c, o, z, 0, 1, true));
    ck_assert(!pen_cylinder_make(&c, o, z, 1, 0, true));
    ck_assert(!pen_cylinder_make(&c, o, z, 1, -1, true));
    ck_assert(!pen_cylinder_make(&c, o, z, (double)NAN, 1, true));
    ck_assert(!pen_cylinder_make(&c, o, z, 1, (double)INFINITY, true));
}
END_TEST

/* A point of the rim, moved by a few ulps. */
static vec3 rim_point(struct random *r, const struct pen_cylinder *c)
{
    vec3 a = pen_normalize(c->round.a), e = pen_normalize(pen_cross(a, random_direction(r)));
    vec3 p = pen_along(pen_along(c->round.q, a, random_below(r, 2) ? c->h : 0), e, c->round.r);
    static const int step[] = {0, 0, 1, -1, 2, -2, 64, -64};
    return pen_vec3(random_nudge(p.x, step[random_below(r, 8)]),
                    random_nudge(p.y, step[random_below(r, 8)]),
                    random_nudge(p.z, step[random_below(r, 8)]));
}

/* D6: rays aimed at the rim have an entry and an exit, or neither; from inside they have one exit.
 */
START_TEST(test_cylinder__rim_intersections_pair_up)
{
    static const double radius[] = {1e-3, 1, 1e4};
    struct random r = random_begin(41);
    int hits = 0;
    for (int i = 0; i < 30000; i++) {
        double size = radius[i % 3];
        world_clear(&world);
        world_cylinder(&world, random_vec(&r, 1), random_direction(&r), size,
                       size * random_in(&r, .1, 3), true);
        const struct pen_cylinder *c = &world.cylinder[0];
        vec3 middle = pen_along(c->round.q, pen_normalize(c->round.a), .5 * c->h);
        vec3 rim = rim_point(&r, c);
        vec3 out = pen_along(middle, random_direction(&r), 10 * size);
        int from_outside = world_count(&world, out, pen_sub(rim, out));
        int from_inside = world_count(&world, middle, pen_sub(rim, middle));
        ck_assert_msg(from_outside % 2 == 0, "%d: %d from outside", i, from_outside);
        ck_assert_msg(from_inside == 1, "%d: %d from inside", i, from_inside);
        hits += from_outside / 2;
    }
    ck_assert(hits > 3000 && hits < 27000);
}
END_TEST

/* The interval of the ray's line inside, in quad; false if rounding of the inputs could change hit
 * or miss. */
static bool inside_quad(const struct pen_cylinder *c, const struct pen_ray *ray, quad t[2],
                        uint8_t part[2], bool *met)
{
    struct quad3 a = quad3(c->round.a), f = quad_sub(quad3(ray->o), quad3(c->round.q));
    quad side[2], da = quad_dot(quad3(ray->d), a), fa = quad_dot(f, a);
    quad disc = quad_tube(c->round.q, c->round.a, c->round.r, ray->o, ray->d, side);
    quad top = c->h * quad_sqrt(quad_dot(a, a)), base = -fa / da;
    *met = disc > 0;
    if (!*met)
        return quad_abs(disc) > (quad)1e-9;
    top = (top - fa) / da;
    quad lo = da > 0 ? base : top, hi = da > 0 ? top : base;
    t[0] = lo > side[0] ? lo : side[0];
    t[1] = hi < side[1] ? hi : side[1];
    part[0] = lo <= side[0] ? PEN_PART_SIDE : da > 0 ? PEN_PART_BASE : PEN_PART_TOP;
    part[1] = hi >= side[1] ? PEN_PART_SIDE : da > 0 ? PEN_PART_TOP : PEN_PART_BASE;
    *met = t[0] < t[1];
    quad slack = (quad)1e-9;
    return quad_abs(disc) > slack && quad_abs(t[1] - t[0]) > slack &&
           quad_abs(lo - side[0]) > slack && quad_abs(hi - side[1]) > slack;
}

/* <= 16 ulp of t from 2 r away, else <= 8u (|f| + r) towards the part: the side and the caps. */
START_TEST(test_cylinder__intersections_match_quad)
{
    struct random r = random_begin(42);
    int met_count = 0;
    for (int i = 0; i < 20000; i++) {
        struct pen_cylinder c;
        double h = random_in(&r, .2, 3), far = i & 1 ? random_in(&r, 4, 40) : random_in(&r, 0, 2);
        ck_assert(pen_cylinder_make(&c, random_vec(&r, 1), random_direction(&r), 1, h, true));
        vec3 o = pen_along(c.round.q, random_direction(&r), far);
        vec3 to = pen_add(c.round.q, random_vec(&r, 1));
        struct pen_ray ray = world_ray(o, pen_sub(to, o));
        struct pen_interval in;
        quad truth[2];
        uint8_t part[2];
        bool met;
        if (!inside_quad(&c, &ray, truth, part, &met))
            continue;
        ck_assert_msg(pen_cylinder_interval(&c, &ray, &in) == met, "%d", i);
        if (!met)
            continue;
        met_count++;
        ck_assert(in.lo_part == part[0] && in.hi_part == part[1]);
        double t[2] = {in.lo, in.hi}, length = pen_length(ray.d);
        for (int k = 0; k < 2; k++) {
            double ulps = quad_ulps(t[k], truth[k]), f = pen_length(pen_sub(o, c.round.q));
            double error = (double)quad_abs(t[k] - truth[k]) * length;
            vec3 n = pen_cylinder_normal(&c, part[k], pen_along(o, ray.d, t[k]));
            double cosine = fabs(pen_dot(n, ray.d)) / length;
            ck_assert_msg(ulps <= 16 || (far < 2 && error * cosine <= 8 * PEN_U * (f + 1)),
                          "%d: far %g: %g ulp, error %g", i, far, ulps, error);
        }
    }
    ck_assert_int_gt(met_count, 10000);
}
END_TEST

PEN_SUITE("cylinder", test_cylinder__h148_half_open_caps, test_cylinder__h025_normals_go_by_part,
          test_cylinder__h025_at_a_rim_the_cap_wins, test_cylinder__h026_tmax,
          test_cylinder__caps_are_met_along_the_axis, test_cylinder__an_open_one_has_no_caps,
          test_cylinder__bad_input_is_refused, test_cylinder__rim_intersections_pair_up,
          test_cylinder__intersections_match_quad)
