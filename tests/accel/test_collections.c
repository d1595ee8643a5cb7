/* SPDX-License-Identifier: MIT */
/* Boundary cases of several primitives: how many intersections a ray has with them, in which order,
 * and which is the nearest. By every accelerator and compiled variant. */
#include "support/isa.h"
#include "support/suite.h"
#include "support/world.h"

typedef struct pen_vec3 vec3;

enum { MOST = 8 };

static struct world world;

static struct pen_arena *arena;
static const struct pen_accel *accel[PEN_ACCEL_COUNT];

static void build(void)
{
    struct pen_status st;
    arena = pen_arena_new(0);
    for (int kind = 0; kind < PEN_ACCEL_COUNT; kind++) {
        accel[kind] = pen_accel_build(&world.prims, (enum pen_accelerator)kind, arena, &st);
        ck_assert(accel[kind]);
    }
}

/* The intersections from o along z, walked from one to the next. */
static int walk(int way, vec3 o, vec3 d, struct pen_hit hit[MOST])
{
    const struct pen_trace_ops *ops = pen_trace_ops_get((enum pen_isa)(way / PEN_ACCEL_COUNT));
    struct pen_ray ray = world_ray(o, d);
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    int count = 0;
    while (count < MOST && ops->nearest(accel[way % PEN_ACCEL_COUNT], &ray, &pen_origin_none,
                                        &interval, &interval.after))
        hit[count++] = interval.after;
    return count;
}

struct wanted_hit {
    double t;
    uint32_t prim;
};

static void assert_intersections(vec3 o, vec3 d, const struct wanted_hit *want, int wanted)
{
    for (int way = 0; way < PEN_ACCEL_COUNT * isa_count(); way++) {
        struct pen_hit hit[MOST];
        int count = walk(way, o, d, hit);
        ck_assert_msg(count == wanted, "way %d: %d hits, not %d", way, count, wanted);
        for (int i = 0; i < count; i++)
            ck_assert_msg(hit[i].t == want[i].t && hit[i].prim == want[i].prim,
                          "way %d, hit %d: %a of %u", way, i, hit[i].t, hit[i].prim);
    }
}

/* A plane at plane_z, a sphere from z = 1 to 3 and a triangle at z = 4, across a ray along +z. */
static void three_primitives(double plane_z)
{
    world_clear(&world);
    world_plane(&world, pen_vec3(0, 0, plane_z), pen_vec3(0, 0, 1));
    world_sphere(&world, pen_vec3(0, 0, 2), 1);
    world_triangle(&world, pen_vec3(0, .5, 4), pen_vec3(.5, -.5, 4), pen_vec3(-.5, -.5, 4));
    build();
}

START_TEST(test_collections__h033_intersections_of_several_primitives)
{
    const vec3 up = {0, 0, 1}, beside = {5, 5, 0}, rim = {0, .6, 0}, through = {0, 0, 0};
    const struct wanted_hit one[] = {{.5, 0}}, three[] = {{.5, 0}, {1.2, 1}, {2.8, 1}},
                            four[] = {{.5, 0}, {1, 1}, {3, 1}, {4, 2}};
    world_clear(&world);
    build();
    assert_intersections(through, up, NULL, 0);
    pen_arena_free(arena);
    three_primitives(.5);
    assert_intersections(through, pen_vec3(1, 0, 0), NULL, 0);
    assert_intersections(beside, up, one, 1);
    assert_intersections(rim, up, three, 3);
    assert_intersections(through, up, four, 4);
    pen_arena_free(arena);
}
END_TEST

/* Equal t: in document order. */
START_TEST(test_collections__h033_equal_distances)
{
    const struct wanted_hit near[] = {{1, 0}, {1, 1}, {3, 1}, {4, 2}},
                            far[] = {{1, 1}, {3, 0}, {3, 1}, {4, 2}};
    for (int i = 0; i < 2; i++) {
        three_primitives(i ? 3 : 1);
        assert_intersections(pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), i ? far : near, 4);
        pen_arena_free(arena);
    }
}
END_TEST

START_TEST(test_collections__h034_nearest_wherever_it_is_in_the_document)
{
    static const int order[6][3] = {{1, 2, 3}, {1, 3, 2}, {2, 1, 3},
                                    {2, 3, 1}, {3, 1, 2}, {3, 2, 1}};
    for (int i = 0; i < 6; i++) {
        struct wanted_hit want[3];
        world_clear(&world);
        for (uint32_t k = 0; k < 3; k++) {
            world_triangle(&world, pen_vec3(0, 1, order[i][k]), pen_vec3(1, -1, order[i][k]),
                           pen_vec3(-1, -1, order[i][k]));
            want[order[i][k] - 1] = (struct wanted_hit){order[i][k], k};
        }
        build();
        assert_intersections(pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), want, 3);
        assert_intersections(pen_vec3(0, 0, 0), pen_vec3(0, 0, -1), NULL, 0);
        pen_arena_free(arena);
    }
}
END_TEST

PEN_SUITE("collections", test_collections__h033_intersections_of_several_primitives,
          test_collections__h033_equal_distances,
          test_collections__h034_nearest_wherever_it_is_in_the_document)
