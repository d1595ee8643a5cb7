/* SPDX-License-Identifier: MIT */
/* Adaptive rendering: the rule against noise with a known error, pictures against closed forms, and
 * the same bytes for any division of the work. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render/forecast.h"
#include "render/layers.h"
#include "support/isa.h"
#include "support/kit.h"
#include "support/suite.h"

static struct kit kit;

/* A picture rendered in rounds, and the state that is left. */
struct picture {
    struct pen_adaptive *adaptive;
    struct pen_render_stats stats;
    float *rgb;
};

static size_t values_of(const struct pen_settings *s)
{
    return 3 * (size_t)s->width * (size_t)s->height;
}

static struct picture picture_of(const struct pen_scene *scene, const struct pen_settings *settings,
                                 int threads)
{
    struct pen_status st;
    struct pen_thread_pool *pool = pen_thread_pool_new(threads, &st);
    struct picture p = {.adaptive = pen_adaptive_new(settings, &st),
                        .rgb = calloc(values_of(settings), sizeof *p.rgb)};
    ck_assert(pool && p.adaptive && p.rgb);
    const struct pen_render_task task = {
        .scene = scene, .settings = settings, .tile_count = -1, .rgb = p.rgb};
    ck_assert_msg(pen_render_rounds(pool, &task, p.adaptive, &p.stats, &st), "%s", st.msg);
    pen_thread_pool_free(pool);
    return p;
}

static void picture_free(struct picture *p)
{
    pen_adaptive_free(p->adaptive);
    free(p->stats.tile_ms);
    free(p->rgb);
}

START_TEST(test_adaptive__same_film_for_threads_tiles_accelerators_and_instruction_sets)
{
    kit_medley(&kit);
    kit.settings.target_error = 0.02;
    struct pen_scene *scene = kit_freeze(&kit);
    float *want = kit_film(scene, &kit.settings, 1);
    static const int tiles[] = {1, 7, 100};
    for (int i = 0; i < 3; i++) {
        kit.settings.tile = tiles[i];
        float *got = kit_film(scene, &kit.settings, i + 1);
        ck_assert(memcmp(got, want, values_of(&kit.settings) * sizeof *got) == 0);
        free(got);
    }
    for (int isa = 0; isa < isa_count(); isa++) {
        isa_force(isa);
        float *got = kit_film(scene, &kit.settings, 2);
        ck_assert_msg(memcmp(got, want, values_of(&kit.settings) * sizeof *got) == 0, "ISA %d",
                      isa);
        free(got);
    }
    isa_release();
    pen_scene_free(scene);
    for (int kind = PEN_ACCEL_AUTO; kind < PEN_ACCEL_COUNT; kind++) {
        kit.settings.accelerator = kind;
        scene = kit_freeze(&kit);
        float *got = kit_film(scene, &kit.settings, 2);
        ck_assert_msg(memcmp(got, want, values_of(&kit.settings) * sizeof *got) == 0,
                      "accelerator %d", kind);
        free(got);
        pen_scene_free(scene);
    }
    free(want);
}
END_TEST

/* A half-plane of light x + slope y >= edge in the plane z = 0, of which each pixel of the picture
 * sees a square of side 1 / 4. */
static const double EDGE = 0.13, SLOPE = 0.3;

static void half_plane(void)
{
    kit_init(&kit);
    kit.settings.width = kit.settings.height = 24;
    kit.settings.transfer = PEN_SETTING_LINEAR;
    kit.view.camera.fov_degrees = 2 * atan(3.0 / 10) * 180 / acos(-1);
    const struct pen_vec3 v[] = {
        {EDGE - 100 * SLOPE, 100, 0}, {EDGE + 100 * SLOPE, -100, 0}, {200, -100, 0}, {200, 100, 0}};
    kit_polygon(&kit, v, 4, kit_material(&kit, kit_glow(0.8, 0.8, 0.8)));
}

/* The share of a pixel that the half-plane covers: the mean over 4096 lines of the covered part of
 * each, so that it is off by less than 10^-4. */
static double covered(int x, int y)
{
    enum { LINES = 4096 };
    double sum = 0;
    for (int i = 0; i < LINES; i++) {
        const double at = 3 - (y + (i + 0.5) / LINES) / 4;
        const double from = (EDGE - SLOPE * at + 3) * 4 - x;
        sum += 1 - fmin(1, fmax(0, from));
    }
    return sum / LINES;
}

static double half_plane_error(const float *rgb)
{
    double sum = 0;
    for (int i = 0; i < 24 * 24; i++) {
        const double d = (double)rgb[3 * i] - 0.8 * covered(i % 24, i / 24);
        sum += d * d;
    }
    return sqrt(sum / (24 * 24));
}

START_TEST(test_adaptive__edges_against_their_areas)
{
    static const double targets[] = {0.01, 0.004, 0.0015};
    int above = 0;
    half_plane();
    struct pen_scene *scene = kit_freeze(&kit);
    for (int t = 0; t < 3; t++) {
        double sum = 0, estimates = 0;
        for (uint64_t seed = 1; seed <= 8; seed++) {
            kit.settings.seed = seed;
            kit.settings.target_error = targets[t];
            struct picture p = picture_of(scene, &kit.settings, 1);
            const double error = half_plane_error(p.rgb);
            ck_assert(p.stats.adaptive.met);
            above += error > targets[t];
            sum += error;
            estimates += p.stats.adaptive.round[p.stats.adaptive.rounds - 1].error;
            picture_free(&p);
        }
        ck_assert_msg(sum / 8 >= targets[t] / 4, "%g: reached %g", targets[t], sum / 8);
        ck_assert_msg(estimates / sum > 0.9 && estimates / sum < 2, "%g: estimated %g, reached %g",
                      targets[t], estimates / 8, sum / 8);
    }
    ck_assert_int_le(above, 1);
    pen_scene_free(scene);
}
END_TEST

/* A floor under a disk light of radius 1 and height 8. A half-plane at half the height hides the
 * part of the disk with x < h from the floor's origin, which all pixels show. */
static void half_shadow(double h)
{
    kit_init(&kit);
    kit.settings.width = kit.settings.height = 2;
    kit.settings.transfer = PEN_SETTING_LINEAR;
    kit.view.camera.position = pen_vec3(0, -6, 3);
    kit.view.camera.direction = pen_vec3(0, 6, -3);
    kit.view.camera.fov_degrees = 1e-5;
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), kit_material(&kit, kit_matte(0.9)));
    kit_point(&kit, pen_vec3(0, 0, 8), pen_vec3(1, 1, 1))->radius = 1;
    const struct pen_vec3 v[] = {
        {h / 2, -100, 4}, {h / 2, 100, 4}, {-100, 100, 4}, {-100, -100, 4}};
    kit_polygon(&kit, v, 4, kit_material(&kit, kit_matte(0)));
}

/* The share of the unit disk with x > h. */
static double disk_beyond(double h)
{
    return (acos(h) - h * sqrt(1 - h * h)) / acos(-1);
}

/* A mean of 64 x 16 points that are one sequence is off by about 0.002, one of
 * the same 16 points again and again by 0.04. */
START_TEST(test_adaptive__points_on_lights_go_on_from_camera_ray_to_camera_ray)
{
    double squares = 0;
    int pixels = 0;
    half_shadow(0.3);
    kit.settings.target_error = 1e-9;
    kit.settings.max_samples = 128;
    struct pen_scene *scene = kit_freeze(&kit);
    for (uint64_t seed = 0; seed < 8; seed++) {
        kit.settings.seed = seed;
        struct picture p = picture_of(scene, &kit.settings, 1);
        for (int i = 0; i < 4; i++, pixels++) {
            const struct pen_pixel_sums *sums = &p.adaptive->sums[i];
            ck_assert_uint_eq(sums->samples, 128);
            for (int half = 0; half < 2; half++) {
                const double off = sums->sum[half][0] / 64 / 0.9 - disk_beyond(0.3);
                squares += off * off / 2;
            }
        }
        ck_assert(!p.stats.adaptive.met);
        ck_assert_uint_eq(p.stats.adaptive.capped, 4);
        picture_free(&p);
    }
    pen_scene_free(scene);
    ck_assert_msg(sqrt(squares / pixels) < 0.004, "%g", sqrt(squares / pixels));
}
END_TEST

START_TEST(test_adaptive__what_is_constant_stays_with_the_pilot)
{
    kit_init(&kit);
    kit.settings.width = 19;
    kit.settings.height = 11;
    kit.settings.target_error = 1e-6;
    kit_sheet(&kit, 0, 100, kit_material(&kit, kit_glow(0.2, 0.4, 0.6)));
    struct pen_scene *scene = kit_freeze(&kit);
    struct picture p = picture_of(scene, &kit.settings, 2);
    const struct pen_adaptive_stats *a = &p.stats.adaptive;
    ck_assert(a->met && a->rounds == 1 && a->round[0].pixels == 19 * 11);
    ck_assert(a->round[0].error == 0 && a->round[0].high == 0);
    ck_assert(a->samples.least == 4 && a->samples.most == 4 && a->samples.mean == 4);
    ck_assert_uint_eq(p.stats.rays.primary, 4 * 19 * 11);
    for (int i = 0; i < 19 * 11; i++)
        ck_assert(p.rgb[3 * i] == 0.2F && p.rgb[3 * i + 1] == 0.4F && p.rgb[3 * i + 2] == 0.6F);
    picture_free(&p);
    pen_scene_free(scene);
}
END_TEST

/* Pixels that are more than two away from any that the edge crosses have nothing to gain. */
START_TEST(test_adaptive__what_is_far_from_an_edge_stays_with_the_pilot)
{
    half_plane();
    kit.settings.target_error = 1e-3;
    struct pen_scene *scene = kit_freeze(&kit);
    struct picture p = picture_of(scene, &kit.settings, 1);
    int far = 0;
    for (int i = 0; i < 24 * 24; i++) {
        double least = 1, most = 0;
        for (int y = i / 24 - 3; y <= i / 24 + 3; y++)
            for (int x = i % 24 - 3; x <= i % 24 + 3; x++) {
                const double share = covered(x, y);
                least = fmin(least, share);
                most = fmax(most, share);
            }
        if (least < most)
            continue;
        far++;
        ck_assert_uint_eq(p.adaptive->sums[i].samples, pen_settings_pilot(&kit.settings));
    }
    ck_assert(far > 24 * 24 / 2 && p.stats.adaptive.met && p.stats.adaptive.rounds > 3);
    picture_free(&p);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_adaptive__max_samples_caps_every_pixel_and_says_so)
{
    static const int most[] = {4, 5, 16, 31};
    static const uint32_t taken[] = {4, 4, 16, 16};
    half_plane();
    kit.settings.target_error = 1e-5;
    struct pen_scene *scene = kit_freeze(&kit);
    for (int i = 0; i < 4; i++) {
        kit.settings.max_samples = most[i];
        struct picture p = picture_of(scene, &kit.settings, 1);
        ck_assert(!p.stats.adaptive.met && p.stats.adaptive.capped > 0);
        ck_assert_uint_eq(p.stats.adaptive.samples.most, taken[i]);
        picture_free(&p);
    }
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_adaptive__film_pixels_and_layers_tell_of_the_same_samples)
{
    struct pen_status st;
    half_plane();
    kit.settings.target_error = 0.004;
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    struct picture p = picture_of(scene, &kit.settings, 2);
    float *samples = calloc(values_of(&kit.settings), sizeof *samples);
    struct pen_layer_task task = {
        .scene = scene, .settings = &kit.settings, .layer = PEN_LAYER_SAMPLES, .rgb = samples};
    ck_assert(pen_layer_render(pool, &task, &st));
    double sum = 0;
    int noted = 0;
    for (int i = 0; i < 24 * 24; i++) {
        struct pen_ray_counts rays;
        double rgb[3];
        ck_assert(pen_render_refined_pixel(scene, 0, p.adaptive, i % 24, i / 24, rgb, &rays, &st));
        ck_assert(memcmp(rgb, (double[3]){rgb[0], rgb[0], rgb[0]}, sizeof rgb) == 0);
        ck_assert((float)rgb[0] == p.rgb[3 * i]);
        ck_assert((double)samples[3 * i] == (double)rays.primary);
        sum += (double)rays.primary;
        const struct pen_pixel_sums *sums = &p.adaptive->sums[i];
        ck_assert(sums->kept[0] == sums->samples / 2 && sums->kept[1] == sums->samples / 2);
        ck_assert(sums->samples > 4 || sums->before == 0);
        noted += sums->before > 0;
    }
    ck_assert_int_gt(noted, 24);
    ck_assert(sum == (double)p.stats.rays.primary);
    ck_assert(fabs(sum / (24 * 24) - p.stats.adaptive.samples.mean) < 1e-9);
    task.adaptive = p.adaptive; /* gives the same without rendering again */
    float *again = calloc(values_of(&kit.settings), sizeof *again);
    task.rgb = again;
    ck_assert(pen_layer_render(pool, &task, &st));
    ck_assert(memcmp(again, samples, values_of(&kit.settings) * sizeof *again) == 0);
    free(again);
    free(samples);
    picture_free(&p);
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
}
END_TEST

static void assert_forecast(double target)
{
    struct pen_status st;
    struct pen_forecast forecast;
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    kit.settings.target_error = target;
    const struct pen_forecast_task task = {.scene = scene, .settings = &kit.settings};
    ck_assert(pen_forecast_make(pool, &task, &forecast, &st));
    struct picture p = picture_of(scene, &kit.settings, 2);
    const double rays = (double)p.stats.rays.primary;
    ck_assert_msg(forecast.primary.low <= rays && rays <= forecast.primary.high,
                  "%g: %g rays, expected %g, %g to %g", target, rays, forecast.primary.expected,
                  forecast.primary.low, forecast.primary.high);
    ck_assert(forecast.time_ms.expected > 0 && forecast.time_ms.low <= forecast.time_ms.high);
    ck_assert(forecast.effects & PEN_FX_ANTI_ALIASING);
    picture_free(&p);
    pen_forecast_release(&forecast);
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
}

START_TEST(test_adaptive__forecasts_cover_the_rays_of_all_rounds)
{
    half_plane();
    kit.settings.width = kit.settings.height = 150;
    assert_forecast(0.02);
    assert_forecast(0.002);
    assert_forecast(0.0005);
    kit_medley(&kit);
    assert_forecast(0.05); /* smaller than the forecast's own pictures may be */
    assert_forecast(0.01);
}
END_TEST

/* Noise instead of rays: the picture's values are 0.5, and each sample of a pixel is off by a
 * normal number of that pixel's deviation. */
static double uniform(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return ((double)(*state >> 11) + 0.5) * 0x1p-53;
}

static double normal(uint64_t *state)
{
    const double radius = sqrt(-2 * log(uniform(state)));
    return radius * cos(2 * acos(-1) * uniform(state));
}

/* Smooth over a third of the picture, 16 times as large in a disk, and none beyond. */
static double deviation_at(int x, int y)
{
    const int u = x - 30, v = y - 30;
    if (x > 42)
        return 0;
    return u * u + v * v < 100 ? 0.16 : 0.01;
}

static void take_noise(struct pen_adaptive *a, uint64_t *state)
{
    const int width = a->settings->width;
    for (int i = 0; i < width * a->settings->height; i++) {
        struct pen_pixel_sums *sums = &a->sums[i];
        if (!a->wanted[i])
            continue;
        sums->samples += pen_adaptive_begin_pixel(a, (size_t)i);
        pen_pixel_double(sums);
        for (int half = 0; half < 2; half++)
            for (; sums->kept[half] < sums->samples / 2; sums->kept[half]++)
                for (int c = 0; c < 3; c++)
                    sums->sum[half][c] += 0.5 + deviation_at(i % width, i / width) * normal(state);
        pen_adaptive_estimate(a, (size_t)i, (float[3]){0});
    }
}

/* The root mean square of what the means are off. */
static double error_of(const struct pen_adaptive *a)
{
    const int pixels = a->settings->width * a->settings->height;
    double sum = 0, rgb[3];
    for (int i = 0; i < pixels; i++) {
        pen_pixel_mean(&a->sums[i], rgb);
        for (int c = 0; c < 3; c++)
            sum += (rgb[c] - 0.5) * (rgb[c] - 0.5);
    }
    return sqrt(sum / (3.0 * pixels));
}

START_TEST(test_adaptive__noise_is_brought_to_the_target_and_not_far_below)
{
    enum { PICTURES = 40 };
    uint64_t state = 1;
    double reached = 0, estimated = 0;
    int above = 0;
    struct pen_status st;
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    kit_init(&kit);
    kit.settings.width = kit.settings.height = 64;
    kit.settings.transfer = PEN_SETTING_LINEAR;
    kit.settings.max_samples = 1 << 20;
    for (int i = 0; i < PICTURES; i++) {
        struct pen_adaptive *a = pen_adaptive_new(&kit.settings, &st);
        const struct pen_goal goal = {0.005, UINT64_MAX};
        struct pen_decision d;
        for (int round = 1;; round++) {
            ck_assert_int_lt(round, 100);
            take_noise(a, &state);
            ck_assert(pen_adaptive_decide(a, pool, &goal, &d, &st));
            if (d.done)
                break;
            ck_assert_uint_gt(pen_adaptive_select(a, d.level), 0);
        }
        ck_assert(d.met && d.low <= d.error && d.error <= d.high && d.high <= 0.005);
        reached += error_of(a) / PICTURES;
        estimated += d.error / PICTURES;
        above += error_of(a) > 0.005;
        pen_adaptive_free(a);
    }
    pen_thread_pool_free(pool);
    ck_assert_int_le(above, PICTURES / 20);
    ck_assert_msg(reached > 0.003, "%g", reached);
    ck_assert_msg(estimated / reached > 0.95 && estimated / reached < 1.15, "%g",
                  estimated / reached);
}
END_TEST

PEN_SUITE("adaptive", test_adaptive__same_film_for_threads_tiles_accelerators_and_instruction_sets,
          test_adaptive__edges_against_their_areas,
          test_adaptive__points_on_lights_go_on_from_camera_ray_to_camera_ray,
          test_adaptive__what_is_constant_stays_with_the_pilot,
          test_adaptive__what_is_far_from_an_edge_stays_with_the_pilot,
          test_adaptive__max_samples_caps_every_pixel_and_says_so,
          test_adaptive__film_pixels_and_layers_tell_of_the_same_samples,
          test_adaptive__forecasts_cover_the_rays_of_all_rounds,
          test_adaptive__noise_is_brought_to_the_target_and_not_far_below)
