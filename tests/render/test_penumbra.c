/* SPDX-License-Identifier: MIT */
/* How fast the error of a soft shadow falls with the number of shadow rays, for each pattern. The
 * oracle is in closed form: a disk light that faces the point, cut by a straight edge at distance
 * d of its centre, in radii, is visible by (acos d - d sqrt(1 - d^2)) / pi. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "support/kit.h"
#include "support/suite.h"

enum { SIZE = 64, THREADS = 2 };

static const double light_height = 10, edge_height = 5, eye_height = 4, reach = 1.1;

static struct kit kit;

/* A floor at z = 0 below a light, seen from straight above by a camera that sees x and y up to
 * `reach`; with a half plane between them, which ends at x = 0, or without. */
static float *film_of(bool half_plane, int pattern, int samples, uint64_t seed,
                      struct pen_ray_counts *rays)
{
    kit_init(&kit);
    kit.settings.width = kit.settings.height = SIZE;
    kit.settings.light_pattern = pattern;
    kit.settings.light_samples = samples;
    kit.settings.seed = seed;
    kit.view.camera.position = pen_vec3(0, 0, eye_height);
    kit.view.camera.fov_degrees = 2 * atan(reach / eye_height) * 180 / acos(-1);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), kit_material(&kit, kit_matte(1)));
    const struct pen_vec3 half[] = {{0, -500, edge_height},
                                    {0, 500, edge_height},
                                    {-500, 500, edge_height},
                                    {-500, -500, edge_height}};
    if (half_plane)
        kit_polygon(&kit, half, 4, 0);
    kit_point(&kit, pen_vec3(0, 0, light_height), pen_vec3(0.5, 0.5, 0.5))->radius = 1;
    struct pen_scene *scene = kit_freeze(&kit);
    float *film = kit_film(scene, &kit.settings, THREADS);
    if (rays) {
        kit_pixel(&kit, SIZE / 2, SIZE / 2, rays);
    }
    pen_scene_free(scene);
    return film;
}

/* The visible share of the light from the middle of a pixel. The plane through the point and the
 * edge cuts the disk's plane along a line; `sine` is that of the angle between it and the direction
 * to the light. */
static double visible_share(int px, int py)
{
    const double x = reach * (2 * (px + 0.5) / SIZE - 1), y = reach * (2 * (py + 0.5) / SIZE - 1);
    const double far = sqrt(x * x + y * y + light_height * light_height);
    const double across = (edge_height * -x + x * light_height) /
                          sqrt(edge_height * edge_height + x * x),
                 sine = across / far, d = -far * sine / sqrt(1 - sine * sine);
    if (fabs(d) >= 1)
        return d < 0;
    return (acos(d) - d * sqrt(1 - d * d)) / acos(-1);
}

/* The root mean square error of the visible share, over the pixels in the penumbra and four seeds.
 */
static double rmse_of(int pattern, int samples)
{
    double squares = 0;
    int count = 0;
    float *open = film_of(false, PEN_PATTERN_SOBOL, 1, 0, NULL);
    for (uint64_t seed = 0; seed < 4; seed++) {
        float *film = film_of(true, pattern, samples, seed, NULL);
        for (int i = 0; i < SIZE * SIZE; i++) {
            const double share = visible_share(i % SIZE, i / SIZE);
            if (!(share > 0 && share < 1))
                continue;
            const double error = (double)film[3 * i] / (double)open[3 * i] - share;
            squares += error * error;
            count++;
        }
        free(film);
    }
    free(open);
    ck_assert_int_gt(count, 4 * SIZE * SIZE / 2);
    return sqrt(squares / count);
}

/* The slope of log error over log samples, by least squares, from 16 to 4096 samples. */
static double slope_of(int pattern)
{
    double x[5], y[5], mean_x = 0, mean_y = 0, xx = 0, xy = 0;
    for (int i = 0; i < 5; i++) {
        const int samples = 16 << (2 * i);
        x[i] = log(samples);
        y[i] = log(rmse_of(pattern, samples));
        printf("  %d samples: RMSE %.2e\n", samples, exp(y[i]));
        mean_x += x[i] / 5;
        mean_y += y[i] / 5;
    }
    for (int i = 0; i < 5; i++) {
        xx += (x[i] - mean_x) * (x[i] - mean_x);
        xy += (x[i] - mean_x) * (y[i] - mean_y);
    }
    return xy / xx;
}

START_TEST(test_penumbra__errors_fall_as_expected)
{
    const double random = slope_of(PEN_PATTERN_RANDOM);
    printf("random: %.3f\n", random);
    const double grid = slope_of(PEN_PATTERN_GRID);
    printf("grid: %.3f\n", grid);
    const double sobol = slope_of(PEN_PATTERN_SOBOL);
    printf("sobol: %.3f\n", sobol);
    ck_assert_msg(fabs(random + 0.50) <= 0.05, "random: %.3f", random);
    ck_assert_msg(fabs(grid + 0.73) <= 0.05, "grid: %.3f", grid);
    ck_assert_msg(sobol <= -0.70, "sobol: %.3f", sobol);
}
END_TEST

START_TEST(test_penumbra__128_sobol_points_are_no_worse_than_a_grid_of_256)
{
    const double sobol = rmse_of(PEN_PATTERN_SOBOL, 128), grid = rmse_of(PEN_PATTERN_GRID, 256);
    struct pen_ray_counts rays;
    free(film_of(true, PEN_PATTERN_GRID, 256, 0, &rays));
    printf("128 Sobol' points: %.3e, the grid's %llu: %.3e\n", sobol,
           (unsigned long long)rays.shadow, grid);
    ck_assert_msg(rays.shadow > 190 && rays.shadow < 212, "%llu rays",
                  (unsigned long long)rays.shadow);
    ck_assert_msg(sobol <= grid, "%g, the grid %g", sobol, grid);
}
END_TEST

PEN_SUITE("penumbra", test_penumbra__errors_fall_as_expected,
          test_penumbra__128_sobol_points_are_no_worse_than_a_grid_of_256)
