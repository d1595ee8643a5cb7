/* SPDX-License-Identifier: MIT */
/* Paths behind the first surface: mirrors, straight transmission, where they end, and the number of
 * rays. The pixel looks along -z from z = 10. */
#include <stdlib.h>

#include "support/kit.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

static void assert_exactly(vec3 got, vec3 want)
{
    ck_assert_msg(got.x == want.x && got.y == want.y && got.z == want.z,
                  "(%a %a %a), want (%a %a %a)", got.x, got.y, got.z, want.x, want.y, want.z);
}

static int add_material(vec3 emission, vec3 kt, vec3 kr)
{
    struct pen_material m = kit_glow(emission.x, emission.y, emission.z);
    m.kt = kt;
    m.kr = kr;
    return kit_material(&kit, m);
}

static const vec3 none = {0, 0, 0};

/* H112: two mirrors face each other; the m-th image is weaker by kr^m, and the depth limit is
 * exact. */
START_TEST(test_paths__h112_mirror_pair)
{
    for (int depth = 1; depth <= 50; depth += 7) {
        kit_init(&kit);
        vec3 kr = {1, 0.875, 0.96875};
        kit_plane(&kit, pen_vec3(0, 0, -2), pen_vec3(0, 0, 1),
                  add_material(pen_vec3(1, 0.5, 0.25), none, kr));
        kit_plane(&kit, pen_vec3(0, 0, 20), pen_vec3(0, 0, 1),
                  add_material(pen_vec3(0.125, 0.75, 3), none, kr));
        kit.settings.max_depth = depth;
        kit.settings.min_contribution = 0;
        vec3 sum = none, weight = {1, 1, 1};
        for (int i = 0; i < depth; i++) {
            sum = pen_add(sum, pen_mul(weight, kit.materials[i % 2].emission));
            weight = pen_mul(weight, kr);
        }
        struct pen_ray_counts rays;
        assert_exactly(kit_pixel(&kit, 0, 0, &rays), sum);
        ck_assert_uint_eq(rays.primary, 1);
        ck_assert_uint_eq(rays.reflection, (uint64_t)depth - 1);
        ck_assert_uint_eq(rays.transmission, 0);
        ck_assert_uint_eq(rays.shadow, 0);
    }
}
END_TEST

START_TEST(test_paths__mirror_direction)
{
    kit_init(&kit);
    kit_plane(&kit, none, pen_vec3(1, 0, 2), add_material(none, none, pen_vec3(1, 1, 1)));
    vec3 r = pen_vec3(0.8, 0, 0.6); /* v - 2 (n.v) n for v = -z, n = (1, 0, 2) / sqrt 5 */
    kit_sphere(&kit, pen_scale(r, 100), 1e-3, add_material(pen_vec3(3, 2, 1), none, none));
    assert_exactly(kit_pixel(&kit, 0, 0, NULL), pen_vec3(3, 2, 1));
}
END_TEST

START_TEST(test_paths__end_below_min_contribution)
{
    static const struct {
        double least;
        uint64_t rays;
    } rows[] = {{0.125, 3}, {0.126, 2}, {0.5, 1}, {0.51, 0}, {1, 0}, {0, 9}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        kit_init(&kit);
        int m = add_material(none, none, pen_vec3(0.25, 0.5, 0)); /* the best channel counts */
        kit_plane(&kit, none, pen_vec3(0, 0, 1), m);
        kit_plane(&kit, pen_vec3(0, 0, 20), pen_vec3(0, 0, 1), m);
        kit.settings.min_contribution = rows[i].least;
        struct pen_ray_counts rays;
        kit_pixel(&kit, 0, 0, &rays);
        ck_assert_uint_eq(rays.reflection, rows[i].rays);
    }
}
END_TEST

START_TEST(test_paths__end_at_weight_zero)
{
    kit_init(&kit);
    kit.settings.min_contribution = 0;
    kit_plane(&kit, none, pen_vec3(0, 0, 1), add_material(none, none, pen_vec3(1, 0, 0)));
    kit_plane(&kit, pen_vec3(0, 0, 20), pen_vec3(0, 0, 1),
              add_material(none, none, pen_vec3(0, 1, 1)));
    struct pen_ray_counts rays;
    kit_pixel(&kit, 0, 0, &rays);
    ck_assert_uint_eq(rays.reflection, 1);
}
END_TEST

START_TEST(test_paths__background_through_glass)
{
    kit_init(&kit);
    kit.desc.background = pen_vec3(0.3, 0.7, 11);
    vec3 weight = {1, 1, 1};
    for (int i = 0; i < 6; i++) {
        vec3 kt = pen_vec3(0.9 - 0.1 * i, 0.7, 1 - 0.07 * i);
        kit_sheet(&kit, -i, 1, add_material(none, kt, none));
        weight = pen_mul(weight, kt);
    }
    struct pen_ray_counts rays;
    assert_exactly(kit_pixel(&kit, 0, 0, &rays), pen_mul(weight, kit.desc.background));
    ck_assert_uint_eq(rays.transmission, 6);
    ck_assert_uint_eq(rays.primary, 1);
}
END_TEST

START_TEST(test_paths__h114_coincident_glass_in_document_order)
{
    kit_init(&kit);
    const vec3 kt[] = {{0.9, 0.7, 0.3}, {0.8, 0.9, 0.1}, {0.7, 0.3, 0.9}};
    vec3 weight = {1, 1, 1}, sum = none;
    for (int i = 0; i < 3; i++) {
        vec3 emission = pen_vec3(1 + i, 0.3, 5 - i);
        kit_sheet(&kit, 3, 1, add_material(emission, kt[i], none));
        sum = pen_add(sum, pen_mul(weight, emission));
        weight = pen_mul(weight, kt[i]);
    }
    struct pen_ray_counts rays;
    assert_exactly(kit_pixel(&kit, 0, 0, &rays), sum);
    ck_assert_uint_eq(rays.transmission, 3);
}
END_TEST

/* The transmitted ray is the same ray beyond the intersection; it does not start anew at a rounded
 * point. */
START_TEST(test_paths__h110_glass_keeps_the_ray)
{
    kit_init(&kit);
    kit.settings.max_depth = 500;
    kit.settings.min_contribution = 0;
    kit.settings.width = 50;
    kit.view.camera.has_view_plane = true;
    kit.view.camera.plane_distance = 10;
    kit.view.camera.plane_width = 1;
    kit.view.camera.plane_height = 0.01;
    int lamp = add_material(pen_vec3(1, 1, 1), none, none);
    const vec3 edge[] = {{0, -1, -30}, {1, -1, -30}, {1, 1, -30}, {0, 1, -30}};
    kit_polygon(&kit, edge, 4, lamp);
    struct pen_scene *bare = kit_freeze(&kit);
    int glass = add_material(none, pen_vec3(1, 1, 1), none);
    for (int i = 0; i < 20; i++) {
        kit_sphere(&kit, pen_vec3(0.1, 0, -i), 0.7 + 0.01 * i, glass);
        kit_cylinder(&kit, pen_vec3(0.1 * i, 0, -i), pen_vec3(1, 0.1 * i, 1), 0.3, 0.5, glass);
        kit_tube(&kit, pen_vec3(0, 0.1, -i), pen_vec3(0.1 * i - 1, 1, 0), 0.2, glass);
        kit_sheet(&kit, -0.7 * i, 0.5, glass);
    }
    struct pen_scene *filled = kit_freeze(&kit);
    float *a = kit_film(bare, &kit.settings, 1), *b = kit_film(filled, &kit.settings, 1);
    float lit = 0;
    for (int i = 0; i < 3 * 50; i++) {
        ck_assert(a[i] == b[i]);
        lit += a[i];
    }
    ck_assert(lit > 0);
    free(a);
    free(b);
    pen_scene_free(bare);
    pen_scene_free(filled);
}
END_TEST

/* Both kinds at each of two sheets: the whole tree of paths, in the order they are summed. */
START_TEST(test_paths__tree_of_both_kinds)
{
    kit_init(&kit);
    kit.desc.background = pen_vec3(1, 2, 4);
    kit.settings.min_contribution = 0;
    kit.settings.max_depth = 3;
    int m = add_material(pen_vec3(1, 1, 1), pen_vec3(0.5, 0.5, 0.5), pen_vec3(0.25, 0.25, 0.25));
    kit_sheet(&kit, 1, 5, m);
    kit_sheet(&kit, 0, 5, m);
    /* Depth 1 at A: mirrored ray leaves upwards (background); transmitted one meets B at depth 2:
     * its transmitted ray leaves; its mirrored one meets A from below at depth 3 and ends. */
    double surfaces = 1 + 0.5 + 0.5 * 0.25, leaving = 0.5 * 0.5 + 0.25;
    struct pen_ray_counts rays;
    assert_exactly(kit_pixel(&kit, 0, 0, &rays),
                   pen_vec3(surfaces + leaving, surfaces + 2 * leaving, surfaces + 4 * leaving));
    ck_assert_uint_eq(rays.reflection, 2);
    ck_assert_uint_eq(rays.transmission, 2);
}
END_TEST

START_TEST(test_paths__deep_trees_fit)
{
    kit_init(&kit);
    kit.settings.min_contribution = 0;
    kit.settings.max_depth = 11;
    int m = add_material(none, pen_vec3(1, 1, 1), pen_vec3(1, 1, 1));
    for (int i = 0; i < 30; i++)
        kit_plane(&kit, pen_vec3(0, 0, -i), pen_vec3(0, 0, 1), m);
    for (int i = 0; i < 30; i++)
        kit_plane(&kit, pen_vec3(0, 0, 11 + i), pen_vec3(0, 0, 1), m);
    struct pen_ray_counts rays;
    kit_pixel(&kit, 0, 0, &rays);
    ck_assert_uint_eq(rays.reflection, (1 << 10) - 1); /* a full binary tree of depth 11 */
    ck_assert_uint_eq(rays.transmission, (1 << 10) - 1);
    ck_assert_uint_eq(rays.truncated_paths, 0);
    kit.settings.max_depth = 12;
    kit_pixel(&kit, 0, 0, &rays);
    ck_assert_uint_eq(1 + rays.reflection + rays.transmission, 1 << 11);
    /* The stack holds a path for each depth at most, and the last surface adds none at depth 12. */
    ck_assert_uint_gt(rays.truncated_paths, 0);
    ck_assert_uint_le(rays.truncated_paths, 12);
}
END_TEST

/* Three balls in each other that reflect and transmit all light: without a bound, a pixel takes
 * seconds at depth 28, and for ever at depth 60. */
START_TEST(test_paths__exploding_trees_are_cut)
{
    enum { SIDE = 12 };
    static const int depths[] = {28, 60, 1000};
    for (size_t i = 0; i < sizeof depths / sizeof depths[0]; i++) {
        kit_init(&kit);
        kit.settings.min_contribution = 0;
        kit.settings.max_depth = depths[i];
        kit.settings.width = kit.settings.height = SIDE;
        kit.view.camera.fov_degrees = 30;
        int m = add_material(none, pen_vec3(1, 1, 1), pen_vec3(1, 1, 1));
        kit_sphere(&kit, pen_vec3(-1.05, -0.6, 0), 2, m);
        kit_sphere(&kit, pen_vec3(1.05, -0.6, 0), 2, m);
        kit_sphere(&kit, pen_vec3(0, 1.2, 0), 2, m);
        uint64_t cut = 0;
        for (int pixel = 0; pixel < SIDE * SIDE; pixel++) {
            struct pen_ray_counts rays;
            kit_pixel(&kit, pixel % SIDE, pixel / SIDE, &rays);
            /* Each surface is the end of one ray, and up to two start there. */
            ck_assert_uint_le(rays.reflection + rays.transmission, 2 * PEN_TREE_SURFACES);
            cut += rays.truncated_paths;
        }
        ck_assert_uint_gt(cut, SIDE * SIDE);
    }
}
END_TEST

/* A path that does not fork has as many surfaces as max_depth allows, even in a scene where others
 * fork. */
START_TEST(test_paths__single_paths_are_never_cut)
{
    kit_init(&kit);
    kit.settings.min_contribution = 0;
    kit.settings.max_depth = 3 * PEN_TREE_SURFACES;
    int mirror = add_material(none, none, pen_vec3(1, 1, 1));
    kit_plane(&kit, pen_vec3(0, 0, -2), pen_vec3(0, 0, 1), mirror);
    kit_plane(&kit, pen_vec3(0, 0, 20), pen_vec3(0, 0, 1), mirror);
    kit_sphere(&kit, pen_vec3(9, 9, 9), 1,
               add_material(none, pen_vec3(1, 1, 1), pen_vec3(1, 1, 1)));
    struct pen_ray_counts rays;
    kit_pixel(&kit, 0, 0, &rays);
    ck_assert_uint_eq(rays.reflection, 3 * PEN_TREE_SURFACES - 1);
    ck_assert_uint_eq(rays.truncated_paths, 0);
}
END_TEST

START_TEST(test_paths__ambient_is_for_primary_rays)
{
    kit_init(&kit);
    kit.desc.ambient = pen_vec3(1, 1, 1);
    struct pen_material m = pen_material_default();
    m.ka = pen_vec3(0.5, 0.5, 0.5);
    m.kr = m.kt = pen_vec3(0.25, 0.25, 0.25);
    int number = kit_material(&kit, m);
    kit_sheet(&kit, 1, 5, number);
    kit_sheet(&kit, 0, 5, number);
    assert_exactly(kit_pixel(&kit, 0, 0, NULL), pen_vec3(0.5, 0.5, 0.5));
}
END_TEST

/* Light at every surface of a path: each casts its own shadow ray, seen from its own viewer. */
START_TEST(test_paths__lights_at_every_surface)
{
    kit_init(&kit);
    struct pen_material m = kit_matte(0.5);
    m.kt = pen_vec3(0.5, 0.5, 0.5);
    int number = kit_material(&kit, m);
    kit_sheet(&kit, 2, 5, number);
    kit_sheet(&kit, 1, 5, number);
    kit_sheet(&kit, 0, 5, number);
    kit_directional(&kit, pen_vec3(0, 0, -1), pen_vec3(1, 1, 1));
    kit_directional(&kit, pen_vec3(0, 0, 1), pen_vec3(1, 1, 1)); /* behind every sheet */
    struct pen_ray_counts rays;
    double want = 0.5 + 0.5 * (0.5 * 0.5) + 0.25 * (0.5 * 0.25);
    assert_exactly(kit_pixel(&kit, 0, 0, &rays), pen_vec3(want, want, want));
    ck_assert_uint_eq(rays.shadow, 3);
}
END_TEST

START_TEST(test_paths__depth_one_is_direct_light_only)
{
    kit_init(&kit);
    kit.desc.background = pen_vec3(5, 5, 5);
    kit.settings.max_depth = 1;
    kit_sheet(&kit, 0, 5,
              add_material(pen_vec3(1, 1, 1), pen_vec3(0.5, 0.5, 0.5), pen_vec3(0.5, 0.5, 0.5)));
    struct pen_ray_counts rays;
    assert_exactly(kit_pixel(&kit, 0, 0, &rays), pen_vec3(1, 1, 1));
    ck_assert_uint_eq(rays.reflection + rays.transmission, 0);
}
END_TEST

/* H113: primitives that absorb nothing, transmissive or mirrors, in light that is the same
 * everywhere, are invisible, bit for bit. */
START_TEST(test_paths__h113_furnace)
{
    enum { SIZE = 48 };
    const vec3 light = {0.3, 0.7, 11}, all = {1, 1, 1};
    kit_init(&kit);
    kit.desc.background = light;
    kit.settings.width = kit.settings.height = SIZE;
    kit.settings.max_depth = 60;
    kit.settings.min_contribution = 0;
    int glass = add_material(none, all, none), mirror = add_material(none, none, all);
    kit_sphere(&kit, pen_vec3(0, 0, 0), 3, glass);
    kit_sphere(&kit, pen_vec3(0.5, 0, 0), 2, glass);
    kit_cylinder(&kit, pen_vec3(-2, -1, -1), pen_vec3(1, 1, 0.5), 0.5, 4, glass);
    kit_tube(&kit, pen_vec3(0, 1, -2), pen_vec3(1, 0.1, 0.3), 0.4, glass);
    kit_sphere(&kit, pen_vec3(-1, 2, -4), 1.5, mirror);
    kit_sphere(&kit, pen_vec3(0.5, 0.25, 0), 0.75, mirror); /* inside the glass */
    struct pen_scene *scene = kit_freeze(&kit);
    float *film = kit_film(scene, &kit.settings, 1);
    for (int i = 0; i < SIZE * SIZE; i++)
        for (int c = 0; c < 3; c++)
            ck_assert_msg(film[3 * i + c] == (float)pen_component(light, c), "pixel %d: %a", i,
                          (double)film[3 * i + c]);
    free(film);
    pen_scene_free(scene);
    struct pen_ray_counts rays;
    kit.settings.width = kit.settings.height = 1; /* with primitives before the light */
    kit_pixel(&kit, 0, 0, &rays);
    ck_assert_uint_gt(rays.transmission, 1);
    ck_assert_uint_gt(rays.reflection, 0);
}
END_TEST

/* H115: a ray that starts inside a primitive of glass meets its surface once. */
START_TEST(test_paths__h115_camera_in_glass)
{
    const vec3 kt = {0.5, 0.25, 0.75}, outer = {0.9, 0.7, 0.3}, light = {3, 5, 7};
    for (int i = 0; i < 6; i++) {
        kit_init(&kit);
        kit.desc.background = light;
        int glass = add_material(none, kt, none), around = add_material(none, outer, none);
        vec3 eye = kit.view.camera.position;
        if (i % 3 == 0)
            kit_sphere(&kit, eye, 2, glass);
        else if (i % 3 == 1)
            kit_cylinder(&kit, pen_vec3(0, -1, eye.z - 0.5), pen_vec3(0, 1, 0), 1, 2, glass);
        else
            kit_tube(&kit, eye, pen_vec3(1, 2, 0), 0.25, glass);
        if (i >= 3)
            kit_sphere(&kit, pen_vec3(0, 0, 9), 5, around);
        struct pen_ray_counts rays;
        vec3 weight = i < 3 ? kt : pen_mul(kt, outer);
        assert_exactly(kit_pixel(&kit, 0, 0, &rays), pen_mul(weight, light));
        ck_assert_uint_eq(rays.transmission, i < 3 ? 1 : 2);
    }
}
END_TEST

PEN_SUITE("paths", test_paths__h112_mirror_pair, test_paths__mirror_direction,
          test_paths__end_below_min_contribution, test_paths__end_at_weight_zero,
          test_paths__background_through_glass, test_paths__h114_coincident_glass_in_document_order,
          test_paths__h110_glass_keeps_the_ray, test_paths__tree_of_both_kinds,
          test_paths__deep_trees_fit, test_paths__exploding_trees_are_cut,
          test_paths__single_paths_are_never_cut, test_paths__ambient_is_for_primary_rays,
          test_paths__lights_at_every_surface, test_paths__depth_one_is_direct_light_only,
          test_paths__h113_furnace, test_paths__h115_camera_in_glass)
