/* SPDX-License-Identifier: MIT */
/* Light near the horizon of the shaded point: above it, below it, or grazing, when it contributes
 * nothing. The materials have `ks` with shininess 0. So any light above the horizon contributes
 * fully, however low it is. */
#include <math.h>

#include "geom/ray.h"
#include "support/kit.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

/* Specular only: an unshadowed light of intensity 1 gives 1. */
static struct pen_material mirror_like(double kt)
{
    struct pen_material m = kit_matte(0);
    m.ks = pen_vec3(1, 1, 1);
    m.shininess = 0;
    m.kt = pen_vec3(kt, kt, kt);
    return m;
}

static void floor_of(double kt)
{
    kit_init(&kit);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), kit_material(&kit, mirror_like(kt)));
    kit.settings.max_depth = 1;
}

static void expect(double value, uint32_t shadow_rays)
{
    struct pen_ray_counts rays;
    vec3 got = kit_pixel(&kit, 0, 0, &rays);
    ck_assert_double_eq(got.x, value);
    ck_assert_uint_eq(rays.shadow, shadow_rays);
}

/* Lights at sine s over a floor. */
START_TEST(test_horizon__flat)
{
    static const double shares[] = {1 + 1e-6, 1 - 1e-6, 1e-3, 0, -1e-3, -1, -2, -1e7};
    for (int kt = 0; kt <= 1; kt++)
        for (int i = 0; i < 8; i++)
            for (int far = -3; far <= 8; far += 11) {
                double s = shares[i] * PEN_HORIZON_SINE, d = pow(10, far);
                bool above = shares[i] > 1;
                floor_of(0.5 * kt);
                kit_point(&kit, pen_vec3(d, 0, s * d), pen_vec3(1, 1, 1));
                expect(above, above);
                floor_of(0.5 * kt);
                kit_directional(&kit, pen_vec3(-1, 0, -s), pen_vec3(1, 1, 1));
                expect(above, above);
            }
}
END_TEST

/* Where rounding is larger than 2^-22 of the distance, it decides: a light next to the floor. */
START_TEST(test_horizon__near_light)
{
    floor_of(0);
    kit.view.camera.position = pen_vec3(3, 4, 10);
    kit_sphere(&kit, pen_vec3(100, 100, 0), 1, 0);
    for (int k = 1; k <= 8; k++) {
        kit.desc.light_count = 0;
        kit_point(&kit, pen_vec3(3, 4, 1e-14 * k / 8), pen_vec3(1, 1, 1));
        expect(0, 0);
    }
    kit.desc.light_count = 0;
    kit_point(&kit, pen_vec3(3, 4, 1e-11), pen_vec3(1, 1, 1));
    expect(1, 1);
}
END_TEST

/* On a small sphere rounding turns the normal. The view is on a point of the side of the sphere,
 * where a light at angle `sine` over the tangent plane is looked for. */
static double small_sphere(double radius, double sine)
{
    kit_init(&kit);
    int material = kit_material(&kit, mirror_like(0));
    kit_sphere(&kit, pen_vec3(1, 1, 1), radius, material);
    kit_sphere(&kit, pen_vec3(-50, -50, -50), 1, material); /* makes the frame large */
    kit.view.camera.position = pen_vec3(1, 1, 4);
    kit.settings.max_depth = 1;
    kit_directional(&kit, pen_vec3(-1, 0, -sine), pen_vec3(1, 1, 1));
    return kit_pixel(&kit, 0, 0, NULL).x;
}

START_TEST(test_horizon__small_sphere)
{
    ck_assert_double_eq(small_sphere(1, 1.1 * PEN_HORIZON_SINE), 1);
    ck_assert_double_eq(small_sphere(1, 0.9 * PEN_HORIZON_SINE), 0);
    ck_assert_double_eq(small_sphere(1e-9, 1e-6), 0); /* p is off by more than 1e-15 */
    ck_assert_double_eq(small_sphere(1e-9, 0.1), 1);
}
END_TEST

/* A disk that the edge of the grazing band halves: what grazes is in the denominator, brings
 * nothing, also through a transmissive floor, and costs no ray. */
START_TEST(test_horizon__disk)
{
    enum { SAMPLES = 1024 };
    for (int kt = 0; kt <= 1; kt++)
        for (int directional = 0; directional <= 1; directional++) {
            /* The sample at height y of the unit disk has sine (1.4 + 0.8 y) 2^-22. */
            double centre = 1.4 * PEN_HORIZON_SINE, radius = 0.8 * PEN_HORIZON_SINE, h = 0.5;
            double above = 1 - (acos(h) - h * sqrt(1 - h * h)) / M_PI;
            floor_of(0.5 * kt);
            if (directional)
                kit_directional(&kit, pen_vec3(-1, 0, -centre), pen_vec3(1, 1, 1))->angular_radius =
                    radius * 180 / M_PI;
            else
                kit_point(&kit, pen_vec3(8, 0, 8 * centre), pen_vec3(1, 1, 1))->radius = 8 * radius;
            kit.settings.light_samples = SAMPLES;
            struct pen_ray_counts rays;
            double t = kit_pixel(&kit, 0, 0, &rays).x;
            ck_assert_double_eq_tol(t, above, 0.01);
            ck_assert_double_eq_tol(t * SAMPLES, (double)rays.shadow, 1e-9);
        }
}
END_TEST

static void add_cone(vec3 base, vec3 axis, double radius, double height)
{
    struct pen_object_desc *o =
        kit_cylinder(&kit, base, axis, radius, height, kit_material(&kit, mirror_like(0)));
    o->kind = PEN_OBJECT_CONE;
    o->u.cone.base = base;
    o->u.cone.axis = axis;
    o->u.cone.radius = radius;
    o->u.cone.top_radius = 0;
    o->u.cone.height = height;
    o->u.cone.caps = true;
}

/* The apex, which has no tangent plane of its own, is lit as the side next to it that faces the
 * viewer: here by lights in the direction (cos a, 0, sin a), with a viewer on the side of +x. The
 * normal of that side is (2, 0, 1) / sqrt 5. */
START_TEST(test_horizon__apex_from_outside)
{
    for (int degrees = -115; degrees <= 242; degrees += 3) {
        const double a = degrees * M_PI / 180;
        kit_init(&kit);
        add_cone(pen_vec3(0, 0, -2), pen_vec3(0, 0, 1), 1, 2);
        kit.materials[0] = kit_matte(1);
        kit.view.camera.position = pen_vec3(1, 0, 3);
        kit.view.camera.has_look_at = true;
        kit.view.camera.look_at = pen_vec3(0, 0, 0);
        kit.settings.max_depth = 1;
        kit_directional(&kit, pen_vec3(-cos(a), 0, -sin(a)), pen_vec3(1, 1, 1));
        const double sine = (2 * cos(a) + sin(a)) / sqrt(5);
        struct pen_ray_counts rays;
        ck_assert_double_eq_tol(kit_pixel(&kit, 0, 0, &rays).x, fmax(0, sine), 1e-9);
        ck_assert_uint_eq(rays.shadow, sine > 0);
    }
}
END_TEST

/* The apex in the axis of the view takes the value of what is around it: for every light in the
 * axis the cosine of the side's slope. */
START_TEST(test_horizon__apex_along_the_axis)
{
    static const double heights[] = {0.1, 1, 3, 50};
    for (int i = 0; i < 8; i++) {
        const double h = heights[i / 2], side = 1 / sqrt(1 + h * h);
        struct pen_material m = kit_matte(1);
        kit_init(&kit);
        add_cone(pen_vec3(0, 0, -h), pen_vec3(0, 0, 1), 1, h);
        if (i & 1) /* a highlight on the apex alone would be a dot */
            m.ks = pen_vec3(1, 1, 1), m.shininess = 1000;
        kit.materials[0] = m;
        kit.settings.max_depth = 1;
        kit_directional(&kit, pen_vec3(0, 0, -1), pen_vec3(1, 1, 1));
        const double highlight = i & 1 ? pow(fmax(0, 2 * side * side - 1), 1000) : 0;
        ck_assert_double_eq_tol(kit_pixel(&kit, 0, 0, NULL).x, side + highlight, 1e-9);
    }
}
END_TEST

/* From inside a closed cone its apex is dark, wherever the light outside is. */
START_TEST(test_horizon__apex_from_inside)
{
    for (int i = 0; i < 100; i++) {
        double turn = 0.01 * M_PI * i;
        kit_init(&kit);
        add_cone(pen_vec3(0, 0, 20), pen_vec3(0, 0, -1), 4, 18);
        kit_directional(&kit, pen_vec3(cos(turn), 0.1, -sin(turn)), pen_vec3(1, 1, 1));
        expect(0, 0);
    }
}
END_TEST

PEN_SUITE("horizon", test_horizon__flat, test_horizon__near_light, test_horizon__small_sphere,
          test_horizon__disk, test_horizon__apex_from_outside, test_horizon__apex_along_the_axis,
          test_horizon__apex_from_inside)
