/* SPDX-License-Identifier: MIT */
/* Targets where light is small and bright: pictures against closed forms. */
#include <math.h>
#include <stdlib.h>

#include "film/encode.h"
#include "support/kit.h"
#include "support/suite.h"

static struct kit kit;

enum { SIDE = 32 };

static struct pen_render_stats render(float *rgb)
{
    struct pen_status st;
    struct pen_render_stats stats;
    struct pen_thread_pool *pool = pen_thread_pool_new(1, &st);
    struct pen_scene *scene = kit_freeze(&kit);
    const struct pen_render_task task = {
        .scene = scene, .settings = &kit.settings, .tile_count = -1, .rgb = rgb};
    ck_assert_msg(pen_render_run(pool, &task, &stats, &st), "%s", st.msg);
    pen_scene_free(scene);
    pen_thread_pool_free(pool);
    free(stats.tile_ms);
    return stats;
}

/* Pixels of side 1 / 4 in the plane z = 0. */
static void begin(double target)
{
    kit_init(&kit);
    kit.settings.width = kit.settings.height = SIDE;
    kit.settings.transfer = PEN_SETTING_LINEAR;
    kit.settings.target_error = target;
    kit.settings.max_samples = 65536;
    kit.view.camera.fov_degrees = 2 * atan(4.0 / 10) * 180 / acos(-1);
}

/* The share of a pixel that a sphere covers, from rays through 256 x 256 points. */
static double covered(const struct pen_object_desc *sphere, int x, int y)
{
    enum { POINTS = 256 };
    const struct pen_vec3 c = sphere->u.sphere.center;
    const double r = sphere->u.sphere.radius, cz = c.z - 10;
    const double inside = c.x * c.x + c.y * c.y + cz * cz - r * r;
    int hits = 0;
    for (int i = 0; i < POINTS; i++)
        for (int k = 0; k < POINTS; k++) {
            const double dx = (x + (i + 0.5) / POINTS) / 4 - 4,
                         dy = 4 - (y + (k + 0.5) / POINTS) / 4;
            const double along = dx * c.x + dy * c.y - 10 * cz;
            hits += along * along > inside * (dx * dx + dy * dy + 100);
        }
    return (double)hits / (POINTS * POINTS);
}

static double unit(double v)
{
    return v < 1 ? v : 1;
}

/* Renders with eight seeds: how many of the pictures are beyond the target, which all report met.
 */
static int pictures_beyond(const float *want)
{
    static float rgb[3 * SIDE * SIDE];
    int beyond = 0;
    for (kit.settings.seed = 1; kit.settings.seed <= 8; kit.settings.seed++) {
        double sum = 0;
        const struct pen_render_stats stats = render(rgb);
        ck_assert(stats.adaptive.met && stats.adaptive.unproven == 0);
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double d = unit((double)rgb[3 * i]) - unit((double)want[i]);
            sum += d * d / (SIDE * SIDE);
        }
        beyond += sqrt(sum) > kit.settings.target_error;
    }
    return beyond;
}

/* Values of the spheres, which do not overlap, before black. */
static void want_spheres(float *want)
{
    for (int i = 0; i < SIDE * SIDE; i++) {
        double sum = 0;
        for (uint32_t k = 0; k < kit.desc.object_count; k++)
            sum += kit.materials[kit.objects[k].material].emission.x *
                   covered(&kit.objects[k], i % SIDE, i / SIDE);
        want[i] = (float)sum;
    }
}

START_TEST(test_beams__the_rim_of_a_lamp_is_seen)
{
    static float want[SIDE * SIDE];
    begin(0.005);
    kit_sphere(&kit, pen_vec3(-0.0637, 0.0323, 0), 1, kit_material(&kit, kit_glow(100, 100, 100)));
    want_spheres(want);
    ck_assert_int_eq(pictures_beyond(want), 0);
}
END_TEST

START_TEST(test_beams__dots_smaller_than_a_pixel_are_seen)
{
    static float want[SIDE * SIDE];
    begin(0.002);
    for (int i = 0; i < 16; i++)
        kit_sphere(&kit, pen_vec3(0.83 * (i % 4) - 1.3, 0.87 * (i / 4) - 1.2, 0), 0.01 + 0.004 * i,
                   kit_material(&kit, kit_glow(1, 1, 1)));
    want_spheres(want);
    ck_assert_int_eq(pictures_beyond(want), 0);
}
END_TEST

/* A wire across all pixels of a row shows each of them its width. */
START_TEST(test_beams__a_wire_is_seen_in_every_pixel)
{
    static float want[SIDE * SIDE];
    begin(0.0002);
    kit_cylinder(&kit, pen_vec3(-9, 0.1, 0), pen_vec3(1, 0, 0), 0.00125, 18,
                 kit_material(&kit, kit_glow(1, 1, 1)));
    for (int i = 0; i < SIDE; i++)
        want[15 * SIDE + i] = 0.01F;
    ck_assert_int_eq(pictures_beyond(want), 0);
}
END_TEST

/* A light far out of focus: a disk of the lens's shape whose pixels each have the share of the
 * light that the lens spreads to them. All of it is there. */
START_TEST(test_beams__a_light_out_of_focus_keeps_its_light)
{
    static float rgb[3 * SIDE * SIDE];
    begin(0.01);
    kit.view.camera.aperture_radius = 1;
    kit.view.camera.focus_distance = 10;
    const double light = 10000, radius = 0.01;
    kit_sphere(&kit, pen_vec3(0, 0, -10), radius,
               kit_material(&kit, kit_glow(light, light, light)));
    /* At twice the distance a pixel has a side of 1 / 2; the middle of the lens sees the light in
     * such a share. */
    const double want = light * acos(-1) * radius * radius * 4;
    for (kit.settings.seed = 1; kit.settings.seed <= 4; kit.settings.seed++) {
        double sum = 0;
        ck_assert(render(rgb).adaptive.met);
        for (int i = 0; i < SIDE * SIDE; i++)
            sum += (double)rgb[3 * i];
        ck_assert_msg(fabs(sum / want - 1) < 0.1, "%g instead of %g", sum, want);
    }
}
END_TEST

/* A mirror at x = -1 and a lamp that only it shows: the picture is that of a lamp behind it. */
START_TEST(test_beams__a_lamp_in_a_mirror_is_seen)
{
    static float want[SIDE * SIDE];
    begin(0.005);
    kit_sphere(&kit, pen_vec3(-3.2, 0.03, 1), 0.02, kit_material(&kit, kit_glow(24, 24, 24)));
    want_spheres(want);
    begin(0.005);
    struct pen_material mirror = kit_matte(0);
    mirror.kr = pen_vec3(0.5, 0.5, 0.5);
    kit_sphere(&kit, pen_vec3(1.2, 0.03, 1), 0.02, kit_material(&kit, kit_glow(48, 48, 48)));
    kit_plane(&kit, pen_vec3(-1, 0, 0), pen_vec3(1, 0, 0), kit_material(&kit, mirror));
    for (int i = 0; i < SIDE * SIDE; i++) /* the lamp itself is seen, too */
        want[i] += (float)(48 * covered(&kit.objects[0], i % SIDE, i / SIDE));
    ck_assert_int_eq(pictures_beyond(want), 0);
}
END_TEST

PEN_SUITE("beams", test_beams__the_rim_of_a_lamp_is_seen,
          test_beams__dots_smaller_than_a_pixel_are_seen, test_beams__a_wire_is_seen_in_every_pixel,
          test_beams__a_light_out_of_focus_keeps_its_light, test_beams__a_lamp_in_a_mirror_is_seen)
