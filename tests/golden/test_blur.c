/* SPDX-License-Identifier: MIT */
/* Sampled effects converge to the oracle's mean over its own points (tests/support/oracle.h): depth
 * of field, glossy reflection, frosted transmission. Penumbra's pictures with 16 seeds and 16
 * pictures of the oracle are compared by Welch's t-test (Welch, Biometrika 34, 1947), pixel by
 * pixel, and as means of blocks of 8 x 8 pixels. The probability that any of these tests fails by
 * chance is 1e-4 for a picture (Bonferroni). With SHARP samples of the oracle a pixel, lens-balls
 * fails for a lens that is 3 % wider, and gloss-floor for such a cone:
 * tests/property/mutants.sh. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene_json.h"
#include "render/render.h"
#include "support/oracle.h"
#include "support/random.h"
#include "support/suite.h"

enum { WIDTH = 32, HEIGHT = 24, SIDE = 8, SEEDS = 16, BLURRED = 4 };
enum { OURS = 64, THEIRS = 256, FEW = 48, SHARP = 128 }; /* samples of a pixel */
enum { PIXELS = WIDTH * HEIGHT, BLOCKS = PIXELS / (SIDE * SIDE) };

/* A picture for each seed, or for each part of the oracle's samples. */
struct pictures {
    double value[SEEDS][PIXELS][3];
};

static struct pictures ours, theirs;

static char *file_text(const char *path, size_t *bytes)
{
    FILE *f = fopen(path, "rb");
    ck_assert_msg(f != NULL, "cannot open %s", path);
    static char text[1 << 16];
    *bytes = fread(text, 1, sizeof text, f);
    ck_assert_uint_lt(*bytes, sizeof text);
    fclose(f);
    return text;
}

static void render(const char *path, int samples)
{
    static struct pen_errors errors;
    struct pen_status st;
    struct pen_scene_desc desc;
    struct pen_limits limits = pen_limits_default();
    size_t bytes;
    char *text = file_text(path, &bytes);
    struct pen_arena *arena = pen_arena_new(0);
    ck_assert(pen_scene_load(text, bytes, &limits, arena, &desc, &errors));
    struct pen_scene *scene = pen_scene_freeze(&desc, PEN_ACCEL_AUTO, 0, &st);
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    ck_assert(scene && pool);
    for (int seed = 0; seed < SEEDS; seed++) {
        static float rgb[3 * PIXELS];
        struct pen_settings settings = desc.settings;
        settings.width = WIDTH;
        settings.height = HEIGHT;
        settings.seed = (uint64_t)seed;
        settings.samples_per_pixel = samples;
        settings.blur_samples = BLURRED;
        struct pen_render_task task = {
            .scene = scene, .settings = &settings, .tile_count = -1, .rgb = rgb};
        struct pen_render_stats stats;
        ck_assert(pen_render_run(pool, &task, &stats, &st));
        for (int i = 0; i < 3 * PIXELS; i++)
            ours.value[seed][i / 3][i % 3] = (double)rgb[i];
    }
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
    pen_arena_free(arena);
}

/* Independent points, uniform in the pixel and on the lens. */
static double uniform(void *user)
{
    return random_unit(user);
}

static struct oracle_camera_point any_point(struct random *r, int x, int y)
{
    struct oracle_camera_point at = {
        .x = x + random_unit(r), .y = y + random_unit(r), .uniform = uniform, .user = r};
    do {
        at.lens_x = random_in(r, -1, 1);
        at.lens_y = random_in(r, -1, 1);
    } while (at.lens_x * at.lens_x + at.lens_y * at.lens_y > 1);
    return at;
}

static void sample_oracle(const char *path, int few)
{
    struct random r = random_begin(501);
    struct oracle_scene *oracle = oracle_load(path, NULL);
    ck_assert(oracle != NULL);
    const int samples = random_some(THEIRS, few);
    for (int i = 0; i < SEEDS * PIXELS; i++) {
        double *mean = theirs.value[i / PIXELS][i % PIXELS], rgb[3];
        mean[0] = mean[1] = mean[2] = 0;
        for (int k = 0; k < samples; k++) {
            const struct oracle_camera_point at =
                any_point(&r, i % PIXELS % WIDTH, i % PIXELS / WIDTH);
            oracle_sample(oracle, WIDTH, HEIGHT, &at, rgb);
            for (int c = 0; c < 3; c++)
                mean[c] += rgb[c] / samples;
        }
    }
    oracle_free(oracle);
}

/* The regularised incomplete beta function I_x(a, b) by its continued fraction, for
 * x < (a + 1) / (a + b + 2) (Press et al., Numerical Recipes, 6.4). */
static double beta_below(double a, double b, double x)
{
    double c = 1, d = 1 / (1 - (a + b) * x / (a + 1)), h = d;
    for (int m = 1; m < 1000; m++) {
        double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        d = 1 / (1 + even * d);
        c = 1 + even / c;
        h *= d * c;
        double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        d = 1 / (1 + odd * d);
        c = 1 + odd / c;
        h *= d * c;
        if (fabs(d * c - 1) < 1e-13)
            break;
    }
    return exp(a * log(x) + b * log1p(-x) + lgamma(a + b) - lgamma(a) - lgamma(b)) * h / a;
}

/* The probability that |t| of Student's distribution is at least this. */
static double student_tails(double t, double freedom)
{
    const double x = freedom / (freedom + t * t), a = freedom / 2, b = 0.5;
    return x < (a + 1) / (a + b + 2) ? beta_below(a, b, x) : 1 - beta_below(b, a, 1 - x);
}

struct moments {
    double mean, variance; /* of the mean */
};

static struct moments moments_of(const double value[SEEDS])
{
    struct moments m = {0, 0};
    for (int i = 0; i < SEEDS; i++)
        m.mean += value[i] / SEEDS;
    for (int i = 0; i < SEEDS; i++)
        m.variance += (value[i] - m.mean) * (value[i] - m.mean) / (SEEDS - 1) / SEEDS;
    return m;
}

/* Welch's test: the probability of such a difference if both have the same mean. Values that do not
 * vary differ by rounding to floats at most. */
static double welch(const double a[SEEDS], const double b[SEEDS])
{
    const struct moments x = moments_of(a), y = moments_of(b);
    const double variance = x.variance + y.variance, apart = fabs(x.mean - y.mean);
    if (apart <= 2e-6 || variance <= 0)
        return apart <= 2e-6;
    const double freedom =
        (SEEDS - 1) * variance * variance / (x.variance * x.variance + y.variance * y.variance);
    return student_tails(apart / sqrt(variance), freedom);
}

/* The values of a pixel, or the means of a block of pixels, by seed. */
static void values_at(const struct pictures *p, int left, int top, int side, int c,
                      double out[SEEDS])
{
    for (int seed = 0; seed < SEEDS; seed++) {
        out[seed] = 0;
        for (int i = 0; i < side * side; i++) {
            const int x = left + i % side, y = top + i / side;
            out[seed] += p->value[seed][y * WIDTH + x][c] / (side * side);
        }
    }
}

/* The smallest probability of all tests on pixels, or on blocks. */
static double least_probability(int side)
{
    double least = 1, a[SEEDS], b[SEEDS];
    for (int y = 0; y < HEIGHT; y += side)
        for (int x = 0; x < WIDTH; x += side)
            for (int c = 0; c < 3; c++) {
                values_at(&ours, x, y, side, c, a);
                values_at(&theirs, x, y, side, c, b);
                least = fmin(least, welch(a, b));
            }
    return least;
}

/* `few` samples of the oracle and half as many of ours, unless all are asked for. */
static void compare(const char *name, int few)
{
    char path[128];
    snprintf(path, sizeof path, "tests/golden/scenes/%s.json", name);
    render(path, random_all() ? OURS : few / 2);
    sample_oracle(path, few);
    const double pixel = least_probability(1), block = least_probability(SIDE);
    const double each = 1e-4 / (3 * (PIXELS + BLOCKS));
    printf("%s: least probability of a pixel %.2g, of a block %.2g; %.2g allowed\n", name, pixel,
           block, each);
    ck_assert_msg(pixel >= each && block >= each, "%s differs from the oracle", name);
}

/* The tables of Student's distribution: P(|t| >= 2.131) = 0.05 with 15 degrees of freedom, and
 * P(|t| >= 4.073) = 0.001; with one it is Cauchy's, P(|t| >= 1) = 1/2. */
START_TEST(test_blur__students_distribution)
{
    ck_assert_double_eq_tol(student_tails(2.131450, 15), 0.05, 1e-6);
    ck_assert_double_eq_tol(student_tails(4.072765, 15), 0.001, 1e-7);
    ck_assert_double_eq_tol(student_tails(1, 1), 0.5, 1e-12);
    ck_assert_double_eq_tol(student_tails(0.1, 20), 0.921341, 1e-5);
}
END_TEST

START_TEST(test_blur__lens)
{
    compare("lens-balls", SHARP);
    compare("lens-mirror", FEW);
    compare("lens-glass", FEW);
}
END_TEST

START_TEST(test_blur__glossy)
{
    compare("gloss-floor", SHARP);
    compare("gloss-grazing", FEW);
    compare("gloss-glass", FEW);
}
END_TEST

START_TEST(test_blur__frosted)
{
    compare("frosted-pane", FEW);
    compare("frosted-glass", FEW);
    compare("frosted-grazing", FEW);
}
END_TEST

PEN_SUITE("blur", test_blur__students_distribution, test_blur__lens, test_blur__glossy,
          test_blur__frosted)
