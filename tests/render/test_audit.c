/* SPDX-License-Identifier: MIT */
/* Audits of pictures whose number of wrong pixels is known. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render/audit.h"
#include "support/kit.h"
#include "support/suite.h"

enum { SIDE = 40, PIXELS = SIDE * SIDE };

static struct kit kit;
static struct pen_scene *scene;
static struct pen_thread_pool *pool;
static float rgb[3 * PIXELS];
static int samples; /* of the pixels that are rendered again; 0: as many as audits take */

/* A picture of one colour, and what audits need. */
static void begin(void)
{
    struct pen_status st;
    kit_init(&kit);
    samples = 8;
    kit.settings.width = kit.settings.height = SIDE;
    kit_sheet(&kit, 0, 100, kit_material(&kit, kit_glow(0.5, 0.25, 0.125)));
    scene = kit_freeze(&kit);
    pool = pen_thread_pool_new(2, &st);
    for (int i = 0; i < PIXELS; i++)
        memcpy(&rgb[3 * i], (float[]){0.5F, 0.25F, 0.125F}, 3 * sizeof(float));
}

static void end(void)
{
    pen_scene_free(scene);
    pen_thread_pool_free(pool);
}

static struct pen_audit_task task_of(uint64_t pixels, double threshold, uint64_t seed)
{
    return (struct pen_audit_task){.scene = scene,
                                   .settings = &kit.settings,
                                   .rgb = rgb,
                                   .pixels = pixels,
                                   .threshold = threshold,
                                   .samples = samples,
                                   .seed = seed};
}

static struct pen_audit audit(uint64_t pixels, double threshold, uint64_t seed)
{
    struct pen_status st;
    struct pen_audit out;
    const struct pen_audit_task task = task_of(pixels, threshold, seed);
    ck_assert_msg(pen_audit_run(pool, &task, &out, &st), "%s", st.msg);
    return out;
}

/* Pauses after every few pixels. */
static bool pause_often(void *user)
{
    int *asked = user;
    return ++*asked % 5 == 0;
}

/* The same in parts, which are more than one. */
static struct pen_audit audit_in_parts(uint64_t pixels, double threshold, uint64_t seed)
{
    struct pen_status st;
    struct pen_audit out;
    struct pen_audit_progress progress = {0};
    int asked = 0, parts = 0;
    struct pen_audit_task task = task_of(pixels, threshold, seed);
    task.pause = pause_often;
    task.pause_user = &asked;
    do {
        const uint64_t before = progress.done;
        ck_assert_msg(pen_audit_continue(pool, &task, &progress, &out, &st), "%s", st.msg);
        ck_assert_uint_gt(progress.done, before);
        ck_assert_uint_eq(progress.done + progress.left, pixels);
        parts++;
    } while (progress.left > 0);
    ck_assert_int_gt(parts, 1);
    return out;
}

/* The probability of k or fewer of n, term by term from binomial coefficients in long double. */
static double at_most(int k, int n, double p)
{
    long double sum = 0;
    for (int i = 0; i <= k; i++) {
        long double term = 1;
        for (int j = 0; j < i; j++)
            term *= (long double)(n - j) / (j + 1) * (long double)p;
        for (int j = 0; j < n - i; j++)
            term *= 1 - (long double)p;
        sum += term;
    }
    return (double)sum;
}

START_TEST(test_audit__bounds_are_those_of_clopper_and_pearson)
{
    static const int cases[][2] = {{0, 600}, {1, 10}, {3, 60}, {29, 30}, {40, 500}, {0, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const int k = cases[i][0], n = cases[i][1];
        const double bound = pen_audit_bound((uint64_t)k, (uint64_t)n);
        ck_assert_msg(fabs(at_most(k, n, bound) - 0.05) < 1e-9, "%d of %d: %g", k, n, bound);
    }
    ck_assert(fabs(pen_audit_bound(0, 600) - (1 - pow(0.05, 1.0 / 600))) < 1e-12);
    ck_assert(pen_audit_bound(7, 7) == 1);
    const double million = pen_audit_bound(5000, 1000000);
    ck_assert(million > 0.005 && million < 0.005 + 2 * sqrt(0.005 / 1e6));
}
END_TEST

START_TEST(test_audit__counts_what_is_off_by_more_than_the_threshold)
{
    begin();
    struct pen_audit a = audit(PIXELS, 0.01, 1);
    ck_assert(a.pixels == PIXELS && a.wrong == 0 && a.undecided == 0 && a.bound == 0);
    for (int i = 0; i < PIXELS; i += 10) /* 0.5 is encoded as 0.7354; 0.52 as 0.7485 */
        rgb[3 * i + i / 10 % 3] *= i / 10 % 3 == 0 ? 1.04F : 1.2F;
    a = audit(PIXELS, 0.01, 1);
    ck_assert(a.wrong == PIXELS / 10 && a.undecided == 0 && a.threshold == 0.01);
    ck_assert_double_eq(a.bound, 0.1); /* audited whole */
    a = audit(PIXELS, 0.014, 1);       /* red is off by 0.0131 */
    ck_assert_uint_eq(a.wrong, PIXELS / 10 - (PIXELS / 10 + 2) / 3);
    kit.settings.transfer = PEN_SETTING_LINEAR;
    a = audit(PIXELS, 0.022, 1); /* red by 0.02 now, green by 0.05, blue by 0.025 */
    ck_assert_uint_eq(a.wrong, PIXELS / 10 - (PIXELS / 10 + 2) / 3);
    end();
}
END_TEST

START_TEST(test_audit__pixels_are_drawn_without_replacement_by_the_seed)
{
    begin();
    rgb[3 * 777] = 0.9F;
    uint64_t found = 0;
    for (uint64_t seed = 0; seed < 40; seed++) {
        const struct pen_audit a = audit(PIXELS - 1, 0.01, seed); /* leaves out one pixel */
        ck_assert(a.pixels == PIXELS - 1 && a.wrong <= 1 && a.seed == seed);
        found += a.wrong;
    }
    ck_assert_uint_ge(found, 38);
    found = 0;
    for (uint64_t seed = 0; seed < 400; seed++)
        found += audit(PIXELS / 4, 0.01, seed).wrong;
    ck_assert_msg(found > 100 - 5 * 9 && found < 100 + 5 * 9, "%llu", (unsigned long long)found);
    end();
}
END_TEST

/* Two squares and a pixel of their own, which are found whole if all pixels are audited, and partly
 * if not; by one thread, by two, and in parts. */
START_TEST(test_audit__wrong_pixels_are_told_in_clusters)
{
    static const struct pen_rect found[] = {{20, 2, 9, 9}, {3, 28, 5, 7}, {36, 38, 1, 1}};
    begin();
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < found[c].width * found[c].height; i++)
            rgb[3 * ((found[c].y + i / found[c].width) * SIDE + found[c].x + i % found[c].width)] =
                0.9F;
    const struct pen_audit a = audit(PIXELS, 0.01, 1), some = audit(400, 0.01, 1),
                           parts = audit_in_parts(400, 0.01, 1);
    ck_assert_int_eq(a.clusters, 3);
    for (int c = 0; c < 3; c++) {
        const uint64_t all = (uint64_t)(found[c].width * found[c].height);
        ck_assert_mem_eq(&a.cluster[c].rect, &found[c], sizeof found[c]);
        ck_assert(a.cluster[c].wrong == all && a.cluster[c].pixels == all);
    }
    ck_assert(some.clusters >= 2 && some.cluster[0].wrong + some.cluster[1].wrong <= some.wrong);
    for (int c = 0; c < 2; c++) {
        const struct pen_rect r = some.cluster[c].rect, in = found[c];
        ck_assert(r.x >= in.x && r.x + r.width <= in.x + in.width && r.y >= in.y &&
                  r.y + r.height <= in.y + in.height);
        ck_assert(some.cluster[c].wrong == some.cluster[c].pixels);
    }
    ck_assert_mem_eq(some.cluster, parts.cluster, (size_t)some.clusters * sizeof *some.cluster);
    pen_thread_pool_free(pool);
    struct pen_status st;
    pool = pen_thread_pool_new(1, &st);
    const struct pen_audit alone = audit(400, 0.01, 1);
    ck_assert_mem_eq(some.cluster, alone.cluster, (size_t)some.clusters * sizeof *some.cluster);
    end();
    begin(); /* of many clusters the largest are told */
    for (int c = 0; c < 9; c++)
        for (int i = 0; i < 1 + c * 4 % 9; i++)
            rgb[3 * ((2 + c / 3 * 15) * SIDE + 2 + c % 3 * 14 + i)] = 0.9F;
    const struct pen_audit many = audit(PIXELS, 0.01, 1);
    ck_assert_int_eq(many.clusters, PEN_AUDIT_CLUSTERS);
    for (int c = 0; c < PEN_AUDIT_CLUSTERS; c++)
        ck_assert_uint_eq(many.cluster[c].wrong, (uint64_t)(9 - c));
    end();
}
END_TEST

/* With 3 % wrong the bound of 95 % holds in at least 19 of 20 audits. */
START_TEST(test_audit__bounds_hold)
{
    int held = 0;
    begin();
    for (int i = 0; i < PIXELS * 3 / 100; i++)
        rgb[3 * (i * 33 % PIXELS)] = 0.9F;
    for (uint64_t seed = 0; seed < 400; seed++)
        held += audit(100, 0.01, seed).bound >= 0.03;
    ck_assert_msg(held >= 380 - 3 * 5, "%d of 400", held); /* less three standard deviations */
    ck_assert_msg(held < 400, "bounds that always hold are too wide");
    end();
}
END_TEST

/* An edge through pixels, shown as what their centres see. */
START_TEST(test_audit__pixel_centres_at_an_edge_are_wrong)
{
    begin();
    pen_scene_free(scene);
    kit.settings.samples_per_pixel = 1;
    const struct pen_vec3 v[] = {{0.013, 100, 1}, {0.013, -100, 1}, {200, -100, 1}, {200, 100, 1}};
    kit_polygon(&kit, v, 4, kit_material(&kit, kit_glow(0, 0, 0)));
    scene = kit_freeze(&kit);
    float *film = kit_film(scene, &kit.settings, 1);
    memcpy(rgb, film, sizeof rgb);
    free(film);
    samples = 0;
    const struct pen_audit a = audit(PIXELS, 0.05, 3), parts = audit_in_parts(PIXELS, 0.05, 3);
    ck_assert_uint_eq(a.wrong, SIDE);
    ck_assert_uint_eq(a.undecided, 0);
    ck_assert_uint_eq(parts.wrong, SIDE);
    ck_assert_uint_eq(parts.undecided, 0);
    ck_assert_uint_eq(parts.pixels, PIXELS);
    end();
}
END_TEST

/* Half-covered pixels whose few samples leave them uncertain. */
START_TEST(test_audit__few_samples_leave_pixels_undecided)
{
    struct pen_status st;
    struct pen_audit a;
    begin();
    pen_scene_free(scene);
    const struct pen_vec3 v[] = {{0.4, 100, 1}, {-0.3, -100, 1}, {200, -100, 1}, {200, 100, 1}};
    kit_polygon(&kit, v, 4, kit_material(&kit, kit_glow(0, 0, 0)));
    scene = kit_freeze(&kit);
    kit.settings.samples_per_pixel = 4096;
    float *film = kit_film(scene, &kit.settings, 2);
    struct pen_audit_task task = {.scene = scene,
                                  .settings = &kit.settings,
                                  .rgb = film,
                                  .pixels = PIXELS,
                                  .threshold = 0.01,
                                  .seed = 1,
                                  .samples = 64};
    ck_assert(pen_audit_run(pool, &task, &a, &st));
    ck_assert_msg(a.undecided > SIDE / 2 && a.undecided <= 3 * SIDE, "%llu",
                  (unsigned long long)a.undecided);
    ck_assert_double_eq(a.bound, (double)(a.wrong + a.undecided) / PIXELS); /* audited whole */
    task.samples = 16384;
    ck_assert(pen_audit_run(pool, &task, &a, &st));
    ck_assert(a.wrong == 0 && a.undecided == 0);
    free(film);
    end();
}
END_TEST

/* A floor under a light of which a half-plane hides a part: a share of 1/2 is seen, by independent
 * points. So what a pixel is rendered as again is normal, of known mean and deviation. */
static void half_light(void)
{
    begin();
    pen_scene_free(scene);
    kit_init(&kit);
    kit.settings.width = kit.settings.height = SIDE;
    kit.settings.transfer = PEN_SETTING_LINEAR;
    kit.settings.light_pattern = PEN_PATTERN_RANDOM;
    kit.settings.light_samples = 16;
    kit.view.camera.fov_degrees = 1e-5;
    kit.view.camera.position = pen_vec3(0, -6, 3);
    kit.view.camera.direction = pen_vec3(0, 6, -3);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), kit_material(&kit, kit_matte(0.8)));
    kit_point(&kit, pen_vec3(0, 0, 8), pen_vec3(1, 1, 1))->radius = 1;
    const struct pen_vec3 v[] = {{0, -100, 4}, {0, 100, 4}, {-100, 100, 4}, {-100, -100, 4}};
    kit_polygon(&kit, v, 4, kit_material(&kit, kit_matte(0)));
    scene = kit_freeze(&kit);
    samples = 64;
}

static void show(double value)
{
    for (int i = 0; i < 3 * PIXELS; i++)
        rgb[i] = (float)value;
}

/* An interval of 99.99 % misses what is right in one of 10000 pixels, and one of 95 % in 80 of
 * 1600. It is as wide as 7.9 deviations of the mean, so that what is off by 12 more than the
 * threshold is wrong, unless the deviation comes out 1.5 times as large, in one of 40. */
START_TEST(test_audit__intervals_are_neither_too_narrow_nor_too_wide)
{
    half_light();
    show(0.4);
    struct pen_audit a = audit(PIXELS, 1e-9, 7);
    ck_assert_msg(a.wrong <= 3 && a.wrong + a.undecided == PIXELS, "%llu wrong",
                  (unsigned long long)a.wrong);
    show(0.4 + 0.01 + 12 * 0.8 * 0.5 / sqrt(64 * 16));
    a = audit(PIXELS, 0.01, 7);
    ck_assert_msg(a.wrong > PIXELS * 9 / 10, "%llu wrong", (unsigned long long)a.wrong);
    end();
}
END_TEST

/* A picture with few samples is audited with more than its own: of a pixel that had 2048 with 64
 * times as many, so that what is off by 12 deviations of their mean more than the threshold is
 * found. */
START_TEST(test_audit__takes_64_times_the_samples_of_the_picture)
{
    half_light();
    samples = 0;
    kit.settings.samples_per_pixel = 128;
    show(0.4 + 0.01 + 12 * 0.8 * 0.5 / sqrt(64 * 128 * 16));
    const struct pen_audit a = audit(40, 0.01, 7);
    ck_assert_msg(a.wrong >= 34, "%llu wrong", (unsigned long long)a.wrong);
    end();
}
END_TEST

PEN_SUITE("audit", test_audit__bounds_are_those_of_clopper_and_pearson,
          test_audit__counts_what_is_off_by_more_than_the_threshold,
          test_audit__pixels_are_drawn_without_replacement_by_the_seed,
          test_audit__wrong_pixels_are_told_in_clusters, test_audit__bounds_hold,
          test_audit__pixel_centres_at_an_edge_are_wrong,
          test_audit__few_samples_leave_pixels_undecided,
          test_audit__intervals_are_neither_too_narrow_nor_too_wide,
          test_audit__takes_64_times_the_samples_of_the_picture)
