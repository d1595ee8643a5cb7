/* SPDX-License-Identifier: MIT */
/* Transmittance between a point and a light: which surfaces count, and with which colour. The pixel
 * looks straight down on the plane z = 0; the light is above it. */
#include "support/kit.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

static void floor_and_light(void)
{
    kit_init(&kit);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), kit_material(&kit, kit_matte(1)));
    kit_point(&kit, pen_vec3(8, 0, 8), pen_vec3(1, 1, 1));
}

static int glass(double r, double g, double b)
{
    struct pen_material m = kit_matte(0);
    m.kt = pen_vec3(r, g, b);
    return kit_material(&kit, m);
}

/* A square sheet at height z, around the shadow ray, away from the camera's view. */
static struct pen_object_desc *sheet(double z, int material)
{
    double x = z; /* the shadow ray goes through (z, 0, z) */
    const vec3 v[] = {{x - 0.1, -1, z}, {x + 0.1, -1, z}, {x + 0.1, 1, z}, {x - 0.1, 1, z}};
    return kit_polygon(&kit, v, 4, material);
}

/* The pixel is `want` times its colour without anything before the light, bit for bit. */
static void assert_shadow(vec3 want)
{
    struct pen_ray_counts rays;
    uint32_t objects = kit.desc.object_count;
    kit.desc.object_count = 1;
    vec3 lit = kit_pixel(&kit, 0, 0, NULL);
    kit.desc.object_count = objects;
    for (int accelerator = PEN_ACCEL_AUTO; accelerator < PEN_ACCEL_COUNT; accelerator++) {
        kit.settings.accelerator = accelerator;
        vec3 got = kit_pixel(&kit, 0, 0, &rays);
        ck_assert_uint_eq(rays.shadow, 1);
        for (int c = 0; c < 3; c++) {
            double expected = pen_component(lit, c) * pen_component(want, c);
            ck_assert_msg(pen_component(got, c) == expected, "channel %d: %a, want %a", c,
                          pen_component(got, c), expected);
        }
    }
}

START_TEST(test_shadow__opaque_blocks)
{
    floor_and_light();
    assert_shadow(pen_vec3(1, 1, 1));
    sheet(4, -1);
    assert_shadow(pen_vec3(0, 0, 0));
}
END_TEST

START_TEST(test_shadow__only_strictly_between)
{
    floor_and_light();
    sheet(9, -1); /* beyond the light */
    sheet(-1, -1);
    assert_shadow(pen_vec3(1, 1, 1));
    sheet(8, -1); /* contains the light */
    assert_shadow(pen_vec3(1, 1, 1));
    kit_plane(&kit, pen_vec3(8, 0, 8), pen_vec3(0.3, 0.1, 1), -1); /* so does this, tilted */
    assert_shadow(pen_vec3(1, 1, 1));
}
END_TEST

START_TEST(test_shadow__a_light_in_a_glass_sphere)
{
    floor_and_light();
    kit_sphere(&kit, pen_vec3(8, 0, 8), 1, glass(0.5, 0.25, 0.75));
    assert_shadow(pen_vec3(0.5, 0.25, 0.75)); /* met once */
    kit_sphere(&kit, pen_vec3(4, 0, 4), 1, glass(0.5, 1, 0));
    assert_shadow(pen_vec3(0.125, 0.25, 0)); /* met twice */
}
END_TEST

START_TEST(test_shadow__colours_multiply_from_the_point_on)
{
    enum { SHEETS = 30 }; /* as many as one query holds, nearly */
    floor_and_light();
    vec3 want = {1, 1, 1}, colour[SHEETS];
    for (int i = 0; i < SHEETS; i++)
        colour[i] = pen_vec3(0.9 + 0.003 * i, 0.99 - 0.002 * (i % 7), 1 - 0.001 * i);
    for (int i = 0; i < SHEETS; i++) /* in the document in another order than in space */
        sheet(0.5 + 0.2 * (i * 7 % SHEETS),
              glass(colour[i * 7 % SHEETS].x, colour[i * 7 % SHEETS].y, colour[i * 7 % SHEETS].z));
    for (int i = 0; i < SHEETS; i++)
        want = pen_mul(want, colour[i]);
    assert_shadow(want);
}
END_TEST

START_TEST(test_shadow__more_sheets_than_a_query_holds)
{
    enum { SHEETS = 60 };
    floor_and_light();
    vec3 want = {1, 1, 1};
    for (int i = 0; i < SHEETS; i++) {
        vec3 colour = pen_vec3(0.9 + 0.001 * i, 0.99 - 0.002 * (i % 7), 1 - 0.001 * i);
        sheet(0.5 + 0.11 * i, glass(colour.x, colour.y, colour.z));
        want = pen_mul(want, colour);
    }
    sheet(8, glass(0, 0, 0)); /* with the light in it: it does not count */
    sheet(8.5, -1);
    assert_shadow(want);
    sheet(0.25, -1);
    assert_shadow(pen_vec3(0, 0, 0));
}
END_TEST

/* As before, with surfaces through the light that rounding puts before or behind it. */
START_TEST(test_shadow__more_sheets_and_a_light_on_walls)
{
    floor_and_light();
    vec3 light = pen_vec3(8.1, 0.3, 7.7), want = {1, 1, 1};
    kit.lights[0].position = light;
    for (int i = 0; i < 40; i++) {
        vec3 colour = pen_vec3(0.9 + 0.001 * i, 0.99 - 0.002 * (i % 7), 1 - 0.001 * i);
        vec3 c = pen_scale(light, 0.1 + 0.02 * i);
        const vec3 v[] = {{c.x - 0.2, c.y - 1, c.z},
                          {c.x + 0.2, c.y - 1, c.z},
                          {c.x + 0.2, c.y + 1, c.z},
                          {c.x - 0.2, c.y + 1, c.z}};
        kit_polygon(&kit, v, 4, glass(colour.x, colour.y, colour.z));
        want = pen_mul(want, colour);
    }
    int red = glass(0.5, 0, 0);
    for (int i = 0; i < 40; i++)
        kit_plane(&kit, light, pen_vec3(1, 0.013 * i, -0.017 * i), i % 2 ? red : -1);
    assert_shadow(want);
}
END_TEST

START_TEST(test_shadow__h114_coincident_sheets_in_document_order)
{
    floor_and_light();
    const vec3 colour[] = {{0.9, 0.7, 0.3}, {0.8, 0.9, 0.1}, {0.7, 0.3, 0.9}, {0.3, 0.6, 0.7}};
    vec3 want = {1, 1, 1};
    for (int i = 0; i < 4; i++) {
        sheet(4, glass(colour[i].x, colour[i].y, colour[i].z));
        want = pen_mul(want, colour[i]);
    }
    assert_shadow(want);
}
END_TEST

START_TEST(test_shadow__opaque_among_glass)
{
    floor_and_light();
    sheet(3, glass(0.5, 0.5, 0.5));
    sheet(5, glass(0, 0.5, 0));
    assert_shadow(pen_vec3(0, 0.25, 0));
    sheet(4, -1);
    assert_shadow(pen_vec3(0, 0, 0));
}
END_TEST

START_TEST(test_shadow__directional_light_is_infinitely_far)
{
    floor_and_light();
    kit.desc.light_count = 0;
    kit_directional(&kit, pen_vec3(-1, 0, -1), pen_vec3(1, 1, 1));
    const vec3 far[] = {{1e9, -1e9, 1e9}, {2e9, 0, 1e9}, {1e9, 1e9, 1e9}, {0, 0, 1e9}};
    kit_polygon(&kit, far, 4, glass(0.25, 0.5, 1));
    assert_shadow(pen_vec3(0.25, 0.5, 1));
}
END_TEST

/* A primitive resting on the floor: the shadow begins where it stands. */
START_TEST(test_shadow__h065_shadow_begins_at_the_wall)
{
    kit_init(&kit);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), kit_material(&kit, kit_matte(1)));
    const vec3 wall[] = {{0, -4, 0}, {0, 4, 0}, {0, 4, 3}, {0, -4, 3}};
    kit_polygon(&kit, wall, 4, -1);
    kit_directional(&kit, pen_vec3(1, 0, -1), pen_vec3(1, 1, 1));
    kit.settings.width = 400;
    kit.settings.height = 3;
    kit.view.camera.has_view_plane = true;
    kit.view.camera.plane_distance = 10;
    kit.view.camera.plane_width = 8; /* 50 pixels to a unit */
    kit.view.camera.plane_height = 0.06;
    struct pen_scene *scene = kit_freeze(&kit);
    for (int x = 0; x < 400; x++) { /* the wall is seen edge-on, between pixels 199 and 200 */
        double rgb[3];
        struct pen_ray_counts rays;
        struct pen_status st;
        ck_assert(pen_render_pixel(scene, 0, &kit.settings, x, 1, rgb, &rays, &st));
        if (x < 200)
            ck_assert_double_gt(rgb[0], 0.5);
        else if (x < 200 + 150)
            ck_assert_double_eq(rgb[0], 0);
        else
            ck_assert_double_gt(rgb[0], 0.5);
    }
    pen_scene_free(scene);
}
END_TEST

/* The floor at the foot of a wall, seen from one side: light from that side arrives, light from the
 * other side does not. */
START_TEST(test_shadow__at_the_foot_of_a_wall)
{
    for (int side = -1; side <= 1; side += 2) {
        kit_init(&kit);
        kit.view.camera.position = pen_vec3(side * 5, 0, 10);
        kit.view.camera.direction = pen_vec3(-side * 5, 0, -10);
        kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), kit_material(&kit, kit_matte(1)));
        const vec3 wall[] = {{0, -4, 0}, {0, 4, 0}, {0, 4, 3}, {0, -4, 3}};
        kit_polygon(&kit, wall, 4, -1);
        kit_directional(&kit, pen_vec3(-side, 0, -1), pen_vec3(1, 0, 0));
        kit_directional(&kit, pen_vec3(side, 0, -1), pen_vec3(0, 1, 0));
        vec3 got = kit_pixel(&kit, 0, 0, NULL);
        ck_assert_double_gt(got.x, 0.5);
        ck_assert_double_eq(got.y, 0);
    }
}
END_TEST

/* The edge between two walls seen from very far: the hit point may be off both walls by more than
 * the rounding of its own coordinates, and neither may shadow it. */
START_TEST(test_shadow__corner_seen_from_afar)
{
    kit_init(&kit);
    int m = kit_material(&kit, kit_matte(1));
    for (int i = 0; i < 400; i++) {
        vec3 a = pen_normalize(pen_vec3(0.3 + 0.01 * (i % 20), 0.2, 1));
        vec3 b = pen_normalize(pen_vec3(1, 0.1 + 0.017 * (i % 31), -0.25));
        vec3 edge = pen_normalize(pen_cross(a, b)), eye = pen_add(a, b);
        kit.desc.object_count = kit.desc.light_count = 0;
        kit_plane(&kit, pen_vec3(0, 0, 0), a, m);
        kit_plane(&kit, pen_vec3(0, 0, 0), b, m);
        kit_sphere(&kit, pen_scale(a, -40), 1, m); /* keeps the local frame near the walls */
        kit_directional(&kit, pen_neg(pen_along(eye, edge, 0.1)), pen_vec3(1, 1, 1));
        kit.view.camera.direction = pen_neg(eye);
        kit.view.camera.position = pen_along(pen_scale(eye, 1e6 + i), edge, 0.01 * i);
        ck_assert_double_gt(kit_pixel(&kit, 0, 0, NULL).x, 0.1);
    }
}
END_TEST

PEN_SUITE("shadow", test_shadow__opaque_blocks, test_shadow__only_strictly_between,
          test_shadow__a_light_in_a_glass_sphere, test_shadow__colours_multiply_from_the_point_on,
          test_shadow__more_sheets_than_a_query_holds,
          test_shadow__h114_coincident_sheets_in_document_order, test_shadow__opaque_among_glass,
          test_shadow__directional_light_is_infinitely_far,
          test_shadow__h065_shadow_begins_at_the_wall,
          test_shadow__more_sheets_and_a_light_on_walls, test_shadow__at_the_foot_of_a_wall,
          test_shadow__corner_seen_from_afar)
