/* SPDX-License-Identifier: MIT */
/* Shadow queries: which surfaces count, and the results for transmissive ones. */
#include "support/isa.h"
#include "support/suite.h"
#include "support/world.h"

typedef struct pen_vec3 vec3;

static struct world world;
static uint8_t clear[WORLD_MAX];

/* Traces one shadow ray with every accelerator and instruction set, which must all agree. *query
 * holds the results of the last. */
static bool occluded(vec3 o, vec3 d, const struct pen_origin_surface *origin,
                     struct pen_shadow *query)
{
    static const enum pen_accelerator kinds[] = {PEN_ACCEL_NONE, PEN_ACCEL_AUTO};
    struct pen_ray ray = world_ray(o, d);
    struct pen_shadow fresh = *query, first = fresh;
    bool answer = false;
    for (int i = 0; i < 2 * isa_count(); i++) {
        struct pen_status st;
        struct pen_arena *arena = pen_arena_new(0);
        const struct pen_accel *accel = pen_accel_build(&world.prims, kinds[i & 1], arena, &st);
        const struct pen_trace_ops *ops = pen_trace_ops_get((enum pen_isa)(i / 2));
        *query = fresh;
        bool blocked = ops->shadow(accel, &ray, origin, query);
        if (i == 0) {
            answer = blocked;
            first = *query;
        }
        ck_assert(blocked == answer);
        if (!blocked) {
            ck_assert(query->overflow == first.overflow);
            ck_assert(query->overflow || query->count == first.count);
            for (int k = 0; !query->overflow && k < query->count; k++)
                ck_assert(query->hit[k].t == first.hit[k].t &&
                          query->hit[k].prim == first.hit[k].prim);
        }
        pen_arena_free(arena);
    }
    return answer;
}

static bool shaded(vec3 o, vec3 light)
{
    struct pen_shadow query = {.tmax = 1, .to_point = true, .last_occluder = PEN_NO_PRIM};
    return occluded(o, pen_sub(light, o), &pen_origin_none, &query);
}

static void sheet(double z)
{
    const vec3 v[4] = {{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}};
    world_polygon(&world, v, 4);
}

START_TEST(test_shadow__the_interval_is_open)
{
    struct pen_shadow query = {.tmax = 2, .last_occluder = PEN_NO_PRIM};
    world_clear(&world);
    sheet(2);
    vec3 o = pen_vec3(.1, .2, 0), up = pen_vec3(0, 0, 1);
    ck_assert(!occluded(o, up, &pen_origin_none, &query));
    query.tmax = nextafter(2, 3);
    ck_assert(occluded(o, up, &pen_origin_none, &query));
    ck_assert_uint_eq(query.last_occluder, 0);
    query.tmax = INFINITY;
    ck_assert(occluded(o, up, &pen_origin_none, &query));
    ck_assert(!occluded(pen_vec3(.1, .2, 2), up, &pen_origin_none, &query));
}
END_TEST

/* Rays from free space that start exactly on a primitive and go away from it: t = 0 is no
 * intersection.
 */
START_TEST(test_shadow__a_ray_does_not_cross_where_it_starts)
{
    struct pen_shadow query = {.tmax = 2, .last_occluder = PEN_NO_PRIM};
    for (int kind = 0; kind < 4; kind++) {
        world_clear(&world);
        if (kind == 0)
            world_sphere(&world, pen_vec3(0, 0, -1), 1);
        else if (kind == 1)
            world_plane(&world, pen_vec3(5, 5, 0), pen_vec3(0, 0, 1));
        else if (kind == 2)
            world_infinite_cylinder(&world, pen_vec3(0, 0, -1), pen_vec3(1, 0, 0), 1);
        else
            world_cylinder(&world, pen_vec3(0, 0, -1), pen_vec3(0, 0, 1), 1, 1, true);
        ck_assert_msg(!occluded(pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), &pen_origin_none, &query),
                      "kind %d", kind);
    }
}
END_TEST

/* A surface that contains the light does not count, however it is rounded; one before it does. */
START_TEST(test_shadow__light_on_a_surface)
{
    struct random r = random_begin(117);
    for (int i = 0; i < 4000; i++) {
        vec3 c = random_vec(&r, 1), a = random_direction(&r), flat[4];
        vec3 e = pen_normalize(pen_cross(a, random_direction(&r))), w = pen_cross(a, e);
        vec3 light = pen_along(pen_along(c, e, random_in(&r, -.4, .4)), w, random_in(&r, -.4, .4));
        world_clear(&world);
        for (int k = 0; k < 4; k++)
            flat[k] = pen_along(pen_along(c, e, k == 1 || k == 2 ? .5 : -.5), w, k > 1 ? .5 : -.5);
        switch (i % 5) {
        case 0:
            world_polygon(&world, flat, 4);
            break;
        case 1:
            world_plane(&world, c, a);
            break;
        case 2:
            world_sphere(&world, c, .5);
            light = pen_along(c, random_direction(&r), .5);
            break;
        case 3:
            world_cylinder(&world, c, a, .5, 1, true);
            light = pen_along(pen_along(c, e, .5), a, .5);
            break;
        default:
            world_cylinder(&world, c, a, 1, 1, true); /* on the base */
        }
        vec3 o = pen_along(random_vec(&r, 1), a, -3);
        struct pen_ray ray = world_ray(o, pen_sub(light, o));
        struct pen_hit hit[3];
        int before = world_intersections(&world, &ray, &pen_origin_none, 1 - 1e-9, hit, 3);
        if (before > 0 && hit[before - 1].t > .999)
            continue; /* a chord so short that only double-double tells its ends apart */
        ck_assert_msg(shaded(o, light) == (before > 0), "%d: %d before; seed %llu", i, before,
                      (unsigned long long)r.seed);
    }
}
END_TEST

START_TEST(test_shadow__light_behind_or_beside_a_surface)
{
    world_clear(&world);
    sheet(1);
    vec3 o = pen_vec3(.1, .2, 0);
    ck_assert(shaded(o, pen_vec3(0, 0, 1 + 1e-12)));
    ck_assert(!shaded(o, pen_vec3(0, 0, 1 - 1e-12)));
    ck_assert(!shaded(o, pen_vec3(0, 0, 1)));
}
END_TEST

START_TEST(test_shadow__see_through_intersections_come_in_order)
{
    world_clear(&world);
    for (int i = 0; i < 20; i++) {
        sheet((7 * i) % 20 + 1); /* in no order */
        clear[i] = 1;
    }
    sheet(8); /* coincident with number 1: after it */
    clear[20] = 1;
    struct pen_shadow query = {.tmax = INFINITY, .see_through = clear, .last_occluder = 3};
    ck_assert(!occluded(pen_vec3(.1, .2, 0), pen_vec3(0, 0, 1), &pen_origin_none, &query));
    ck_assert_int_eq(query.count, 21);
    for (int i = 1; i < 21; i++)
        ck_assert(pen_hit_before(query.hit[i - 1], query.hit[i]));
    ck_assert(query.hit[7].prim == 1 && query.hit[8].prim == 20);
    clear[5] = 0;
    ck_assert(occluded(pen_vec3(.1, .2, 0), pen_vec3(0, 0, 1), &pen_origin_none, &query));
    ck_assert_uint_eq(query.last_occluder, 5);
    clear[5] = 1;
}
END_TEST

START_TEST(test_shadow__too_many_to_keep)
{
    for (int count = PEN_SHADOW_MAX; count <= PEN_SHADOW_MAX + 1; count++) {
        world_clear(&world);
        for (int i = 0; i < count; i++) {
            sheet(1 + i);
            clear[i] = 1;
        }
        struct pen_shadow query = {.tmax = 1e3, .see_through = clear, .last_occluder = PEN_NO_PRIM};
        ck_assert(!occluded(pen_vec3(.1, .2, 0), pen_vec3(0, 0, 1), &pen_origin_none, &query));
        ck_assert(query.overflow == (count > PEN_SHADOW_MAX));
        sheet(500);
        clear[count] = 0;
        ck_assert(occluded(pen_vec3(.1, .2, 0), pen_vec3(0, 0, 1), &pen_origin_none, &query));
    }
}
END_TEST

/* The last occluder speeds the answer up and never changes it. */
START_TEST(test_shadow__last_occluder_is_only_a_hint)
{
    world_clear(&world);
    sheet(1);
    world_sphere(&world, pen_vec3(5, 0, 0), 1);
    for (uint32_t hint = 0; hint < 4; hint++) {
        struct pen_shadow query = {.tmax = 10, .last_occluder = hint == 3 ? PEN_NO_PRIM : hint};
        ck_assert(occluded(pen_vec3(.1, .2, 0), pen_vec3(0, 0, 1), &pen_origin_none, &query));
        ck_assert_uint_eq(query.last_occluder, 0);
        ck_assert(!occluded(pen_vec3(.1, .2, 0), pen_vec3(0, 0, -1), &pen_origin_none, &query));
    }
}
END_TEST

PEN_SUITE("shadow", test_shadow__the_interval_is_open,
          test_shadow__a_ray_does_not_cross_where_it_starts, test_shadow__light_on_a_surface,
          test_shadow__light_behind_or_beside_a_surface,
          test_shadow__see_through_intersections_come_in_order, test_shadow__too_many_to_keep,
          test_shadow__last_occluder_is_only_a_hint)
