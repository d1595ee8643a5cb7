/* SPDX-License-Identifier: MIT */
/* Layers against closed forms. The camera looks along -z from z = 10, with a field of view of 50
 * degrees. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render/layers.h"
#include "support/kit.h"
#include "support/suite.h"

enum { WIDTH = 37, HEIGHT = 29 }; /* blocks at the right and the bottom are not whole */

static struct kit kit;

static float *layer_of(enum pen_layer layer, enum pen_cost cost, int threads)
{
    struct pen_status st;
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_thread_pool *pool = pen_thread_pool_new(threads, &st);
    const size_t values = 3 * (size_t)kit.settings.width * (size_t)kit.settings.height;
    float *rgb = malloc(values * sizeof *rgb);
    ck_assert(scene && pool && rgb);
    for (size_t i = 0; i < values; i++)
        rgb[i] = NAN;
    const struct pen_layer_task task = {
        .scene = scene, .settings = &kit.settings, .layer = layer, .cost = cost, .rgb = rgb};
    ck_assert(pen_layer_render(pool, &task, &st));
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
    return rgb;
}

/* The direction of the ray through the middle of pixel i. */
static struct pen_vec3 direction_of(int i)
{
    const double tall = 2 * tan(25 * acos(-1) / 180), pixel = tall / HEIGHT;
    const double x = (i % WIDTH + 0.5 - WIDTH / 2.0) * pixel;
    return pen_normalize(pen_vec3(x, (HEIGHT / 2.0 - i / WIDTH - 0.5) * pixel, -1));
}

/* A ball of radius 2 at z = 3, with other samples, a lens and glass around it that must make no
 * difference to what the middle of a pixel shows. */
static void ball(void)
{
    static const struct pen_pattern halves = {
        .a = {1, 0, 0}, .b = {0, 1, 0}, .from = {0, -2, 3}, .to = {0, 2, 3}};
    static const struct pen_patterns patterns = {.of = {[PEN_COLOUR_KD] = &halves}};
    struct pen_material m = kit_matte(0.5);
    kit_init(&kit);
    kit.settings.width = WIDTH;
    kit.settings.height = HEIGHT;
    kit.settings.samples_per_pixel = 4;
    kit.settings.lens_samples = 7;
    kit.view.camera.aperture_radius = 1;
    kit.view.camera.focus_distance = 5;
    m.patterns = &patterns;
    kit_sphere(&kit, pen_vec3(0, 0, 3), 2, kit_material(&kit, m));
    kit_point(&kit, pen_vec3(0, 9, 9), pen_vec3(1, 1, 1));
}

/* The distance of the ball along a ray; 0 if it is not met. */
static double distance_along(struct pen_vec3 d)
{
    const double b = -7 * d.z, square = b * b - (49 - 4);
    return square > 0 ? b - sqrt(square) : 0;
}

START_TEST(test_layers__depth_normal_and_albedo_of_a_ball)
{
    ball();
    float *depth = layer_of(PEN_LAYER_DEPTH, PEN_COST_TIME, 2);
    float *normal = layer_of(PEN_LAYER_NORMAL, PEN_COST_TIME, 2);
    float *albedo = layer_of(PEN_LAYER_ALBEDO, PEN_COST_TIME, 2);
    int met = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const struct pen_vec3 d = direction_of(i);
        const double t = distance_along(d), z = 10 + t * d.z;
        const double n[3] = {t * d.x / 2, t * d.y / 2, (z - 3) / 2};
        for (int c = 0; c < 3; c++) {
            ck_assert_double_eq_tol(depth[3 * i + c], t, 1e-6 * t + 1e-300);
            ck_assert_double_eq_tol(normal[3 * i + c], t > 0 ? (n[c] + 1) / 2 : 0, 1e-6);
        }
        const double up = t > 0 ? (t * d.y + 2) / 4 : 0;
        ck_assert_double_eq_tol(albedo[3 * i], t > 0 ? 1 - up : 0, 1e-6);
        ck_assert_double_eq_tol(albedo[3 * i + 1], up, 1e-6);
        met += t > 0;
    }
    ck_assert_int_gt(met, 50);
    free(depth);
    free(normal);
    free(albedo);
}
END_TEST

/* From inside, the normal points inward; of coincident sheets the first in the document counts. */
START_TEST(test_layers__the_viewers_side_and_the_first_sheet)
{
    kit_init(&kit);
    kit_sheet(&kit, 0, 3, kit_material(&kit, kit_matte(0.25)));
    kit_sheet(&kit, 0, 3, kit_material(&kit, kit_matte(0.75)));
    kit_sphere(&kit, pen_vec3(0, 0, 10), 20, kit_material(&kit, kit_matte(0.1)));
    float *albedo = layer_of(PEN_LAYER_ALBEDO, PEN_COST_TIME, 1);
    ck_assert(albedo[0] == 0.25F);
    free(albedo);
    kit.desc.objects[0] = kit.desc.objects[2];
    kit.desc.object_count = 1;
    float *normal = layer_of(PEN_LAYER_NORMAL, PEN_COST_TIME, 1);
    ck_assert_double_eq_tol(normal[2], 1, 1e-6);
    free(normal);
}
END_TEST

START_TEST(test_layers__samples_are_those_of_lens_and_pixel)
{
    ball();
    float *samples = layer_of(PEN_LAYER_SAMPLES, PEN_COST_TIME, 1);
    ck_assert(samples[0] == 7 && samples[3 * WIDTH * HEIGHT - 1] == 7);
    free(samples);
    kit.view.camera.aperture_radius = 0;
    samples = layer_of(PEN_LAYER_SAMPLES, PEN_COST_TIME, 1);
    ck_assert(samples[0] == 4);
    free(samples);
}
END_TEST

/* The tests of all pixels are those that a render counts, for any number of threads. */
START_TEST(test_layers__tests_add_up)
{
    struct pen_status st;
    kit_medley(&kit);
    float *one = layer_of(PEN_LAYER_COST, PEN_COST_TESTS, 1);
    float *two = layer_of(PEN_LAYER_COST, PEN_COST_TESTS, 2);
    const size_t values = 3 * (size_t)kit.settings.width * (size_t)kit.settings.height;
    ck_assert_mem_eq(one, two, values * sizeof *one);
    double sum = 0;
    for (size_t i = 0; i < values; i += 3)
        sum += (double)one[i];
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_thread_pool *pool = pen_thread_pool_new(1, &st);
    struct pen_render_stats stats;
    const struct pen_render_task task = {.scene = scene,
                                         .settings = &kit.settings,
                                         .tile_count = -1,
                                         .rgb = two,
                                         .count_tests = true};
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    ck_assert(sum == (double)(stats.tests.boxes + stats.tests.primitives));
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
    free(one);
    free(two);
}
END_TEST

/* Times are above 0 everywhere, and larger where more is tested. */
START_TEST(test_layers__times_follow_the_tests)
{
    kit_medley(&kit);
    const size_t pixels = (size_t)kit.settings.width * (size_t)kit.settings.height;
    float *tests = layer_of(PEN_LAYER_COST, PEN_COST_TESTS, 1);
    float *time = layer_of(PEN_LAYER_COST, PEN_COST_TIME, 1);
    for (size_t i = 0; i < pixels; i++)
        ck_assert(time[3 * i] > 0 && time[3 * i] == time[3 * i + 2]);
    for (size_t i = 1; i < 8; i++) /* of the first row of the first block */
        ck_assert_double_eq_tol(time[3 * i] / time[0], tests[3 * i] / tests[0], 1e-5);
    free(tests);
    free(time);
}
END_TEST

START_TEST(test_layers__shown)
{
    float depth[] = {2, 2, 2, 4, 4, 4, 0, 0, 0}, cost[] = {16, 16, 16, 1, 1, 1, 0, 0, 0};
    float normal[] = {0.5F, 0.5F, 1};
    ck_assert(pen_layer_show(PEN_LAYER_DEPTH, depth, 3) == 2);
    ck_assert(depth[0] == 1 && depth[3] == 0.5F && depth[6] == 0);
    ck_assert(pen_layer_show(PEN_LAYER_COST, cost, 3) == 16);
    ck_assert(cost[0] == 1 && cost[1] == 1); /* white, but for blue */
    ck_assert(cost[3] == 0.75F && cost[6] == 0);
    ck_assert(pen_layer_show(PEN_LAYER_NORMAL, normal, 1) == 0);
    ck_assert(normal[0] == 0.5F);
}
END_TEST

PEN_SUITE("layers", test_layers__depth_normal_and_albedo_of_a_ball,
          test_layers__the_viewers_side_and_the_first_sheet,
          test_layers__samples_are_those_of_lens_and_pixel, test_layers__tests_add_up,
          test_layers__times_follow_the_tests, test_layers__shown)
