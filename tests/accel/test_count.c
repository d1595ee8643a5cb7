/* SPDX-License-Identifier: MIT */
/* Counting queries give the same answers, counts that are equal in every variant, and known counts
 * for simple scenes. */
#include "support/isa.h"
#include "support/suite.h"
#include "support/world.h"

static struct world world;

static struct pen_accel *build(struct pen_arena *arena, enum pen_accelerator kind)
{
    struct pen_status st;
    struct pen_accel *accel = pen_accel_build(&world.prims, kind, arena, &st);
    ck_assert(accel);
    return accel;
}

/* Traces a ray with both counting queries; the plain queries must agree. */
static struct pen_test_counts count_tests(const struct pen_accel *accel, enum pen_isa isa,
                                          const struct pen_ray *ray)
{
    struct pen_test_counts counts = {0};
    struct pen_accel *view = pen_accel_count_new(accel, &counts);
    const struct pen_trace_ops *ops = pen_trace_ops_get(isa), *count = pen_trace_count_ops_get(isa);
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_hit hit = {0, PEN_NO_PRIM, 0}, counted = hit;
    bool found = ops->nearest(accel, ray, &pen_origin_none, &interval, &hit);
    ck_assert(count->nearest(view, ray, &pen_origin_none, &interval, &counted) == found);
    ck_assert(hit.prim == counted.prim && hit.t == counted.t && hit.part == counted.part);
    struct pen_shadow query = {.tmax = 1, .last_occluder = PEN_NO_PRIM}, again = query;
    bool blocked = ops->shadow(accel, ray, &pen_origin_none, &query);
    struct pen_test_counts before = counts;
    ck_assert(count->shadow(view, ray, &pen_origin_none, &again) == blocked);
    struct pen_test_counts between = counts;
    again.last_occluder = query.last_occluder; /* the hint changes no count */
    ck_assert(count->shadow(view, ray, &pen_origin_none, &again) == blocked);
    ck_assert_uint_eq(counts.boxes - between.boxes, between.boxes - before.boxes);
    ck_assert_uint_eq(counts.primitives - between.primitives,
                      between.primitives - before.primitives);
    pen_accel_count_free(view);
    return counts;
}

START_TEST(test_count__variants_agree)
{
    struct random r = random_begin(31);
    uint64_t boxes = 0, primitives = 0;
    for (int scene = 0; scene < random_cases(100); scene++) {
        world_clear(&world);
        world_random(&world, &r, random_below(&r, 200), random_in(&r, 0.02, 0.5));
        for (int k = 0; k < PEN_ACCEL_COUNT; k++) {
            struct pen_arena *arena = pen_arena_new(0);
            struct pen_accel *accel = build(arena, (enum pen_accelerator)k);
            for (int i = 0; i < 60; i++) {
                struct pen_ray ray = world_ray(random_vec(&r, 2), random_direction(&r));
                struct pen_test_counts a = count_tests(accel, PEN_ISA_BASE, &ray);
                for (int isa = 1; isa < isa_count(); isa++) {
                    struct pen_test_counts b = count_tests(accel, (enum pen_isa)isa, &ray);
                    ck_assert_msg(a.boxes == b.boxes && a.primitives == b.primitives,
                                  "accelerator %d: %llu %llu and %llu %llu; seed %llu", k,
                                  (unsigned long long)a.boxes, (unsigned long long)a.primitives,
                                  (unsigned long long)b.boxes, (unsigned long long)b.primitives,
                                  (unsigned long long)r.seed);
                }
                boxes += a.boxes;
                primitives += a.primitives;
            }
            pen_arena_free(arena);
        }
    }
    ck_assert_uint_gt(boxes, 0);
    ck_assert_uint_gt(primitives, 0);
}
END_TEST

/* Rays that graze boxes: the variants must agree on every rounding, also far from the origin, and
 * where the origin itself is rounded. */
START_TEST(test_count__variants_agree_at_the_faces_of_boxes)
{
    struct random r = random_begin(33);
    uint64_t boxes = 0;
    for (int scene = 0; scene < random_cases(200); scene++) {
        double far = scene & 1 ? 0 : ldexp(1, (int)random_below(&r, 30));
        world_clear(&world);
        for (int i = 0; i < 60; i++) {
            struct pen_vec3 c = random_vec(&r, 4);
            c = pen_vec3(far + round(c.x), round(c.y) - far, round(c.z));
            world_box(&world, c, pen_add(c, pen_vec3(1, .1, .7)));
        }
        struct pen_arena *arena = pen_arena_new(0);
        struct pen_accel *accel = build(arena, (enum pen_accelerator)(scene % PEN_ACCEL_COUNT));
        for (int i = 0; i < 60; i++) {
            const struct pen_polygon *p = &world.polygon[random_below(&r, world.prims.count)];
            const struct pen_polygon *q = &world.polygon[random_below(&r, world.prims.count)];
            struct pen_vec3 d = pen_sub(q->v[random_below(&r, 4)], p->v[random_below(&r, 4)]);
            struct pen_vec3 o = pen_along(p->v[0], d, -random_unit(&r));
            struct pen_ray ray;
            if (!pen_ray_make(&ray, random_below(&r, 2) ? p->v[0] : o, d))
                continue;
            struct pen_test_counts a = count_tests(accel, PEN_ISA_BASE, &ray);
            for (int isa = 1; isa < isa_count(); isa++) {
                struct pen_test_counts b = count_tests(accel, (enum pen_isa)isa, &ray);
                ck_assert_uint_eq(a.boxes, b.boxes);
                ck_assert_uint_eq(a.primitives, b.primitives);
            }
            boxes += a.boxes;
        }
        pen_arena_free(arena);
    }
    ck_assert_uint_gt(boxes, 100000);
}
END_TEST

START_TEST(test_count__without_boxes_every_primitive_is_tested)
{
    struct random r = random_begin(32);
    world_clear(&world);
    world_random(&world, &r, 150, .1);
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_test_counts counts = {0};
    struct pen_accel *view = pen_accel_count_new(build(arena, PEN_ACCEL_NONE), &counts);
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_hit hit;
    for (unsigned n = 1; n <= 20; n++) { /* counts add up */
        struct pen_ray ray = world_ray(random_vec(&r, 2), random_direction(&r));
        pen_trace_count_ops_get(pen_cpu_isa())
            ->nearest(view, &ray, &pen_origin_none, &interval, &hit);
        ck_assert_uint_eq(counts.boxes, 0);
        ck_assert_uint_eq(counts.primitives, (uint64_t)n * world.prims.count);
    }
    pen_accel_count_free(view);
    pen_arena_free(arena);
}
END_TEST

START_TEST(test_count__a_ray_past_a_tree_tests_only_the_boxes_at_its_root)
{
    world_clear(&world);
    for (int i = 0; i < 64; i++)
        world_sphere(&world, pen_vec3(i & 3, i >> 2 & 3, i >> 4), .1);
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_accel *accel = build(arena, PEN_ACCEL_AUTO);
    struct pen_test_counts counts = {0};
    struct pen_accel *view = pen_accel_count_new(accel, &counts);
    struct pen_ray ray = world_ray(pen_vec3(-9, -9, 9), pen_vec3(1, 1, 0));
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_hit hit;
    ck_assert(!pen_trace_count_ops_get(pen_cpu_isa())
                   ->nearest(view, &ray, &pen_origin_none, &interval, &hit));
    ck_assert_uint_eq(counts.boxes, 8);
    ck_assert_uint_eq(counts.primitives, 0);
    pen_accel_count_free(view);
    pen_arena_free(arena);
}
END_TEST

PEN_SUITE("count", test_count__variants_agree, test_count__variants_agree_at_the_faces_of_boxes,
          test_count__without_boxes_every_primitive_is_tested,
          test_count__a_ray_past_a_tree_tests_only_the_boxes_at_its_root)
