/* SPDX-License-Identifier: MIT */
/* The choices of `auto`, and the cost model behind them, which is a pure function of the
 * primitives. */
#include "accel/internal/test_doors.h"
#include "accel/internal/tree_layout.h"
#include "support/suite.h"
#include "support/world.h"

typedef struct pen_vec3 vec3;

static struct world world, permuted;

static struct pen_accel_stats stats_of(const struct world *w)
{
    struct pen_status st;
    struct pen_arena *arena = pen_arena_new(0);
    const struct pen_accel *accel = pen_accel_build(&w->prims, PEN_ACCEL_AUTO, arena, &st);
    ck_assert(accel);
    const struct pen_accel_stats stats = *pen_accel_get_stats(accel);
    pen_arena_free(arena);
    return stats;
}

static void add_floor(void)
{
    const vec3 v[4] = {{-3, -1, -3}, {-3, -1, 3}, {3, -1, 3}, {3, -1, -3}};
    world_polygon(&world, v, 4);
}

static void add_tubes(int count)
{
    for (int i = 0; i < count; i++)
        world_infinite_cylinder(&world, pen_vec3(i, 0, 0), pen_vec3(0, 1, .1 * i), .1);
}

static void add_spheres(int count)
{
    for (int i = 0; i < count; i++)
        world_sphere(&world, pen_vec3(i % 10, i / 10 % 10, i / 100), .3);
}

static void check_choice(enum pen_auto_choice choice, bool tree)
{
    const struct pen_accel_stats s = stats_of(&world);
    ck_assert_str_eq(pen_auto_choice_name(s.choice), pen_auto_choice_name(choice));
    ck_assert((s.nodes > 0) == tree);
    for (int i = 0; i < PEN_AUTO_COUNT; i++)
        ck_assert(!(s.expected[i] < s.expected[choice]));
}

/* A packet tests infinite cylinders against every ray, and gains nothing by it: a few of them and
 * hardly anything else is a list. With many others beside them it is a tree, ray by ray. */
START_TEST(test_auto_choice__depends_on_what_packets_gain)
{
    world_clear(&world);
    add_floor();
    check_choice(PEN_AUTO_PACKETS, true);
    add_spheres(8);
    check_choice(PEN_AUTO_PACKETS, true);
    add_spheres(1000);
    check_choice(PEN_AUTO_PACKETS, true);
    world_clear(&world);
    add_floor();
    add_tubes(8);
    check_choice(PEN_AUTO_NONE, false);
    add_spheres(200);
    check_choice(PEN_AUTO_TREE, true);
    world_clear(&world);
    add_tubes(1);
    add_spheres(8);
    check_choice(PEN_AUTO_PACKETS, true);
}
END_TEST

/* Cones have no test in lanes. A few of them among others spoil few packets; many spoil all. */
START_TEST(test_auto_choice__primitives_without_a_test_in_lanes)
{
    const double radius[2] = {.3, 0};
    world_clear(&world);
    add_spheres(100);
    world_cone(&world, pen_vec3(5, 5, 1), pen_vec3(0, 1, 0), radius, .3, true);
    check_choice(PEN_AUTO_PACKETS, true);
    world_clear(&world);
    for (int i = 0; i < 500; i++)
        world_cone(&world, pen_vec3(i % 10, i / 10 % 10, i / 100), pen_vec3(0, 1, 0), radius, .9,
                   true);
    check_choice(PEN_AUTO_TREE, true);
}
END_TEST

START_TEST(test_auto_choice__without_finite_primitives_there_is_no_tree)
{
    world_clear(&world);
    check_choice(PEN_AUTO_NONE, false);
    for (int i = 0; i < 5; i++)
        world_plane(&world, pen_vec3(0, -i, 0), pen_vec3(0, 1, 0));
    check_choice(PEN_AUTO_NONE, false);
    ck_assert(isinf(stats_of(&world).expected[PEN_AUTO_TREE]));
    ck_assert(isinf(stats_of(&world).expected[PEN_AUTO_PACKETS]));
}
END_TEST

START_TEST(test_auto_choice__is_the_first_of_the_least)
{
    ck_assert_int_eq(pen_auto_choose((const double[]){1, 2, 3}), PEN_AUTO_NONE);
    ck_assert_int_eq(pen_auto_choose((const double[]){2, 1, 3}), PEN_AUTO_TREE);
    ck_assert_int_eq(pen_auto_choose((const double[]){3, 2, 1}), PEN_AUTO_PACKETS);
    ck_assert_int_eq(pen_auto_choose((const double[]){1, 1, 1}), PEN_AUTO_NONE);
    ck_assert_int_eq(pen_auto_choose((const double[]){2, 1, 1}), PEN_AUTO_TREE);
    ck_assert_int_eq(pen_auto_choose((const double[]){1, INFINITY, INFINITY}), PEN_AUTO_NONE);
}
END_TEST

/* One more infinite primitive makes every choice dearer, infinite cylinders packets most. Four more
 * spheres make a list dearer by one block, and trees by less. */
START_TEST(test_auto_choice__costs_grow_with_primitives)
{
    world_clear(&world);
    add_spheres(100);
    struct pen_accel_stats before = stats_of(&world);
    for (int i = 0; i < 20; i++) {
        if (i & 1)
            add_tubes(1);
        else
            for (int k = 0; k < PEN_LANES; k++)
                world_plane(&world, pen_vec3(0, -i, 0), pen_vec3(0, 1, 0));
        const struct pen_accel_stats after = stats_of(&world);
        double more[PEN_AUTO_COUNT];
        for (int c = 0; c < PEN_AUTO_COUNT; c++) {
            more[c] = after.expected[c] - before.expected[c];
            ck_assert(more[c] > 0);
        }
        ck_assert(fabs(more[PEN_AUTO_TREE] - more[PEN_AUTO_NONE]) < 1e-9);
        ck_assert(more[PEN_AUTO_PACKETS] > more[PEN_AUTO_TREE]);
        before = after;
    }
    for (int i = 0; i < 20; i++) {
        for (int k = 0; k < PEN_LANES; k++)
            world_sphere(&world, pen_vec3(.5 * i, 5, 2 * k), .3);
        const struct pen_accel_stats after = stats_of(&world);
        const double more = after.expected[PEN_AUTO_NONE] - before.expected[PEN_AUTO_NONE];
        ck_assert(fabs(more - (double)pen_kinds[PEN_PRIM_SPHERE].cost) < 1e-9);
        ck_assert(after.expected[PEN_AUTO_TREE] < before.expected[PEN_AUTO_TREE] + more);
        before = after;
    }
}
END_TEST

/* The same primitives in reverse order. */
static void reverse(void)
{
    permuted = world;
    permuted.prims.ref = permuted.ref;
    for (uint32_t i = 0; i < world.prims.count; i++)
        permuted.ref[i] = world.ref[world.prims.count - 1 - i];
}

/* Equal in every bit for the same document. For a permuted one sums have another order, and where
 * primitives have one centre the builder splits them by their numbers, so the costs are about the
 * same, and the choice is, wherever two do not cost about the same. */
START_TEST(test_auto_choice__is_a_function_of_the_primitives)
{
    struct random r = random_begin(401);
    for (int i = 0; i < random_cases(200); i++) {
        world_clear(&world);
        world_random(&world, &r, 1 + random_below(&r, 100), random_in(&r, .02, 1));
        const struct pen_accel_stats a = stats_of(&world), b = stats_of(&world);
        ck_assert(a.choice == b.choice);
        reverse();
        const struct pen_accel_stats c = stats_of(&permuted);
        bool close = false;
        for (int k = 0; k < PEN_AUTO_COUNT; k++) {
            ck_assert(a.expected[k] == b.expected[k]);
            ck_assert(a.expected[k] == c.expected[k] ||
                      fabs(a.expected[k] - c.expected[k]) < 1e-6 * a.expected[k]);
            close = close || (k != (int)a.choice &&
                              a.expected[k] - a.expected[a.choice] < 1e-5 * a.expected[k]);
        }
        ck_assert(a.choice == c.choice || close);
    }
}
END_TEST

/* A choice that is made for it is what a builder makes. */
START_TEST(test_auto_choice__can_be_forced)
{
    struct pen_status st;
    struct pen_arena *arena = pen_arena_new(0);
    world_clear(&world);
    add_spheres(100);
    for (int i = 0; i < PEN_AUTO_COUNT; i++) {
        const struct pen_accel *accel =
            pen_accel_build_choice(&world.prims, (enum pen_auto_choice)i, arena, &st);
        ck_assert(accel);
        ck_assert(accel->shape == (i == PEN_AUTO_NONE ? PEN_SHAPE_NONE : PEN_SHAPE_WIDE));
        ck_assert(accel->packets == (i == PEN_AUTO_PACKETS));
        ck_assert_int_eq(pen_accel_get_stats(accel)->choice, i);
        ck_assert_int_eq(pen_accel_get_stats(accel)->kind, PEN_ACCEL_AUTO);
    }
    const struct pen_accel *none = pen_accel_build(&world.prims, PEN_ACCEL_NONE, arena, &st);
    ck_assert(!none->packets);
    pen_arena_free(arena);
}
END_TEST

PEN_SUITE("auto_choice", test_auto_choice__depends_on_what_packets_gain,
          test_auto_choice__primitives_without_a_test_in_lanes,
          test_auto_choice__without_finite_primitives_there_is_no_tree,
          test_auto_choice__is_the_first_of_the_least, test_auto_choice__costs_grow_with_primitives,
          test_auto_choice__is_a_function_of_the_primitives, test_auto_choice__can_be_forced)
