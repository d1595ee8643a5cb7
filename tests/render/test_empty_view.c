/* SPDX-License-Identifier: MIT */
/* The warning that nothing is visible, against the picture. All objects glow before a black
 * background. There is no false alarm. Most empty views get the warning, also views of infinite
 * primitives, with wide lenses, and of few pixels. */
#include <stdio.h>
#include <stdlib.h>

#include "scene/empty_view.h"
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

static void add_any(struct random *r, int material)
{
    const vec3 at = random_vec(r, 6), way = random_direction(r);
    const double size = random_in(r, 0.05, 1.5);
    const vec3 v[3] = {at, pen_along(at, random_direction(r), size),
                       pen_along(at, random_direction(r), size)};
    switch (random_below(r, 5)) {
    case 0:
        kit_sphere(&kit, at, size, material);
        break;
    case 1:
        kit_cylinder(&kit, at, way, size, random_in(r, 0.1, 4), material)->u.cylinder.caps =
            random_bits(r) & 1;
        break;
    case 2:
        if (random_below(r, 4) == 0) /* in most views */
            kit_plane(&kit, at, way, material);
        break;
    case 3:
        if (random_below(r, 4) == 0)
            kit_tube(&kit, at, way, size, material);
        break;
    default:
        kit_polygon(&kit, v, 3, material);
    }
}

static void any_scene(struct random *r)
{
    kit_init(&kit);
    const int material = kit_material(&kit, kit_glow(1, 1, 1));
    const uint32_t objects = 1 + random_below(r, 3);
    for (uint32_t i = 0; i < objects; i++)
        add_any(r, material);
    struct pen_camera_desc *camera = &kit.view.camera;
    camera->position = random_vec(r, 6);
    camera->has_look_at = false;
    camera->direction = random_direction(r);
    camera->has_view_plane = random_bits(r) & 1;
    camera->plane_distance = 1;
    camera->plane_width = random_in(r, 0.1, 4);
    camera->plane_height = random_in(r, 0.1, 4);
    camera->fov_degrees = random_in(r, 5, 150);
    camera->aperture_radius = random_below(r, 3) ? 0 : random_in(r, 0.01, 2);
    camera->focus_distance = random_in(r, 0.5, 9);
    kit.settings.width = 40;
    kit.settings.height = 30;
    kit.settings.lens_samples = 16;
}

START_TEST(test_empty_view__is_told_without_false_alarms)
{
    struct random random = random_begin(31);
    int empty = 0, told = 0;
    for (int i = 0; i < random_some(20000, 3000); i++) {
        const uint64_t seed = random.state;
        char text[PEN_MSG_BYTES];
        any_scene(&random);
        if (kit.desc.object_count == 0)
            continue;
        struct pen_scene *scene = kit_freeze(&kit);
        const bool warned = pen_view_empty_warning(scene, 0, 40, 30, text, sizeof text);
        float *rgb = kit_film(scene, &kit.settings, 1), most = 0;
        for (int k = 0; k < 40 * 30 * 3; k++)
            most = rgb[k] > most ? rgb[k] : most;
        ck_assert_msg(!warned || most == 0, "seed %llu: %s", (unsigned long long)seed, text);
        empty += most == 0;
        told += warned;
        free(rgb);
        pen_scene_free(scene);
    }
    printf("%d views are empty, %d are told\n", empty, told);
    ck_assert_int_gt(10 * told, 8 * empty);
    ck_assert_int_gt(empty, random_some(2000, 300));
}
END_TEST

PEN_SUITE("render/empty_view", test_empty_view__is_told_without_false_alarms)
