/* SPDX-License-Identifier: MIT */
/* Rays that meet an edge of mirrors or of glass exactly: small copies of scenes seen head-on. */
#include <math.h>

#include "shade/glass.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;

/* The picture's size and the angle of view. */
static void look(vec3 eye, vec3 at, double fov_degrees, int width, int height)
{
    kit.view.camera.position = eye;
    kit.view.camera.direction = pen_sub(at, eye);
    kit.view.camera.fov_degrees = fov_degrees;
    kit.settings.width = width;
    kit.settings.height = height;
}

static vec3 pixel(int x, int y)
{
    struct pen_ray_counts rays;
    return kit_pixel(&kit, x, y, &rays);
}

static void assert_near(vec3 got, vec3 want, double within)
{
    ck_assert_msg(pen_norm1(pen_sub(got, want)) <= within, "(%g %g %g), want (%g %g %g)", got.x,
                  got.y, got.z, want.x, want.y, want.z);
}

/* Two mirrors at a right angle: a ray into the edge meets both, and goes back. */
START_TEST(test_corners__two_planes)
{
    struct pen_material m = kit_glow(.1, .1, .1);
    m.kr = pen_vec3(.8, .8, .8);
    kit_init(&kit);
    const int mirror = kit_material(&kit, m);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(1, 0, 0), mirror);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), mirror);
    kit.desc.background = pen_vec3(1, 1, 1);
    kit.settings.max_depth = 6;
    look(pen_vec3(5, 0, 5), pen_vec3(0, 0, 0), 30, 21, 21);
    for (int y = 0; y < 21; y += 5) {
        struct pen_ray_counts rays = {0};
        assert_near(kit_pixel(&kit, 10, y, &rays), pen_vec3(.82, .82, .82), 1e-13);
        ck_assert_uint_eq(rays.primary, 1);
        ck_assert_uint_eq(rays.reflection, 2);
    }
}
END_TEST

/* A room of six mirrors that are lit: a pixel on a diagonal is between its neighbours. */
START_TEST(test_corners__polished_room)
{
    struct pen_material m = kit_matte(.4);
    const vec3 axis[3] = {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
    struct convex unused;
    m.kr = pen_vec3(.3, .3, .3);
    kit_init(&kit);
    glass_box(&kit, pen_vec3(0, 0, 0), axis, kit_material(&kit, m), &unused);
    kit_point(&kit, pen_vec3(.3, .7, .2), pen_vec3(.6, .6, .6));
    kit.settings.max_depth = 6;
    look(pen_vec3(0, 0, 1.5), pen_vec3(0, 0, -2), 80, 800, 600);
    for (int y = 3; y < 300; y += 27) {
        const int x = y + 100;
        const double a = pixel(x - 1, y).y, b = pixel(x, y).y, c = pixel(x + 1, y).y;
        ck_assert_msg(b >= fmin(a, c) - 2e-3 && b <= fmax(a, c) + 2e-3, "%d: %g %g %g", y, a, b, c);
    }
}
END_TEST

/* A glass cube seen from its front: a ray in it meets the edge of its back and a side. */
START_TEST(test_corners__glass_cube)
{
    const vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    struct convex unused;
    glass_begin(&kit, 8);
    glass_box(&kit, pen_vec3(0, 0, 0), axis, glass_material(&kit, 1.5), &unused);
    kit.desc.has_sky = true;
    kit.desc.background = pen_vec3(.5, .5, .5);
    kit.desc.sky.zenith = pen_vec3(.1, .3, .9);
    kit.desc.sky.nadir = pen_vec3(.9, .4, .1);
    kit.desc.sky.up = pen_vec3(0, 1, 0);
    look(pen_vec3(0, 0, 6), pen_vec3(0, 0, 0), 30, 800, 600);
    assert_near(pixel(590, 490), pen_vec3(.439, .468, .561), 2e-3);
}
END_TEST

PEN_SUITE("corners", test_corners__two_planes, test_corners__polished_room,
          test_corners__glass_cube)
