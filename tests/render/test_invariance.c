/* SPDX-License-Identifier: MIT */
/* Pictures that must not change when the scene does: scaled by a power of two (H074), moved by a
 * distance that adds exactly (H076), seen in a mirror (H078). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/kit.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

static size_t film_floats(void)
{
    return 3 * (size_t)kit.settings.width * (size_t)kit.settings.height;
}

static float *film_of_kit(void)
{
    struct pen_scene *scene = kit_freeze(&kit);
    float *film = kit_film(scene, &kit.settings, 2);
    pen_scene_free(scene);
    return film;
}

typedef vec3 point_fn(vec3 p, double by);

static vec3 times(vec3 p, double by)
{
    return pen_scale(p, by);
}

static vec3 moved(vec3 p, double by)
{
    return pen_vec3(p.x + by, p.y - 3 * by, p.z + 0.5 * by);
}

static vec3 mirrored(vec3 p, double by)
{
    return pen_vec3(by * p.x, p.y, p.z);
}

/* Applies a map to every point of the kit's scene; lengths and directions are the caller's. */
static void map_points(point_fn *map, double by)
{
    for (uint32_t i = 0; i < kit.vertex_count; i++)
        kit.vertices[i] = map(kit.vertices[i], by);
    for (uint32_t i = 0; i < kit.desc.light_count; i++)
        kit.lights[i].position = map(kit.lights[i].position, by);
    kit.view.camera.position = map(kit.view.camera.position, by);
    for (uint32_t i = 0; i < kit.desc.object_count; i++) {
        struct pen_object_desc *o = &kit.objects[i];
        if (o->kind == PEN_OBJECT_SPHERE)
            o->u.sphere.center = map(o->u.sphere.center, by);
        else if (o->kind == PEN_OBJECT_PLANE)
            o->u.plane.point = map(o->u.plane.point, by);
        else if (o->kind == PEN_OBJECT_TUBE)
            o->u.tube.origin = map(o->u.tube.origin, by);
        else if (o->kind == PEN_OBJECT_CYLINDER)
            o->u.cylinder.base = map(o->u.cylinder.base, by);
    }
}

static void scale_lengths(double s)
{
    for (uint32_t i = 0; i < kit.desc.light_count; i++) {
        kit.lights[i].attenuation[1] /= s;
        kit.lights[i].attenuation[2] /= s * s;
        kit.lights[i].radius *= s;
    }
    for (uint32_t i = 0; i < kit.desc.object_count; i++) {
        struct pen_object_desc *o = &kit.objects[i];
        if (o->kind == PEN_OBJECT_SPHERE)
            o->u.sphere.radius *= s;
        else if (o->kind == PEN_OBJECT_TUBE)
            o->u.tube.radius *= s;
        else if (o->kind == PEN_OBJECT_CYLINDER) {
            o->u.cylinder.radius *= s;
            o->u.cylinder.height *= s;
        }
    }
}

START_TEST(test_invariance__h074_scaled_by_powers_of_two)
{
    static const int exponents[] = {-498, -200, -40, -20, -1, 1, 20, 40, 200, 498};
    kit_medley(&kit);
    float *want = film_of_kit();
    for (size_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++) {
        double s = ldexp(1, exponents[i]);
        kit_medley(&kit);
        map_points(times, s);
        scale_lengths(s);
        float *got = film_of_kit();
        ck_assert_msg(memcmp(got, want, film_floats() * sizeof *got) == 0, "2^%d", exponents[i]);
        free(got);
    }
    free(want);
}
END_TEST

START_TEST(test_invariance__h076_moved_by_exact_distances)
{
    static const double distances[] = {0x1p20, -0x1p30, 0x1p30 + 1024, 0x1.8p35};
    kit_medley(&kit);
    float *want = film_of_kit();
    for (size_t i = 0; i < sizeof distances / sizeof distances[0]; i++) {
        kit_medley(&kit);
        map_points(moved, distances[i]);
        float *got = film_of_kit();
        ck_assert_msg(memcmp(got, want, film_floats() * sizeof *got) == 0, "%a", distances[i]);
        free(got);
    }
    free(want);
}
END_TEST

static void mirror_directions(void)
{
    kit.view.camera.direction.x *= -1;
    for (uint32_t i = 0; i < kit.desc.light_count; i++)
        kit.lights[i].direction.x *= -1;
    for (uint32_t i = 0; i < kit.desc.object_count; i++) {
        struct pen_object_desc *o = &kit.objects[i];
        if (o->kind == PEN_OBJECT_PLANE)
            o->u.plane.normal.x *= -1;
        else if (o->kind == PEN_OBJECT_TUBE)
            o->u.tube.axis.x *= -1;
        else if (o->kind == PEN_OBJECT_CYLINDER)
            o->u.cylinder.axis.x *= -1;
    }
}

START_TEST(test_invariance__h078_seen_in_a_mirror)
{
    kit_medley(&kit);
    for (uint32_t i = 0; i < kit.desc.light_count; i++) /* points of disks are not mirrored */
        kit.lights[i].radius = kit.lights[i].angular_radius = 0;
    kit.settings.width = 120;
    kit.settings.height = 90;
    float *want = film_of_kit();
    map_points(mirrored, -1);
    mirror_directions();
    float *got = film_of_kit();
    int different = 0;
    for (int y = 0; y < 90; y++)
        for (int x = 0; x < 120; x++)
            different += memcmp(&got[3 * (y * 120 + x)], &want[3 * (y * 120 + 119 - x)],
                                3 * sizeof *got) != 0;
    ck_assert_int_le(different, 2); /* borders that rays meet exactly belong to one side */
    free(want);
    free(got);
}
END_TEST

PEN_SUITE("invariance", test_invariance__h074_scaled_by_powers_of_two,
          test_invariance__h076_moved_by_exact_distances, test_invariance__h078_seen_in_a_mirror)
