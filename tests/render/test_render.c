/* SPDX-License-Identifier: MIT */
/* The film does not depend on the division of the work. The statistics and the cancellation of a
 * run. */
#include <fenv.h>
#include <stdlib.h>
#include <string.h>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

#include "accel/internal/test_doors.h"
#include "support/isa.h"
#include "support/kit.h"
#include "support/suite.h"

static struct kit kit;

static size_t film_bytes(void)
{
    return sizeof(float) * 3 * (size_t)kit.settings.width * (size_t)kit.settings.height;
}

START_TEST(test_render__tiles_cover_the_image_once)
{
    static const int sizes[][3] = {{1, 1, 1},    {7, 5, 3},     {64, 64, 32},
                                   {65, 63, 32}, {10, 20, 500}, {33, 1, 32}};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++) {
        int w = sizes[s][0], h = sizes[s][1], tile = sizes[s][2];
        char *seen = calloc((size_t)(w * h), 1);
        for (int i = 0; i < pen_tile_count(w, h, tile); i++) {
            struct pen_rect r = pen_tile_rect(w, h, tile, i);
            ck_assert(r.width >= 1 && r.width <= tile && r.height >= 1 && r.height <= tile);
            for (int y = r.y; y < r.y + r.height; y++)
                for (int x = r.x; x < r.x + r.width; x++)
                    ck_assert_int_eq(seen[y * w + x]++, 0);
        }
        for (int i = 0; i < w * h; i++)
            ck_assert_int_eq(seen[i], 1);
        free(seen);
    }
    struct pen_rect second = pen_tile_rect(100, 100, 32, 1);
    ck_assert(second.x == 32 && second.y == 0);
}
END_TEST

START_TEST(test_render__same_film_for_threads_tiles_and_accelerators)
{
    kit_medley(&kit);
    kit.settings.samples_per_pixel = 2;
    struct pen_scene *scene = kit_freeze(&kit);
    float *want = kit_film(scene, &kit.settings, 1);
    pen_scene_free(scene);
    static const int threads[] = {1, 2, 3, 8}, tiles[] = {1, 7, 32, 100};
    for (int accelerator = PEN_ACCEL_AUTO; accelerator < PEN_ACCEL_COUNT; accelerator++) {
        kit.settings.accelerator = accelerator;
        scene = kit_freeze(&kit);
        for (int t = 0; t < 4; t++)
            for (int i = 0; i < 4; i++) {
                kit.settings.tile = tiles[i];
                float *got = kit_film(scene, &kit.settings, threads[t]);
                ck_assert_msg(memcmp(got, want, film_bytes()) == 0, "%d threads, tile %d",
                              threads[t], tiles[i]);
                free(got);
            }
        pen_scene_free(scene);
    }
    free(want);
}
END_TEST

/* Soft lights, mirrors and glass, hard lights, and tubes, each with all choices. */
START_TEST(test_render__same_film_for_all_choices_of_auto)
{
    kit_medley(&kit);
    for (int tubes = 0; tubes <= 8; tubes += 8) {
        for (int i = 0; i < tubes; i++)
            kit_tube(&kit, pen_vec3(i - 4, 0, -2), pen_vec3(0.25, 1, 0.125 * i), 0.1, i % 4);
        kit.settings.accelerator = PEN_ACCEL_NONE;
        struct pen_status st;
        struct pen_scene *scene = kit_freeze(&kit);
        float *want = kit_film(scene, &kit.settings, 1);
        for (int choice = 0; choice < PEN_AUTO_COUNT; choice++) {
            scene->accel = pen_accel_build_choice(&scene->prims, (enum pen_auto_choice)choice,
                                                  scene->arena, &st);
            ck_assert(scene->accel);
            float *got = kit_film(scene, &kit.settings, 2);
            ck_assert_msg(memcmp(got, want, film_bytes()) == 0, "%d tubes more: %s", tubes,
                          pen_auto_choice_name((enum pen_auto_choice)choice));
            free(got);
        }
        free(want);
        pen_scene_free(scene);
    }
}
END_TEST

/* Renders with test counting. */
static struct pen_render_stats counted(const struct pen_scene *scene, int threads, float *film)
{
    struct pen_status st;
    struct pen_thread_pool *pool = pen_thread_pool_new(threads, &st);
    struct pen_render_task task = {.scene = scene,
                                   .settings = &kit.settings,
                                   .tile_count = -1,
                                   .rgb = film,
                                   .count_tests = true};
    struct pen_render_stats stats;
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    ck_assert(stats.tests_counted);
    pen_thread_pool_free(pool);
    return stats;
}

START_TEST(test_render__test_counts_do_not_depend_on_the_division)
{
    kit_medley(&kit);
    kit.settings.samples_per_pixel = 2;
    struct pen_scene *scene = kit_freeze(&kit);
    float *want = kit_film(scene, &kit.settings, 1), *film = malloc(film_bytes());
    struct pen_render_stats first = counted(scene, 1, film);
    ck_assert(memcmp(film, want, film_bytes()) == 0);
    ck_assert_uint_gt(first.tests.boxes, first.rays.primary);
    ck_assert_uint_gt(first.tests.primitives, first.rays.primary);
    static const int tiles[] = {1, 7, 100};
    for (int i = 0; i < 3 * isa_count(); i++) {
        kit.settings.tile = tiles[i % 3];
        isa_force(i / 3);
        struct pen_render_stats stats = counted(scene, 1 + i, film);
        ck_assert(memcmp(film, want, film_bytes()) == 0);
        ck_assert_uint_eq(stats.tests.boxes, first.tests.boxes);
        ck_assert_uint_eq(stats.tests.primitives, first.tests.primitives);
    }
    isa_release();
    free(film);
    free(want);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_render__a_single_pixel_equals_the_film)
{
    kit_medley(&kit);
    struct pen_scene *scene = kit_freeze(&kit);
    float *film = kit_film(scene, &kit.settings, 2);
    for (int i = 0; i < kit.settings.width * kit.settings.height; i += 7) {
        double rgb[3];
        struct pen_ray_counts rays;
        struct pen_status st;
        ck_assert(pen_render_pixel(scene, 0, &kit.settings, i % kit.settings.width,
                                   i / kit.settings.width, rgb, &rays, &st));
        for (int c = 0; c < 3; c++)
            ck_assert((float)rgb[c] == film[3 * i + c]);
        ck_assert_uint_eq(rays.primary, 1);
    }
    free(film);
    pen_scene_free(scene);
}
END_TEST

struct observer {
    int inside, calls, pixels;
    atomic_bool cancel;
    int cancel_after;
};

static void observe_tile(void *user, struct pen_rect rect)
{
    struct observer *observer = user;
    ck_assert_int_eq(observer->inside++, 0); /* one call at a time */
    observer->pixels += rect.width * rect.height;
    if (++observer->calls == observer->cancel_after)
        atomic_store(&observer->cancel, true);
    observer->inside--;
}

START_TEST(test_render__statistics)
{
    kit_medley(&kit);
    kit.settings.tile = 8;
    struct pen_scene *scene = kit_freeze(&kit);
    float *film = malloc(film_bytes());
    struct pen_status st;
    struct pen_thread_pool *pool = pen_thread_pool_new(3, &st);
    ck_assert_int_eq(pen_thread_pool_size(pool), 3);
    struct observer observer = {0};
    struct pen_render_task task = {.scene = scene,
                                   .settings = &kit.settings,
                                   .tile_count = -1,
                                   .rgb = film,
                                   .tile_done = observe_tile,
                                   .user = &observer,
                                   .keep_tile_ms = true};
    struct pen_render_stats stats;
    struct pen_ray_counts first = {0};
    for (int threads = 0; threads <= 5; threads++) {
        kit.settings.threads = threads;
        observer = (struct observer){0};
        ck_assert(pen_render_run(pool, &task, &stats, &st));
        ck_assert_int_eq(stats.threads, threads == 0 || threads > 3 ? 3 : threads);
        ck_assert_uint_eq(stats.tile_count, 20);
        ck_assert_int_eq(observer.calls, 20);
        ck_assert_int_eq(observer.pixels, 40 * 30);
        ck_assert_uint_eq(stats.rays.primary, 40 * 30);
        if (threads == 0)
            first = stats.rays;
        ck_assert(memcmp(&first, &stats.rays, sizeof first) == 0);
        double sum = 0;
        for (uint32_t i = 0; i < stats.tile_count; i++) {
            ck_assert_double_gt(stats.tile_ms[i], 0);
            sum += stats.tile_ms[i];
        }
        ck_assert_double_le(sum, stats.render_ms * stats.threads * 1.0001);
        ck_assert_double_gt(stats.cpu_ms, 0);
        ck_assert_str_eq(stats.kernel, pen_kernel_select(stats.effects, pen_cpu_isa())->name);
        ck_assert_uint_eq(stats.effects, pen_scene_effects(scene, 0, &kit.settings));
        free(stats.tile_ms);
    }
    kit.settings.tile = 1000;
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    ck_assert_int_eq(stats.threads, 3); /* there is only one tile, and threads share it */
    free(stats.tile_ms);
    ck_assert(first.shadow > 0 && first.reflection > 0 && first.transmission > 0);
    ck_assert_uint_eq(first.dropped_samples, 0);
    pen_thread_pool_free(pool);
    free(film);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_render__ranges_of_tiles_make_the_whole)
{
    kit_medley(&kit);
    kit.settings.tile = 8;
    struct pen_scene *scene = kit_freeze(&kit);
    float *want = kit_film(scene, &kit.settings, 1), *film = calloc(film_bytes(), 1);
    struct pen_status st;
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    for (int first = 18; first >= 0; first -= 3) {
        struct pen_render_task task = {.scene = scene,
                                       .settings = &kit.settings,
                                       .first_tile = first,
                                       .tile_count = first == 18 ? -1 : 3,
                                       .rgb = film};
        struct pen_render_stats stats;
        ck_assert(pen_render_run(pool, &task, &stats, &st));
        ck_assert_uint_eq(stats.tile_count, first == 18 ? 2 : 3);
        ck_assert(stats.tile_ms == NULL);
        struct pen_rect before = pen_tile_rect(40, 30, 8, first > 0 ? first - 1 : 0);
        const float *untouched = &film[3 * (before.y * 40 + before.x)];
        ck_assert(first == 0 || (untouched[0] == 0 && untouched[1] == 0 && untouched[2] == 0));
    }
    ck_assert(memcmp(film, want, film_bytes()) == 0);
    struct pen_render_task beyond = {
        .scene = scene, .settings = &kit.settings, .first_tile = 18, .tile_count = 3, .rgb = film};
    struct pen_render_stats stats;
    ck_assert(!pen_render_run(pool, &beyond, &stats, &st));
    ck_assert_int_eq(st.code, PEN_INTERNAL);
    pen_thread_pool_free(pool);
    free(film);
    free(want);
    pen_scene_free(scene);
}
END_TEST

static void cancel_at_pixel(void *user, int thread, int x, int y)
{
    struct observer *observer = user;
    (void)thread;
    ck_assert_int_lt(y, PEN_BLOCK_SIDE); /* no call after the block of the one that cancelled */
    ck_assert_int_lt(x, PEN_BLOCK_SIDE);
    if (++observer->calls == observer->cancel_after)
        atomic_store(&observer->cancel, true);
}

/* A large tile with many samples can take minutes. */
START_TEST(test_render__cancel_acts_within_a_block)
{
    struct pen_status st;
    struct pen_render_stats stats;
    kit_medley(&kit);
    kit.settings.tile = 4096;
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_thread_pool *pool = pen_thread_pool_new(1, &st);
    struct observer observer = {.cancel_after = 7};
    float *rgb = calloc((size_t)kit.settings.width * (size_t)kit.settings.height * 3, sizeof *rgb);
    struct pen_render_task task = {.scene = scene,
                                   .settings = &kit.settings,
                                   .tile_count = -1,
                                   .rgb = rgb,
                                   .cancel = &observer.cancel,
                                   .pixel_begins = cancel_at_pixel,
                                   .pixel_user = &observer};
    ck_assert(!pen_render_run(pool, &task, &stats, &st));
    ck_assert_int_eq(st.code, PEN_CANCELLED);
    ck_assert_int_eq(observer.calls, PEN_BLOCK_SIDE * PEN_BLOCK_SIDE);
    free(rgb);
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_render__cancel)
{
    kit_medley(&kit);
    kit.settings.tile = 4;
    struct pen_scene *scene = kit_freeze(&kit);
    float *film = malloc(film_bytes());
    struct pen_status st;
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    struct observer observer = {.cancel_after = 5};
    struct pen_render_task task = {.scene = scene,
                                   .settings = &kit.settings,
                                   .tile_count = -1,
                                   .rgb = film,
                                   .cancel = &observer.cancel,
                                   .tile_done = observe_tile,
                                   .user = &observer,
                                   .keep_tile_ms = true};
    struct pen_render_stats stats;
    ck_assert(!pen_render_run(pool, &task, &stats, &st));
    ck_assert_int_eq(st.code, PEN_CANCELLED);
    ck_assert_int_ge(observer.calls, 5);
    ck_assert_int_le(observer.calls,
                     6); /* the other thread may have rendered its last pixel already */
    ck_assert_uint_eq(stats.tile_count, (uint32_t)observer.calls);
    ck_assert(stats.tile_ms == NULL);
    atomic_store(&observer.cancel, false);
    observer.cancel_after = 0;
    ck_assert(pen_render_run(pool, &task, &stats, &st)); /* the pool is still usable */
    free(stats.tile_ms);
    pen_thread_pool_free(pool);
    free(film);
    pen_scene_free(scene);
}
END_TEST

#if defined(__x86_64__)
enum { FLUSH_AND_ROUND_UP = 0x8040 | 0x4000, STATE = 0x8040 | 0x6000 };

/* Pixels are the same when the caller's arithmetic is not the default, and its state is kept. */
static void assert_pixels_equal(void)
{
    struct pen_scene *scene = kit_freeze(&kit);
    int nonzero = 0;
    for (int i = 0; i < 40 * 30; i += 11) {
        double want[3], got[3];
        struct pen_ray_counts rays;
        struct pen_status st;
        ck_assert(pen_render_pixel(scene, 0, &kit.settings, i % 40, i / 40, want, &rays, &st));
        unsigned before = _mm_getcsr();
        _mm_setcsr(before | FLUSH_AND_ROUND_UP);
        bool ok = pen_render_pixel(scene, 0, &kit.settings, i % 40, i / 40, got, &rays, &st);
        unsigned after = _mm_getcsr();
        _mm_setcsr(before);
        ck_assert(ok && memcmp(got, want, sizeof got) == 0);
        ck_assert_uint_eq(after & STATE, FLUSH_AND_ROUND_UP); /* the caller's state is restored */
        nonzero += want[0] > 0;
    }
    ck_assert_int_gt(nonzero, 10);
    pen_scene_free(scene);
}

static void set_state(void *user, int thread, int x, int y)
{
    (void)thread;
    if (x == 3 && y == 0)
        _mm_setcsr(_mm_getcsr() | *(const unsigned *)user);
}

/* Renders twice with one pool. Its threads inherit the state `inherited`; during the first run one
 * of them sets `given`. Checks how many threads had to be reset in the first and in the second
 * run. */
static void check_resets(unsigned inherited, unsigned given, int first, int second)
{
    struct pen_status st;
    struct pen_render_stats stats;
    struct pen_scene *scene = kit_freeze(&kit);
    float *film = calloc(1, film_bytes());
    unsigned before = _mm_getcsr();
    _mm_setcsr(before | inherited);
    ck_assert_int_eq(pen_float_is_default(), inherited == 0);
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    _mm_setcsr(before);
    ck_assert(pen_float_is_default());
    struct pen_render_task task = {.scene = scene,
                                   .settings = &kit.settings,
                                   .tile_count = -1,
                                   .rgb = film,
                                   .pixel_begins = set_state,
                                   .pixel_user = &given};
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    ck_assert_int_eq(stats.float_resets, first);
    task.pixel_begins = NULL;
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    ck_assert_int_eq(stats.float_resets, second);
    pen_thread_pool_free(pool);
    free(film);
    pen_scene_free(scene);
}

/* H105: each state that is not the default, inherited by both threads or set by one. */
START_TEST(test_render__h105_changed_arithmetic_is_counted_and_reset)
{
    static const unsigned states[] = {0x8000, 0x0040, 0x2000, 0x4000, 0x6000, 0x8040};
    kit_medley(&kit);
    check_resets(0, 0, 0, 0);
    for (size_t i = 0; i < sizeof states / sizeof states[0]; i++) {
        check_resets(states[i], 0, 2, 0);
        check_resets(0, states[i], 1, 1); /* it lasts until the next run, which resets it again */
    }
}
END_TEST

/* H105: the thread that starts the pool flushes subnormals and rounds upwards. */
START_TEST(test_render__h105_default_arithmetic_in_every_thread)
{
    kit_medley(&kit);
    assert_pixels_equal();
    struct pen_scene *scene = kit_freeze(&kit);
    float *want = kit_film(scene, &kit.settings, 2);
    unsigned before = _mm_getcsr();
    _mm_setcsr(before | FLUSH_AND_ROUND_UP);
    struct pen_scene *again = kit_freeze(&kit);
    float *got = kit_film(again, &kit.settings, 2);
    _mm_setcsr(before);
    ck_assert(
        memcmp(&scene->views[0].frame, &again->views[0].frame, sizeof scene->views[0].frame) == 0);
    pen_scene_free(again);
    ck_assert(memcmp(want, got, film_bytes()) == 0);
    free(want);
    free(got);
    pen_scene_free(scene);
    for (uint32_t i = 0; i < kit.desc.light_count; i++)
        kit.lights[i].intensity = pen_scale(kit.lights[i].intensity, 0x1p-1060); /* subnormal */
    kit.desc.background = kit.desc.ambient = pen_vec3(0, 0, 0);
    kit.materials[5].emission = pen_vec3(0, 0, 0);
    assert_pixels_equal();
}
END_TEST
#else
START_TEST(test_render__h105_changed_arithmetic_is_counted_and_reset)
{
    ck_assert(pen_float_is_default());
}
END_TEST

START_TEST(test_render__h105_default_arithmetic_in_every_thread)
{
    ck_assert_int_eq(fegetround(), FE_TONEAREST);
}
END_TEST
#endif

PEN_SUITE("render", test_render__tiles_cover_the_image_once,
          test_render__same_film_for_threads_tiles_and_accelerators,
          test_render__same_film_for_all_choices_of_auto,
          test_render__test_counts_do_not_depend_on_the_division,
          test_render__a_single_pixel_equals_the_film, test_render__statistics,
          test_render__ranges_of_tiles_make_the_whole, test_render__cancel_acts_within_a_block,
          test_render__cancel, test_render__h105_changed_arithmetic_is_counted_and_reset,
          test_render__h105_default_arithmetic_in_every_thread)
