/* SPDX-License-Identifier: MIT */
/* The samples of a soft light: which are taken, on what each depends, and which cost a ray. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "math/sample.h"
#include "support/kit.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

/* A floor seen straight from above at the origin, and a light of radius 1 far over the camera:
 * brightness is T(p), and (a, b) of the unit disk is the light's point (a, b, 20). */
static struct pen_light_desc *floor_and_disk(struct pen_material floor)
{
    kit_init(&kit);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), kit_material(&kit, floor));
    struct pen_light_desc *light = kit_point(&kit, pen_vec3(0, 0, 20), pen_vec3(1, 1, 1));
    light->radius = 1;
    return light;
}

/* Hides what is left of x = h on the disk, above the camera. */
static void hide_left_of(double h)
{
    const vec3 v[] = {{-9, -9, 15}, {h * 0.75, -9, 15}, {h * 0.75, 9, 15}, {-9, 9, 15}};
    kit_polygon(&kit, v, 4, -1);
}

/* The number of a light's samples right of x = h on the disk, by the documented key. */
static int right_of(double h, const struct pen_sample_key *key, int *taken)
{
    const struct pen_settings *s = &kit.settings;
    uint64_t hash = pen_sample_hash(key);
    int edge = (int)ceil(sqrt(s->light_samples)), right = 0;
    bool grid = s->light_pattern == PEN_PATTERN_GRID;
    *taken = 0;
    int drawing = grid ? edge * edge : s->light_samples;
    for (int i = 0; i == 0 || i % drawing > 0 || *taken == 0; i++) {
        uint32_t n = (uint32_t)i;
        struct pen_point2 p;
        if (grid) {
            p = pen_grid2(hash, (uint32_t)edge, n);
            p = (struct pen_point2){2 * p.x - 1, 2 * p.y - 1};
            if (p.x * p.x + p.y * p.y > 1)
                continue;
        } else if (s->light_pattern == PEN_PATTERN_SOBOL) {
            p = pen_disk_of_square(pen_sobol2(hash, n));
        } else {
            p = pen_disk_of_square(pen_random2(hash, n));
        }
        right += p.x > h;
        ++*taken;
    }
    return right;
}

static struct pen_sample_key key_of(uint32_t node)
{
    return (struct pen_sample_key){
        .seed = kit.settings.seed, .node = node, .purpose = PEN_PURPOSE_LIGHT};
}

START_TEST(test_soft_rays__samples_are_those_of_the_documented_key)
{
    for (int pattern = PEN_PATTERN_SOBOL; pattern <= PEN_PATTERN_RANDOM; pattern++)
        for (int n = 1; n < 300; n += 1 + n / 3)
            for (uint64_t seed = 0; seed < 8; seed++) {
                floor_and_disk(kit_matte(1));
                hide_left_of(0.21);
                kit.settings.light_samples = n;
                kit.settings.light_pattern = pattern;
                kit.settings.seed = seed;
                struct pen_sample_key key = key_of(1);
                struct pen_ray_counts rays;
                int taken, right = right_of(0.21, &key, &taken);
                double got = kit_pixel(&kit, 0, 0, &rays).x;
                ck_assert_msg(got == (double)right / taken, "pattern %d, n %d: %g, want %d of %d",
                              pattern, n, got, right, taken);
                ck_assert_uint_eq(rays.shadow, (uint64_t)taken);
            }
}
END_TEST

START_TEST(test_soft_rays__key_holds_pixel_sample_and_light)
{
    floor_and_disk(kit_matte(1));
    hide_left_of(0.21);
    kit.settings.width = kit.settings.height = 64;
    kit.settings.samples_per_pixel = 8;
    kit.view.camera.fov_degrees = 1e-3; /* all pixels see the origin, nearly */
    kit.lights[2] = kit.lights[0];
    kit.lights[0].intensity = pen_vec3(0, 0, 0); /* has a place, though it does not shine */
    kit.lights[1] = kit.lights[2];
    kit.lights[1].shadows = false;
    kit.desc.light_count = 3;
    for (uint32_t pixel = 0; pixel < 64; pixel += 9) {
        struct pen_ray_counts rays;
        struct pen_sample_key key = key_of(1);
        int sum = 0, taken;
        key.x = pixel;
        key.y = 63 - pixel;
        key.light = 2;
        for (; key.pixel_sample < 8; key.pixel_sample++)
            sum += right_of(0.21, &key, &taken);
        double got = kit_pixel(&kit, (int)key.x, (int)key.y, &rays).x - 1;
        ck_assert_msg(fabs(got - sum / (8. * taken)) < 1e-8, "pixel %u: %g, want %g", pixel, got,
                      sum / (8. * taken));
        ck_assert_uint_eq(rays.shadow, 8u * 16);
    }
}
END_TEST

/* A small mirror at p that sends rays of direction d on along r. */
static void mirror_at(vec3 p, vec3 d, vec3 r, int material)
{
    vec3 n = pen_normalize(pen_sub(pen_normalize(r), pen_normalize(d)));
    vec3 a = {0.5, 0, 0}, b = pen_scale(pen_cross(n, a), 1);
    const vec3 v[] = {pen_sub(pen_sub(p, a), b), pen_sub(pen_add(p, a), b),
                      pen_add(pen_add(p, a), b), pen_add(pen_sub(p, a), b)};
    kit_polygon(&kit, v, 4, material);
}

static void assert_seen_from_node(uint32_t node)
{
    struct pen_sample_key key = key_of(node);
    int taken, right = right_of(0.21, &key, &taken);
    double got = kit_pixel(&kit, 0, 0, NULL).x * taken;
    ck_assert_msg(fabs(got - right) < 1e-9, "node %u: %g of %d, want %d", node, got, taken, right);
}

/* Through two sheets of glass the floor is node 4, by two mirrors it is node 7. */
START_TEST(test_soft_rays__key_holds_the_node)
{
    struct pen_material glass = kit_matte(0), mirror = kit_matte(0);
    glass.kt = mirror.kr = pen_vec3(1, 1, 1);
    for (uint64_t seed = 0; seed < 5; seed++) {
        floor_and_disk(kit_matte(1));
        kit.settings.seed = seed;
        hide_left_of(0.21);
        int g = kit_material(&kit, glass), m = kit_material(&kit, mirror);
        assert_seen_from_node(1);
        kit_sheet(&kit, 5, 1, g);
        kit_sheet(&kit, 6, 1, g);
        assert_seen_from_node(4);
        kit.desc.object_count -= 2;
        vec3 down = {0, 0, -1}, across = {0, -1, 0}, slant = {0, -1, -1};
        kit.view.camera.position = pen_vec3(0, 8, 10);
        mirror_at(pen_vec3(0, 8, 4), down, across, m);
        mirror_at(pen_vec3(0, 4, 4), across, slant, m);
        assert_seen_from_node(7);
    }
}
END_TEST

START_TEST(test_soft_rays__node_numbers_do_not_run_out)
{
    ck_assert_uint_eq(pen_sample_node(1, false), 2);
    ck_assert_uint_eq(pen_sample_node(1, true), 3);
    ck_assert_uint_eq(pen_sample_node(0x7FFFFFFF, true), 0xFFFFFFFF);
    uint32_t seen[3][4096];
    for (int direction = 0; direction < 3; direction++) { /* through, mirrored, and by turns */
        uint32_t node = 1;
        for (int depth = 0; depth < 4096; depth++) {
            for (int before = 0; before < depth; before++)
                if (seen[direction][before] == node)
                    ck_abort_msg("nodes %d and %d are both %u", before, depth, node);
            seen[direction][depth] = node;
            node = pen_sample_node(node, direction == 1 || (direction == 2 && depth % 2));
        }
    }
}
END_TEST

START_TEST(test_soft_rays__radius_zero_costs_one_ray_and_changes_no_bit)
{
    for (int pattern = PEN_PATTERN_SOBOL; pattern <= PEN_PATTERN_RANDOM; pattern++) {
        struct pen_ray_counts without, with;
        kit_medley(&kit);
        kit.settings.light_pattern = pattern;
        kit.settings.light_samples = 1000;
        for (uint32_t i = 0; i < kit.desc.light_count; i++)
            kit.lights[i].radius = kit.lights[i].angular_radius = 0;
        for (int i = 0; i < 40 * 30; i += 11) {
            vec3 hard = kit_pixel(&kit, i % 40, i / 40, &without);
            kit.lights[1].radius = 5; /* of a directional light: of no account */
            kit.lights[0].angular_radius = 5;
            vec3 same = kit_pixel(&kit, i % 40, i / 40, &with);
            kit.lights[1].radius = kit.lights[0].angular_radius = 0;
            ck_assert(memcmp(&hard, &same, sizeof hard) == 0);
            ck_assert(memcmp(&without, &with, sizeof with) == 0);
            ck_assert_uint_le(with.shadow, kit.desc.light_count * 64);
        }
    }
}
END_TEST

/* One hard light beside a soft one: each is counted by itself. */
START_TEST(test_soft_rays__hard_lights_beside_soft_ones_cost_one_ray)
{
    struct pen_ray_counts rays;
    floor_and_disk(kit_matte(1));
    kit.settings.light_samples = 50;
    kit_point(&kit, pen_vec3(1, 2, 19), pen_vec3(1, 1, 1));
    kit_directional(&kit, pen_vec3(0, 0, -1), pen_vec3(1, 1, 1));
    kit_pixel(&kit, 0, 0, &rays);
    ck_assert_uint_eq(rays.shadow, 50 + 1 + 1);
    kit.lights[0].shadows = false;
    kit_pixel(&kit, 0, 0, &rays);
    ck_assert_uint_eq(rays.shadow, 1 + 1);
}
END_TEST

START_TEST(test_soft_rays__facing_away_costs_none)
{
    struct pen_ray_counts rays;
    floor_and_disk(kit_matte(1));
    kit.lights[0].position = pen_vec3(0, 0, -20);
    ck_assert(kit_pixel(&kit, 0, 0, &rays).x == 0);
    ck_assert_uint_eq(rays.shadow, 0);
    floor_and_disk(kit_matte(0)); /* nothing to send on */
    kit_pixel(&kit, 0, 0, &rays);
    ck_assert_uint_eq(rays.shadow, 0);
    /* The centre is below the horizon, half of the disk above it. */
    floor_and_disk(kit_matte(1));
    kit.lights[0].position = pen_vec3(20, 0, -0.001);
    kit.lights[0].radius = 5;
    ck_assert(kit_pixel(&kit, 0, 0, &rays).x == 0);
    ck_assert_uint_eq(rays.shadow, 0);
}
END_TEST

/* A light low over the floor: part of its disk is under it. Cutting the disk is a half-plane. */
START_TEST(test_soft_rays__below_the_horizon)
{
    enum { SAMPLES = 1024 };
    const double height = 0.75, away = 8, radius = 2;
    double cosine = away / hypot(away, height), sine = height / hypot(away, height);
    double h = -height / (cosine * radius), above = (acos(h) - h * sqrt(1 - h * h)) / M_PI;
    for (int see_through = 0; see_through <= 1; see_through++) {
        struct pen_material floor = kit_matte(1);
        if (see_through)
            floor.kt = pen_vec3(0.5, 0.25, 0);
        floor_and_disk(floor);
        kit.desc.light_count = 0;
        kit_point(&kit, pen_vec3(away, 0, height), pen_vec3(1, 1, 1))->radius = radius;
        kit.settings.light_samples = SAMPLES;
        kit.settings.max_depth = 1;
        struct pen_ray_counts rays;
        vec3 t = pen_scale(kit_pixel(&kit, 0, 0, &rays), 1 / sine);
        if (see_through) { /* rays to points below go through the floor, take its colour, and
                            * count */
            ck_assert_uint_eq(rays.shadow, SAMPLES);
            ck_assert_double_eq_tol(t.x, above + 0.5 * (1 - above), 0.01);
            ck_assert_double_eq_tol(t.y, above + 0.25 * (1 - above), 0.01);
        } else {
            ck_assert_double_eq_tol(t.x * SAMPLES, (double)rays.shadow, 1e-9);
            ck_assert_double_eq_tol(t.y, above, 0.01);
        }
        ck_assert_double_eq_tol(t.z, above, 0.01);
    }
}
END_TEST

/* Primitives below the transmissive floor count too; the floor itself only once. */
START_TEST(test_soft_rays__below_the_horizon_and_blocked)
{
    struct pen_material floor = kit_matte(1);
    floor.kt = pen_vec3(0.5, 0.5, 0.5);
    floor_and_disk(floor);
    kit.lights[0].position = pen_vec3(8, 0, 0.01);
    kit.settings.light_samples = 256;
    kit.settings.max_depth = 1;
    const vec3 wall[] = {{4, -9, -1e-3}, {4, 9, -1e-3}, {4, 9, -9}, {4, -9, -9}};
    struct pen_ray_counts rays;
    double open = kit_pixel(&kit, 0, 0, NULL).x;
    kit_polygon(&kit, wall, 4, -1);
    double blocked = kit_pixel(&kit, 0, 0, &rays).x;
    ck_assert_uint_eq(rays.shadow, 256);
    ck_assert_double_eq_tol(blocked / open, 0.5 / 0.75, 0.02);
}
END_TEST

/* The far side of a sphere that a sample enters at p counts as well. */
START_TEST(test_soft_rays__below_the_horizon_of_glass)
{
    struct pen_material glass = kit_matte(1);
    glass.kt = pen_vec3(0.5, 1, 0);
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(0, 0, -1), 1, kit_material(&kit, glass));
    kit_point(&kit, pen_vec3(8, 0, 1e-5), pen_vec3(1, 1, 1))->radius = 1;
    kit.settings.light_samples = 512;
    kit.settings.max_depth = 1;
    struct pen_ray_counts rays;
    vec3 t = pen_scale(kit_pixel(&kit, 0, 0, &rays), 8e5);
    ck_assert_uint_eq(rays.shadow, 512);
    ck_assert_double_eq_tol(t.x, 0.5 + 0.5 * 0.25, 5e-3);
    ck_assert_double_eq_tol(t.y, 1, 1e-9);
    ck_assert_double_eq_tol(t.z, 0.5, 5e-3);
}
END_TEST

/* A directional light's disk is at unit distance, and its rays have no end. */
START_TEST(test_soft_rays__directional)
{
    const double degrees = 20, tangent = tan(degrees * M_PI / 180);
    for (int far = 0; far <= 1; far++) {
        floor_and_disk(kit_matte(1));
        kit.desc.light_count = 0;
        kit_directional(&kit, pen_vec3(0, 0, -3), pen_vec3(1, 1, 1))->angular_radius = degrees;
        kit.settings.light_samples = 1024;
        double z = far ? 1e7 : 12, edge = 0.3 * tangent * z; /* seen from x/R = 0.3 on */
        const vec3 v[] = {{-1e9, -1e9, z}, {edge, -1e9, z}, {edge, 1e9, z}, {-1e9, 1e9, z}};
        kit_polygon(&kit, v, 4, -1);
        struct pen_ray_counts rays;
        double want = (acos(0.3) - 0.3 * sqrt(1 - 0.09)) / M_PI;
        ck_assert_double_eq_tol(kit_pixel(&kit, 0, 0, &rays).x, want, 6e-3);
        ck_assert_uint_eq(rays.shadow, 1024);
    }
}
END_TEST

START_TEST(test_soft_rays__grid_casts_what_is_in_the_circle)
{
    double rays_sum = 0;
    floor_and_disk(kit_matte(1));
    kit.settings.light_pattern = PEN_PATTERN_GRID;
    kit.settings.light_samples = 210; /* 15 x 15 */
    struct pen_scene *scene = kit_freeze(&kit);
    for (uint64_t seed = 0; seed < 300; seed++) {
        struct pen_ray_counts rays;
        struct pen_status st;
        double rgb[3];
        kit.settings.seed = seed;
        ck_assert(pen_render_pixel(scene, 0, &kit.settings, 0, 0, rgb, &rays, &st));
        ck_assert(rgb[0] == 1);
        ck_assert_uint_gt(rays.shadow, 165);
        ck_assert_uint_lt(rays.shadow, 189);
        rays_sum += (double)rays.shadow;
    }
    ck_assert_double_eq_tol(rays_sum / 300, 225 * M_PI / 4, 0.6);
    int centre = 0;
    for (uint64_t seed = 0; seed < 100; seed++) { /* one cell, whose point is often outside */
        struct pen_ray_counts rays;
        struct pen_status st;
        double rgb[3];
        kit.settings.seed = seed;
        kit.settings.light_samples = 1;
        ck_assert(pen_render_pixel(scene, 0, &kit.settings, 0, 0, rgb, &rays, &st));
        ck_assert_uint_eq(rays.shadow, 1);
        struct pen_sample_key key = key_of(1);
        struct pen_point2 p = pen_grid2(pen_sample_hash(&key), 1, 0);
        centre += hypot(2 * p.x - 1, 2 * p.y - 1) > 1;
    }
    ck_assert_int_gt(centre, 5);
    pen_scene_free(scene);
}
END_TEST

PEN_SUITE("soft_rays", test_soft_rays__samples_are_those_of_the_documented_key,
          test_soft_rays__key_holds_pixel_sample_and_light, test_soft_rays__key_holds_the_node,
          test_soft_rays__node_numbers_do_not_run_out,
          test_soft_rays__radius_zero_costs_one_ray_and_changes_no_bit,
          test_soft_rays__hard_lights_beside_soft_ones_cost_one_ray,
          test_soft_rays__facing_away_costs_none, test_soft_rays__below_the_horizon,
          test_soft_rays__below_the_horizon_and_blocked, test_soft_rays__below_the_horizon_of_glass,
          test_soft_rays__directional, test_soft_rays__grid_casts_what_is_in_the_circle)
