/* SPDX-License-Identifier: MIT */
/* Depth of field. Objects in focus are as sharp as through a pinhole; others are blurred over the
 * circle of confusion. The camera looks along -z from z = 10. */
#include <math.h>
#include <stdlib.h>

#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

static struct kit kit;

/* A bright half-plane x >= edge at depth z, perpendicular to the view. */
static void half_plane(double z, double edge)
{
    const struct pen_vec3 v[4] = {{edge, -1e3, z}, {1e3, -1e3, z}, {1e3, 1e3, z}, {edge, 1e3, z}};
    kit_polygon(&kit, v, 4, kit_material(&kit, kit_glow(1, 1, 1)));
}

static float *film(bool lens)
{
    kit.view.camera.aperture_radius = lens ? 2 : 0;
    struct pen_scene *scene = kit_freeze(&kit);
    const unsigned effects = pen_scene_effects(scene, 0, &kit.settings);
    ck_assert_int_eq((effects & PEN_FX_DEPTH_OF_FIELD) != 0, lens);
    float *rgb = kit_film(scene, &kit.settings, 1);
    pen_scene_free(scene);
    return rgb;
}

/* H126: all rays of a lens through one point of the image meet in the plane in focus. With the same
 * points of the image, the picture is the pinhole's. */
START_TEST(test_lens__h126_in_focus_as_sharp_as_a_pinhole)
{
    enum { SIDE = 24 };
    struct random r = random_begin(412);
    for (int i = 0; i < 20; i++) {
        kit_init(&kit);
        kit.settings.width = kit.settings.height = SIDE;
        kit.settings.samples_per_pixel = kit.settings.lens_samples = 8;
        kit.view.camera.focus_distance = 7;
        for (int k = 0; k < 3; k++) {
            struct pen_vec3 v[3];
            for (int c = 0; c < 3; c++)
                v[c] = pen_vec3(random_in(&r, -4, 4), random_in(&r, -4, 4), 3);
            kit_triangle(&kit, v[0], v[1], v[2],
                         kit_material(&kit, kit_glow(random_unit(&r), random_unit(&r), 1)));
        }
        float *sharp = film(false), *in_focus = film(true);
        int beside = 0;
        for (int k = 0; k < 3 * SIDE * SIDE; k++)
            beside += sharp[k] != in_focus[k];
        ck_assert_int_eq(beside, 0);
        free(sharp);
        free(in_focus);
    }
}
END_TEST

/* H127: an aperture of 0 is a pinhole, whatever is in focus. */
START_TEST(test_lens__h127_no_aperture_is_a_pinhole)
{
    kit_medley(&kit);
    struct pen_scene *scene = kit_freeze(&kit);
    float *pinhole = kit_film(scene, &kit.settings, 1);
    pen_scene_free(scene);
    kit.view.camera.focus_distance = 1e-3;
    kit.settings.lens_samples = 64;
    float *closed = film(false);
    ck_assert_mem_eq(pinhole, closed,
                     3 * (size_t)kit.settings.width * (size_t)kit.settings.height * sizeof(float));
    free(pinhole);
    free(closed);
}
END_TEST

/* The share of a disk of radius 1 beyond a straight line at distance h from its middle. */
static double share_beyond(double h)
{
    return h <= -1 ? 1 : h >= 1 ? 0 : (acos(h) - h * sqrt(1 - h * h)) / acos(-1);
}

/* A point at distance t from the eye is spread over a circle of radius R |t - f| / f around it. The
 * mean over 16 seeds of 256 points is within 5 standard deviations, taken from the seeds. */
START_TEST(test_lens__edges_out_of_focus)
{
    static const double focus[] = {2, 5, 20, 1e6}, depth[] = {4, 6, 30};
    enum { SEEDS = 16 };
    for (size_t i = 0; i < 4 * 3; i++) {
        const double f = focus[i % 4], t = depth[i / 4], spread = 2 * fabs(t - f) / f;
        for (int k = -3; k <= 3; k++) {
            double sum = 0, squares = 0;
            kit_init(&kit);
            kit.view.camera.fov_degrees = 1e-6;
            kit.view.camera.focus_distance = f;
            kit.settings.lens_samples = 256;
            half_plane(10 - t, 0.3 * k * spread);
            for (int seed = 0; seed < SEEDS; seed++) {
                kit.settings.seed = (uint64_t)seed;
                float *rgb = film(true);
                sum += (double)rgb[0];
                squares += (double)rgb[0] * (double)rgb[0];
                free(rgb);
            }
            const double mean = sum / SEEDS;
            const double deviation = sqrt(fmax(0, squares / SEEDS - mean * mean) / (SEEDS - 1));
            ck_assert_msg(fabs(mean - share_beyond(0.3 * k)) <= 5 * deviation + 1e-3,
                          "focus %g, depth %g, edge %d: %.4f, want %.4f", f, t, k, mean,
                          share_beyond(0.3 * k));
        }
    }
}
END_TEST

/* Each sample is one camera ray: the larger of samples_per_pixel and lens_samples. */
START_TEST(test_lens__rays_of_a_pixel)
{
    struct pen_ray_counts rays;
    kit_init(&kit);
    kit.view.camera.aperture_radius = 1;
    kit.view.camera.focus_distance = 5;
    for (int i = 0; i < 9; i++) {
        const int pixel = 1 + 3 * (i / 3), lens = 1 + 4 * (i % 3);
        kit.settings.samples_per_pixel = pixel;
        kit.settings.lens_samples = lens;
        kit_pixel(&kit, 0, 0, &rays);
        ck_assert_uint_eq(rays.primary, (uint64_t)(pixel > lens ? pixel : lens));
    }
}
END_TEST

PEN_SUITE("lens", test_lens__h126_in_focus_as_sharp_as_a_pinhole,
          test_lens__h127_no_aperture_is_a_pinhole, test_lens__edges_out_of_focus,
          test_lens__rays_of_a_pixel)
