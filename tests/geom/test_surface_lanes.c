/* SPDX-License-Identifier: MIT */
/* Hit points, normals and origin surfaces in lanes, for every instruction set of this processor:
 * each lane is the result of the scalar functions for it alone. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support/lanes.h"
#include "support/random.h"
#include "support/suite.h"
#include "support/world.h"

typedef struct pen_vec3 vec3;

enum { MAX = LANES_TEST_MAX };

static struct world world;

/* A primitive of any kind, small or large, near the origin or far away. */
static uint32_t some_primitive(struct random *r)
{
    const double size = ldexp(1 + random_unit(r), (int)random_below(r, 60) - 30);
    const double away = random_below(r, 3) ? 1 : ldexp(1, (int)random_below(r, 30));
    const vec3 at = random_vec(r, size * away), axis = random_direction(r);
    const vec3 u = random_vec(r, size), v = random_vec(r, size);
    const vec3 bend = random_vec(r, random_below(r, 2) ? 0x1p-20 * size : 0);
    const vec3 corner[4] = {at, pen_add(at, u), pen_add(at, pen_add(u, v)),
                            pen_add(pen_add(at, v), bend)};
    world_clear(&world);
    switch (random_below(r, 8)) {
    case 0:
        return world_sphere(&world, at, size);
    case 1:
        return world_plane(&world, at, axis);
    case 2:
        return world_triangle(&world, corner[0], corner[1], corner[3]);
    case 3:
        return world_polygon(&world, corner, 4); /* perhaps cut into triangles */
    case 4:
        return world_polygon(&world, corner, 3);
    case 5:
        return world_infinite_cylinder(&world, at, axis, size);
    case 6:
        return world_cone(&world, at, axis, (const double[]){size, size / 2}, size, true);
    default:
        return world_cylinder(&world, at, axis, size, 2 * size, true);
    }
}

/* A point somewhere, or a point on the surface as rounding leaves it. */
static vec3 some_point(struct random *r, const struct pen_kind_functions *fn, const void *self,
                       uint8_t part)
{
    const vec3 p = random_vec(r, ldexp(1, (int)random_below(r, 40) - 20));
    if (random_below(r, 4) == 0)
        return p;
    const vec3 on = fn->project(self, part, p);
    return pen_along(on, random_direction(r), 0x1p-50 * pen_norm1(on));
}

static bool same(vec3 a, vec3 b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

/* Returns whether the group has been computed in lanes. */
static bool compare(const struct lanes_test *test, struct random *r)
{
    struct pen_triangle room;
    const uint32_t prim = some_primitive(r);
    const struct pen_kind_functions *fn = pen_prim_row(&world.prims, prim)->fn;
    const void *self = pen_prim_self(&world.prims, prim, &room);
    const bool capped = world.ref[prim].kind == PEN_PRIM_CYLINDER;
    const uint8_t part = (uint8_t)(capped ? random_below(r, 3) : PEN_PART_SIDE);
    struct lanes_hits at;
    vec3 from[MAX];
    for (int i = 0; i < MAX; i++)
        at.p[i] = from[i] = some_point(r, fn, self, part);
    if (world.ref[prim].kind == PEN_PRIM_CYLINDER && random_below(r, 16) == 0)
        at.p[0] = from[0] = world.cylinder[0].round.q; /* on the axis, where there is no normal */
    if (!test->surface(&world.prims, (struct pen_hit){1, prim, part}, &at))
        return false;
    for (int i = 0; i < test->lanes; i++) {
        const vec3 want = fn->project(self, part, from[i]);
        const struct pen_hit hit = {1, prim, part};
        ck_assert_msg(same(at.p[i], want) && same(at.n[i], fn->normal(self, part, want)) &&
                          at.scale[i] == pen_prim_scale(&world.prims, prim, want) &&
                          at.curvature[i] == pen_prim_curvature(&world.prims, hit, want),
                      "kind %u, lane %d of %d: point %a %a %a", world.ref[prim].kind, i,
                      test->lanes, from[i].x, from[i].y, from[i].z);
    }
    return true;
}

START_TEST(test_surface_lanes__are_single_points)
{
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++) {
        const struct lanes_test *test = lanes_test_of((enum pen_isa)isa);
        const int cases = random_cases(test ? 40000 : 0);
        struct random r = random_begin(5);
        int in_lanes = 0;
        if (!test)
            printf("not on this processor: %s\n", pen_isa_name((enum pen_isa)isa));
        for (int n = 0; n < cases; n++)
            in_lanes += compare(test, &r);
        ck_assert_int_ge(in_lanes, cases / 2);
        ck_assert(!test || in_lanes < cases);
    }
}
END_TEST

/* Zero, or any size down to what rounding leaves. */
static double some_length(struct random *r)
{
    return random_below(r, 3) ? exp2(random_in(r, -60, 2)) : 0;
}

/* What a ray started on; often one that has hardly moved. */
static struct pen_origin_surface some_origin(struct random *r)
{
    struct pen_origin_surface left = pen_origin_none;
    if (random_below(r, 4) == 0)
        return left;
    left.prim = 0;
    left.toward = pen_scale(random_direction(r), some_length(r));
    left.before = pen_scale(random_direction(r), some_length(r));
    left.bound = some_length(r);
    left.toward_bound = some_length(r);
    left.before_bound = some_length(r);
    return left;
}

/* t of a hit: in front, a layer, at the ray's start, or about as far as rounding reaches. */
static double some_t(struct random *r, const struct pen_ray *ray, double bound)
{
    static const double at[] = {PEN_FIRST_T, PEN_LAST_LAYER_T, 2 * PEN_LAST_LAYER_T, 0};
    switch (random_below(r, 3)) {
    case 0:
        return random_in(r, 0, 2);
    case 1:
        return at[random_below(r, 4)];
    default:
        return random_in(r, 0.5, 2) * PEN_NEARBY * bound * sqrt(ray->inv_dd);
    }
}

static void compare_origins(const struct lanes_test *test, struct random *r)
{
    const uint32_t prim = some_primitive(r);
    struct pen_ray ray[MAX];
    struct pen_origin_surface left[MAX], out[MAX];
    double t[MAX], scale[MAX];
    vec3 p[MAX];
    for (int i = 0; i < MAX; i++) {
        ray[i] = world_ray(random_vec(r, 1), pen_scale(random_direction(r), random_in(r, 0.1, 10)));
        left[i] = some_origin(r);
        t[i] = some_t(r, &ray[i], left[i].bound);
        p[i] = pen_along(ray[i].o, ray[i].d, t[i]);
        scale[i] = pen_prim_scale(&world.prims, prim, p[i]);
    }
    test->origins(ray, t, left, p, scale, out);
    for (int i = 0; i < test->lanes; i++) {
        const struct pen_hit hit = {t[i], prim, PEN_PART_SIDE};
        const struct pen_origin_surface want =
            pen_origin_at(&world.prims, &ray[i], &left[i], hit, p[i]);
        ck_assert_msg(out[i].prim == want.prim && out[i].part == want.part && !out[i].through &&
                          same(out[i].toward, want.toward) && same(out[i].before, want.before) &&
                          out[i].bound == want.bound && out[i].toward_bound == want.toward_bound &&
                          out[i].before_bound == want.before_bound,
                      "lane %d of %d: t %a bound %a, alone %a", i, test->lanes, t[i], out[i].bound,
                      want.bound);
    }
}

START_TEST(test_surface_lanes__give_the_origins_of_single_points)
{
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++) {
        const struct lanes_test *test = lanes_test_of((enum pen_isa)isa);
        const int cases = random_cases(test ? 20000 : 0);
        struct random r = random_begin(6);
        for (int n = 0; n < cases; n++)
            compare_origins(test, &r);
    }
}
END_TEST

PEN_SUITE("surface_lanes", test_surface_lanes__are_single_points,
          test_surface_lanes__give_the_origins_of_single_points)
