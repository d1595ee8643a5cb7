/* SPDX-License-Identifier: MIT */
/* Each kind of accelerator from outside: its counts, its depth, and, for simple scenes, the boxes
 * and primitives against which a ray is tested. */
#include "support/suite.h"
#include "support/world.h"

typedef struct pen_vec3 vec3;

static struct world world;
static struct pen_arena *arena;

static void setup(void)
{
    arena = pen_arena_new(0);
    world_clear(&world);
}

static void teardown(void)
{
    pen_arena_free(arena);
}

static const struct pen_accel *build(enum pen_accelerator kind)
{
    struct pen_status st;
    struct pen_accel *accel = pen_accel_build(&world.prims, kind, arena, &st);
    ck_assert(accel);
    return accel;
}

static const struct pen_accel *build_groups(const struct pen_group_range *interval, uint32_t count)
{
    struct pen_status st;
    struct pen_groups groups = {interval, count};
    struct pen_accel *accel = pen_accel_build_manual(&world.prims, &groups, arena, &st);
    ck_assert(accel);
    return accel;
}

static void check_stats(const struct pen_accel *accel, uint32_t nodes, uint32_t leaves,
                        uint32_t depth)
{
    const struct pen_accel_stats *s = pen_accel_get_stats(accel);
    ck_assert_uint_eq(s->nodes, nodes);
    ck_assert_uint_eq(s->leaves, leaves);
    ck_assert_uint_eq(s->depth, depth);
    ck_assert(s->bytes > 0 && s->build_ms >= 0);
}

/* Counts the tests of one ray; *hit is what it meets. */
static struct pen_test_counts tests(const struct pen_accel *accel, vec3 o, vec3 d, uint32_t *hit)
{
    struct pen_test_counts counts = {0};
    struct pen_accel *view = pen_accel_count_new(accel, &counts);
    struct pen_ray ray = world_ray(o, d);
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_hit h = {0, PEN_NO_PRIM, 0};
    pen_trace_count_ops_get(pen_cpu_isa())->nearest(view, &ray, &pen_origin_none, &interval, &h);
    pen_accel_count_free(view);
    *hit = h.prim;
    return counts;
}

static void check_tests(const struct pen_accel *accel, vec3 o, vec3 d, uint32_t hit, uint64_t boxes,
                        uint64_t primitives)
{
    uint32_t found;
    struct pen_test_counts counts = tests(accel, o, d, &found);
    ck_assert_uint_eq(found, hit);
    ck_assert_uint_eq(counts.boxes, boxes);
    ck_assert_uint_eq(counts.primitives, primitives);
}

/* Spheres in a row along an axis, of radius 1/4 at 0, 1, 2 …; `step` sets the order in which they
 * are numbered: sphere i is at place i * step mod count. */
static void row(int axis, uint32_t count, uint32_t step)
{
    for (uint32_t i = 0; i < count; i++) {
        double x = (double)(i * step % count);
        world_sphere(&world, pen_vec3(axis == 0 ? x : 0, axis == 1 ? x : 0, axis == 2 ? x : 0),
                     .25);
    }
}

START_TEST(test_kinds__cbr_tests_every_box_and_what_is_in_those_met)
{
    enum { N = 29 };
    row(0, N, 1);
    world_plane(&world, pen_vec3(0, 0, -2), pen_vec3(0, 0, 1)); /* beside the list */
    const struct pen_accel *accel = build(PEN_ACCEL_CBR);
    check_stats(accel, 1, N, 1);
    check_tests(accel, pen_vec3(7, 0, 5), pen_vec3(0, 0, -1), 7, N, 1 + 1);
    check_tests(accel, pen_vec3(7.5, 0, 5), pen_vec3(0, 0, -1), N, N, 1);
    /* Along the row the first sphere of the document puts the others out of reach. */
    check_tests(accel, pen_vec3(-5, 0, 0), pen_vec3(1, 0, 0), 0, N, 1 + 1);
    /* From the other end each is nearer than those before it. */
    check_tests(accel, pen_vec3(99, 0, 0), pen_vec3(-1, 0, 0), N - 1, N, N + 1);
}
END_TEST

START_TEST(test_kinds__manual_without_groups_is_cbr)
{
    struct random r = random_begin(41);
    world_random(&world, &r, 100, .3);
    const struct pen_accel *cbr = build(PEN_ACCEL_CBR);
    const struct pen_accel *manual[] = {build(PEN_ACCEL_MANUAL), build_groups(NULL, 0)};
    for (int i = 0; i < 2; i++) {
        const struct pen_accel_stats *a = pen_accel_get_stats(cbr);
        const struct pen_accel_stats *b = pen_accel_get_stats(manual[i]);
        ck_assert(a->kind == PEN_ACCEL_CBR && b->kind == PEN_ACCEL_MANUAL);
        check_stats(manual[i], a->nodes, a->leaves, a->depth);
        ck_assert(a->bytes == b->bytes && a->sah_cost == b->sah_cost);
        for (int k = 0; k < 100; k++) {
            vec3 o = random_vec(&r, 2), d = random_direction(&r);
            uint32_t hit;
            struct pen_test_counts counts = tests(cbr, o, d, &hit);
            check_tests(manual[i], o, d, hit, counts.boxes, counts.primitives);
        }
    }
}
END_TEST

/* Four rows of sixteen, each row a group, and the first two rows one more around theirs. */
START_TEST(test_kinds__manual_looks_into_the_groups_it_meets)
{
    for (int i = 0; i < 64; i++)
        world_sphere(&world, pen_vec3(i & 15, 10 * (i >> 4), 0), .25);
    const struct pen_group_range interval[] = {{0, 32}, {0, 16}, {16, 32}, {32, 48}, {48, 64}};
    const struct pen_accel *accel = build_groups(interval, 5);
    check_stats(accel, 6, 64, 3);
    vec3 down = pen_vec3(0, 0, -1);
    check_tests(accel, pen_vec3(5, 5, 9), down, PEN_NO_PRIM, 3 + 2, 0); /* between two rows */
    check_tests(accel, pen_vec3(5, 0, 9), down, 5, 3 + 2 + 16, 1);
    check_tests(accel, pen_vec3(5, 30, 9), down, 48 + 5, 3 + 16, 1);
    check_tests(accel, pen_vec3(5, 15, 9), down, PEN_NO_PRIM, 3, 0);
    /* Groups are visited in the order of the document: from above, the nearest is the last. */
    check_tests(accel, pen_vec3(0, 99, 0), pen_vec3(0, -1, 0), 48, 3 + 2 + 4 * 16, 4);
    check_tests(accel, pen_vec3(0, -9, 0), pen_vec3(0, 1, 0), 0, 3 + 2 + 16, 1);
}
END_TEST

START_TEST(test_kinds__groups_of_nothing_and_of_infinite_primitives_have_no_box)
{
    row(0, 3, 1);
    world_plane(&world, pen_vec3(0, -1, 0), pen_vec3(0, 1, 0));
    world_infinite_cylinder(&world, pen_vec3(0, 9, 0), pen_vec3(0, 0, 1), .1);
    world_sphere(&world, pen_vec3(8, 0, 0), 1);
    const struct pen_group_range interval[] = {{0, 0}, {1, 5}, {1, 1}, {3, 5}, {3, 4}, {6, 6}};
    check_stats(build_groups(interval, 6), 2, 4, 2);
    const struct pen_group_range infinite[] = {{3, 5}};
    check_stats(build_groups(infinite, 1), 1, 4, 1);
}
END_TEST

/* A document may nest deeper than a walk's stack. */
START_TEST(test_kinds__groups_nested_without_end)
{
    enum { DEEP = 1000, N = 20 };
    static struct pen_group_range interval[DEEP];
    row(0, N, 7);
    for (uint32_t i = 0; i < DEEP; i++)
        interval[i] = (struct pen_group_range){i < N ? i : N - 1, N};
    const struct pen_accel *accel = build_groups(interval, DEEP);
    ck_assert_uint_eq(pen_accel_get_stats(accel)->depth, 64);
    ck_assert_uint_eq(pen_accel_get_stats(accel)->leaves, N);
    for (uint32_t i = 0; i < N; i++) {
        uint32_t hit;
        tests(accel, pen_vec3(i * 7 % N, 0, 5), pen_vec3(0, 0, -1), &hit);
        ck_assert_uint_eq(hit, i);
    }
}
END_TEST

/* The depth and the leaves of a balanced tree with leaves of at most `most`. */
static uint32_t halvings(uint32_t count, uint32_t most, uint32_t *leaves)
{
    if (count <= most) {
        ++*leaves;
        return 0;
    }
    uint32_t a = halvings(count / 2, most, leaves), b = halvings(count - count / 2, most, leaves);
    return 1 + (a > b ? a : b);
}

START_TEST(test_kinds__median_is_balanced_for_any_number)
{
    for (uint32_t n = 1; n <= 300; n += n < 70 ? 1 : 23) {
        for (int what = 0; what < 3; what++) {
            uint32_t leaves = 0, depth = halvings(n, what == 2 ? 4 : 1, &leaves);
            world_clear(&world);
            for (uint32_t i = 0; i < n && what == 1; i++)
                world_sphere(&world, pen_vec3(1, 2, 3), 1 + i);
            for (uint32_t i = 0; i < n && what == 2; i++)
                world_triangle(&world, pen_vec3(i, 0, 0), pen_vec3(i, 1, 0), pen_vec3(i, 0, 1));
            if (what == 0)
                row(2, n, 1);
            check_stats(build(PEN_ACCEL_MEDIAN), leaves > 1 ? leaves - 1 : 1, leaves,
                        depth ? depth : 1);
        }
    }
}
END_TEST

/* A ray across a row of 64 spheres in any order takes one path down: two boxes at each of six
 * levels, and one sphere. */
START_TEST(test_kinds__median_cuts_the_longest_axis_in_the_middle)
{
    for (int axis = 0; axis < 3; axis++) {
        world_clear(&world);
        row(axis, 64, 27);
        const struct pen_accel *accel = build(PEN_ACCEL_MEDIAN);
        check_stats(accel, 63, 64, 6);
        for (uint32_t i = 0; i < 64; i++) {
            double x = i * 27 % 64;
            vec3 o = pen_vec3(axis == 0 ? x : 5, axis == 1 ? x : 5, axis == 2 ? x : 5);
            vec3 d = pen_vec3(axis == 0 ? 0 : -1, axis == 1 ? 0 : -1, axis == 2 ? 0 : -1);
            check_tests(accel, o, d, i, 2 * 6, 1);
        }
        /* Along the row, from either end, the nearer half comes first, and no other is met. */
        vec3 far = pen_vec3(axis == 0 ? 99 : 0, axis == 1 ? 99 : 0, axis == 2 ? 99 : 0);
        check_tests(accel, far, pen_neg(far), 45, 2 * 6, 1); /* 45 * 27 = 63 mod 64 */
        check_tests(accel, pen_neg(far), far, 0, 2 * 6, 1);
    }
}
END_TEST

START_TEST(test_kinds__median_of_a_square_cuts_the_axes_in_turn)
{
    for (int i = 0; i < 256; i++)
        world_sphere(&world, pen_vec3(i & 15, 0, 1.01 * (i >> 4)), .25);
    const struct pen_accel *accel = build(PEN_ACCEL_MEDIAN);
    check_stats(accel, 255, 256, 8);
    for (int i = 0; i < 256; i++)
        check_tests(accel, pen_vec3(i & 15, 9, 1.01 * (i >> 4)), pen_vec3(0, -1, 0), (uint32_t)i,
                    2 * 8, 1);
}
END_TEST

static void check_cost(enum pen_accelerator kind, double cost)
{
    double found = pen_accel_get_stats(build(kind))->sah_cost;
    ck_assert_msg(fabs(found - cost) < 1e-6 * cost, "accelerator %d: %.9g, not %.9g", (int)kind,
                  found, cost);
}

/* Three cubes of edge 1 (six squares each) with gaps of 1 in a row: areas by hand. Half the area of
 * the whole, 5 by 1 by 1, is 11, of a square (without thickness) 1. */
START_TEST(test_kinds__cost_is_that_of_its_definition)
{
    for (int i = 0; i < 3; i++)
        world_box(&world, pen_vec3(2 * i, 0, 0), pen_vec3(2 * i + 1, 1, 1));
    world_plane(&world, pen_vec3(0, -1, 0), pen_vec3(0, 1, 0));
    check_cost(PEN_ACCEL_NONE, 19);
    check_cost(PEN_ACCEL_CBR, 1 + .15 * 18 + 18 / 11.);
    const struct pen_group_range interval[] = {{0, 6}, {6, 12}, {12, 18}};
    double manual = pen_accel_get_stats(build_groups(interval, 3))->sah_cost;
    double want = 1 + .15 * 3 + 3 * (3 / 11.) * .15 * 6 + 18 / 11.;
    ck_assert_msg(fabs(manual - want) < 1e-6 * want, "%.9g, not %.9g", manual, want);
}
END_TEST

/* A triangle across another: one leaf, and one box, which all rays enter; two spheres: two boxes,
 * each with a surface of 2 * 3 * .25 where the whole has 2 * (.25 + 2 * .75). */
START_TEST(test_kinds__cost_of_a_tree_of_two)
{
    world_triangle(&world, pen_vec3(0, 0, 0), pen_vec3(1, 0, 0), pen_vec3(0, 1, 0));
    world_triangle(&world, pen_vec3(0, 0, 1), pen_vec3(1, 0, -1), pen_vec3(0, 1, 0));
    check_cost(PEN_ACCEL_MEDIAN, .15 + 2);
    world_clear(&world);
    row(1, 2, 1);
    check_cost(PEN_ACCEL_MEDIAN, 2 * .15 + 2 * .75 / 1.75);
    world_clear(&world);
    ck_assert(pen_accel_get_stats(build(PEN_ACCEL_MEDIAN))->sah_cost == 0);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("kinds");
    TCase *tcase = tcase_create("kinds");
    tcase_add_checked_fixture(tcase, setup, teardown);
    tcase_add_test(tcase, test_kinds__cbr_tests_every_box_and_what_is_in_those_met);
    tcase_add_test(tcase, test_kinds__manual_without_groups_is_cbr);
    tcase_add_test(tcase, test_kinds__manual_looks_into_the_groups_it_meets);
    tcase_add_test(tcase, test_kinds__groups_of_nothing_and_of_infinite_primitives_have_no_box);
    tcase_add_test(tcase, test_kinds__groups_nested_without_end);
    tcase_add_test(tcase, test_kinds__median_is_balanced_for_any_number);
    tcase_add_test(tcase, test_kinds__median_cuts_the_longest_axis_in_the_middle);
    tcase_add_test(tcase, test_kinds__median_of_a_square_cuts_the_axes_in_turn);
    tcase_add_test(tcase, test_kinds__cost_is_that_of_its_definition);
    tcase_add_test(tcase, test_kinds__cost_of_a_tree_of_two);
    suite_add_tcase(suite, tcase);
    SRunner *runner = srunner_create(suite);
    srunner_run_all(runner, CK_NORMAL);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed != 0;
}
