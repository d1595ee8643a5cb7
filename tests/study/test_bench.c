/* SPDX-License-Identifier: MIT */
/* The order of runs, medians, the comparison of pictures, and what ends a benchmark early. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "study/bench.h"
#include "support/kit.h"
#include "support/suite.h"

enum { ROWS_MAX = 16, SEEN_MAX = 256 };

static struct kit kit;
static struct pen_bench bench;
static struct pen_bench_row rows[ROWS_MAX];
static struct pen_bench_result result;
static struct pen_status st;
static const int views[] = {0};

/* What the hooks recorded: the rows whose pictures were checked, and the progress reported. */
static int seen[SEEN_MAX], seen_count, progress[SEEN_MAX], progress_count, total;

static void note_row(void *user, int row, int view, float *rgb)
{
    (void)user;
    (void)view;
    (void)rgb;
    seen[seen_count++] = row;
}

static void note_progress(void *user, int done, int all)
{
    (void)user;
    progress[progress_count++] = done;
    total = all;
}

/* A benchmark of the kit's medley scene; the test adds rows one by one. */
static void set_up(int threads)
{
    kit_medley(&kit);
    bench = (struct pen_bench){.desc = &kit.desc,
                               .views = views,
                               .view_count = 1,
                               .rows = rows,
                               .repeats = 3,
                               .warmup = 1,
                               .progress = note_progress,
                               .pool = pen_thread_pool_new(threads, &st)};
    ck_assert_ptr_nonnull(bench.pool);
    seen_count = progress_count = 0;
}

static struct pen_settings *add_row(const char *varied)
{
    struct pen_bench_row *row = &rows[bench.row_count++];
    row->settings = kit.settings;
    row->varied = json_loads(varied, 0, NULL);
    ck_assert_ptr_nonnull(row->varied);
    return &row->settings;
}

static void tear_down(void)
{
    pen_bench_result_release(&bench, &result);
    for (int i = 0; i < bench.row_count; i++)
        json_decref((json_t *)(uintptr_t)rows[i].varied);
    pen_thread_pool_free(bench.pool);
}

static void run(void)
{
    if (!pen_bench_run(&bench, &result, &st))
        ck_abort_msg("%s", st.msg);
}

static void add_none_and_auto(void)
{
    add_row("{\"accelerator\": \"none\"}")->accelerator = PEN_ACCEL_NONE;
    add_row("{\"accelerator\": \"auto\"}")->accelerator = PEN_ACCEL_AUTO;
}

START_TEST(test_bench__runs_are_interleaved_after_the_warm_up)
{
    static const int order[] = {0, 1, 0, 1, 0, 1, 0, 1};
    set_up(2);
    add_none_and_auto();
    bench.tamper = note_row;
    run();
    ck_assert_int_eq(seen_count, 8); /* and two runs that count tests */
    ck_assert_mem_eq(seen, order, sizeof order);
    ck_assert_int_eq(total, 10);
    ck_assert_int_eq(pen_bench_runs(&bench), 10);
    ck_assert_int_eq(progress_count, 11);
    for (int i = 0; i < progress_count; i++)
        ck_assert_int_eq(progress[i], i);
    tear_down();
}
END_TEST

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

START_TEST(test_bench__medians_and_speedups_are_those_of_the_runs)
{
    set_up(2);
    add_none_and_auto();
    bench.repeats = 4;
    bench.warmup = 0;
    bench.baseline = 1;
    run();
    for (int i = 0; i < 2; i++) {
        const struct pen_bench_row_result *row = &result.rows[i];
        double ms[4];
        for (int k = 0; k < 4; k++)
            ms[k] = row->runs[k].build_ms + row->runs[k].render_ms;
        qsort(ms, 4, sizeof *ms, by_value);
        ck_assert(ms[0] > 0);
        ck_assert(row->min_ms == ms[0] && row->max_ms == ms[3]);
        ck_assert(row->median_ms == (ms[1] + ms[2]) / 2);
        ck_assert(row->speedup == result.rows[1].median_ms / row->median_ms);
    }
    ck_assert(result.rows[1].speedup == 1);
    tear_down();
}
END_TEST

START_TEST(test_bench__rays_and_tests_are_those_of_a_plain_render)
{
    set_up(2);
    add_none_and_auto();
    run();
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_ray_counts rays = {0};
    double rgb[3];
    for (int i = 0; i < kit.settings.width * kit.settings.height; i++) {
        struct pen_ray_counts one;
        ck_assert(pen_render_pixel(scene, 0, &kit.settings, i % kit.settings.width,
                                   i / kit.settings.width, rgb, &one, &st));
        rays.primary += one.primary;
        rays.shadow += one.shadow;
        rays.reflection += one.reflection;
        rays.transmission += one.transmission;
    }
    for (int i = 0; i < 2; i++) {
        const struct pen_render_stats *stats = &result.rows[i].stats;
        ck_assert_uint_eq(stats->rays.primary, rays.primary);
        ck_assert_uint_eq(stats->rays.shadow, rays.shadow);
        ck_assert_uint_eq(stats->rays.reflection, rays.reflection);
        ck_assert_uint_eq(stats->rays.transmission, rays.transmission);
        ck_assert(stats->tests_counted);
    }
    /* Without a tree there are no boxes, and more primitives are tested than with one. */
    ck_assert_uint_eq(result.rows[0].stats.tests.boxes, 0);
    ck_assert_uint_gt(result.rows[1].stats.tests.boxes, 0);
    ck_assert_uint_gt(result.rows[0].stats.tests.primitives, result.rows[1].stats.tests.primitives);
    pen_scene_free(scene);
    tear_down();
}
END_TEST

START_TEST(test_bench__threads_beyond_the_pool_are_capped_and_noted)
{
    set_up(2);
    kit.settings.tile = 4;
    add_row("{\"threads\": 1}")->threads = 1;
    add_row("{\"threads\": 0}")->threads = 0;
    add_row("{\"threads\": 64}")->threads = 64;
    run();
    ck_assert_int_eq(result.rows[0].stats.threads, 1);
    ck_assert_int_eq(result.rows[1].stats.threads, 2);
    ck_assert_int_eq(result.rows[2].stats.threads, 2);
    ck_assert_int_eq(pen_bench_runs(&bench), 13); /* tests are counted once */
    json_t *report = pen_bench_report_new(&bench, &result, json_object());
    char *notes = json_dumps(json_object_get(report, "notes"), 0);
    ck_assert_ptr_nonnull(strstr(notes, "row 2 asks for 64 threads; the pool has 2"));
    ck_assert_ptr_null(strstr(notes, "row 1"));
    free(notes);
    json_decref(report);
    tear_down();
}
END_TEST

START_TEST(test_bench__other_pictures_are_measured_against_the_first_of_their_size)
{
    set_up(2);
    add_row("{\"max_depth\": 10, \"width\": 40}");
    add_row("{\"max_depth\": 1, \"width\": 40}")->max_depth = 1;
    add_row("{\"max_depth\": 10, \"width\": 20}")->width = 20;
    add_row("{\"max_depth\": 1, \"width\": 20}")->max_depth = 1;
    rows[3].settings.width = 20;
    run();
    static const int with[] = {0, 0, 2, 2};
    for (int i = 0; i < 4; i++) {
        const struct pen_bench_row_result *row = &result.rows[i];
        ck_assert_int_eq(row->compared_with, with[i]);
        ck_assert_int_eq(row->same_as, i);
        ck_assert(row->identical == (i % 2 == 0));
        ck_assert((row->max_difference > 0) == (i % 2 == 1));
        ck_assert((row->rmse > 0) == (i % 2 == 1));
        ck_assert(row->rmse <= row->max_difference);
    }
    ck_assert(pen_bench_reference_pixels(&bench) == 2 * (40.0 + 20.0) * kit.settings.height);
    tear_down();
}
END_TEST

/* Changes the last bit of one value of a row's picture, in its second run. */
static void flip_bit(void *user, int row, int view, float *rgb)
{
    uint32_t bits;
    float *value = &rgb[3 * (7 * kit.settings.width + 5) + 1];
    note_row(user, row, view, rgb);
    if (seen_count != 4)
        return;
    memcpy(&bits, value, sizeof bits);
    bits ^= 1;
    memcpy(value, &bits, sizeof bits);
}

START_TEST(test_bench__one_bit_of_difference_fails_it_and_is_named)
{
    set_up(2);
    add_none_and_auto();
    bench.tamper = flip_bit;
    ck_assert(!pen_bench_run(&bench, &result, &st));
    ck_assert_int_eq(st.code, PEN_DIFFERENT);
    ck_assert_ptr_nonnull(strstr(st.msg, "row 0 (accelerator \"none\")"));
    ck_assert_ptr_nonnull(strstr(st.msg, "row 1 (accelerator \"auto\")"));
    ck_assert_ptr_nonnull(strstr(st.msg, "pixel 5,7, green is "));
    ck_assert_ptr_nonnull(strstr(st.msg, "view main"));
    tear_down();
}
END_TEST

static atomic_bool cancel;

static void cancel_at_five(void *user, int done, int all)
{
    note_progress(user, done, all);
    if (done == 5)
        atomic_store(&cancel, true);
}

START_TEST(test_bench__cancel_ends_it_between_runs_and_within_one)
{
    set_up(1);
    add_none_and_auto();
    bench.cancel = &cancel;
    bench.progress = cancel_at_five;
    atomic_store(&cancel, false);
    ck_assert(!pen_bench_run(&bench, &result, &st));
    ck_assert_int_eq(st.code, PEN_CANCELLED);
    ck_assert_int_eq(progress[progress_count - 1], 5);
    tear_down();
}
END_TEST

START_TEST(test_bench__report_has_the_members_of_the_api)
{
    static const char *const keys[] = {
        "settings", "threads",   "median_ms", "min_ms",           "max_ms",
        "runs_ms",  "speedup",   "rays",      "accelerator",      "rmse",
        "build_ms", "render_ms", "cpu_ms",    "mrays_per_second", "max_difference"};
    set_up(2);
    add_none_and_auto();
    run();
    json_t *report = pen_bench_report_new(&bench, &result, json_pack("{s:s}", "scene", "medley"));
    ck_assert_ptr_nonnull(report);
    json_t *row = json_array_get(json_object_get(report, "rows"), 1);
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++)
        ck_assert_msg(json_object_get(row, keys[i]) != NULL, "no %s", keys[i]);
    ck_assert_uint_eq(json_array_size(json_object_get(row, "runs_ms")), 3);
    ck_assert(json_equal(json_object_get(row, "settings"), rows[1].varied));
    json_t *accelerator = json_object_get(row, "accelerator");
    ck_assert(json_real_value(json_object_get(accelerator, "box_tests_per_ray")) > 0);
    ck_assert(json_real_value(json_object_get(accelerator, "primitive_tests_per_ray")) > 0);
    ck_assert_str_eq(json_string_value(json_object_get(report, "scene")), "medley");
    ck_assert(json_is_integer(json_object_get(json_object_get(report, "host"), "cores")));
    ck_assert_int_eq(json_integer_value(json_object_get(report, "pool_threads")), 2);
    json_decref(report);
    tear_down();
}
END_TEST

PEN_SUITE("bench", test_bench__runs_are_interleaved_after_the_warm_up,
          test_bench__medians_and_speedups_are_those_of_the_runs,
          test_bench__rays_and_tests_are_those_of_a_plain_render,
          test_bench__threads_beyond_the_pool_are_capped_and_noted,
          test_bench__other_pictures_are_measured_against_the_first_of_their_size,
          test_bench__one_bit_of_difference_fails_it_and_is_named,
          test_bench__cancel_ends_it_between_runs_and_within_one,
          test_bench__report_has_the_members_of_the_api)
