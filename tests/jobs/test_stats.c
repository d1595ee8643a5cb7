/* SPDX-License-Identifier: MIT */
/* The statistics object of one render, and of a job, merged from those of its batches. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/stats_json.h"
#include "support/jobs.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES];

enum { WIDTH = 120, HEIGHT = 90, SAMPLES = 400, TILE = 8 };
static const char several_batches[] =
    ", \"render\": {\"width\": 120, \"height\": 90, \"samples_per_pixel\": 400, \"tile\": 8}";

static double number(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    ck_assert_msg(json_is_number(value), "%s is missing", key);
    return json_number_value(value);
}

static json_t *stats_of_job(void)
{
    struct pen_status st;
    json_t *stats = pen_jobs_stats(bed.jobs, id, &st);
    store_must(stats != NULL, &st, "stats");
    return stats;
}

/* What every statistics object of a finished render must hold. */
static void check_shape(const json_t *stats)
{
    static const char *const times[] = {"queue_ms",  "parse_ms", "build_ms", "render_ms",
                                        "encode_ms", "store_ms", "total_ms", "cpu_ms"};
    const json_t *timing = json_object_get(stats, "timing"), *rays = json_object_get(stats, "rays");
    for (size_t i = 0; i < sizeof times / sizeof times[0]; i++)
        ck_assert_msg(number(timing, times[i]) >= 0, "%s", times[i]);
    double total = number(rays, "primary") + number(rays, "shadow") + number(rays, "reflection") +
                   number(rays, "transmission");
    ck_assert(number(rays, "total") == total);
    double rate = total / number(timing, "render_ms") / 1000;
    ck_assert(number(stats, "mrays_per_second") > 0.98 * rate - 0.01);
    ck_assert(number(stats, "mrays_per_second") < 1.02 * rate + 0.01);
    const json_t *accelerator = json_object_get(stats, "accelerator");
    ck_assert_str_eq(json_string_value(json_object_get(accelerator, "kind")), "auto");
    number(accelerator, "nodes");
    number(accelerator, "build_ms");
    ck_assert_ptr_nonnull(json_string_value(json_object_get(stats, "kernel")));
    ck_assert_uint_gt(json_array_size(json_object_get(stats, "effects")), 2);
    ck_assert(number(json_object_get(stats, "memory"), "peak_bytes") > 1 << 20);
    ck_assert(number(stats, "dropped_samples") == 0);
    ck_assert(number(stats, "truncated_paths") == 0);
    ck_assert(number(stats, "float_resets") == 0);
    const json_t *precision = json_object_get(stats, "precision");
    ck_assert(number(precision, "resolution") > 1e9);
    ck_assert(number(precision, "resolution") ==
              number(precision, "pixel_footprint") / number(precision, "ulp"));
    ck_assert(number(precision, "extent") > 0 && number(precision, "coordinate_max") > 0);
    ck_assert_ptr_null(json_object_get(precision, "warning"));
    const json_t *host = json_object_get(stats, "host");
    ck_assert_str_eq(json_string_value(json_object_get(host, "version")), PEN_VERSION);
    ck_assert(number(host, "cores") >= 1);
    const json_t *ms = json_object_get(json_object_get(stats, "tiles"), "ms");
    ck_assert(number(ms, "p50") <= number(ms, "p95") && number(ms, "p95") <= number(ms, "max"));
    ck_assert(number(ms, "max") > 0);
}

START_TEST(test_stats__job_has_the_sums_of_its_batches)
{
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, jobs_scene(several_batches), id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    json_t *stats = stats_of_job();
    check_shape(stats);
    const json_t *timing = json_object_get(stats, "timing");
    ck_assert(number(json_object_get(stats, "rays"), "primary") == WIDTH * HEIGHT * SAMPLES);
    ck_assert(number(json_object_get(stats, "tiles"), "count") ==
              pen_tile_count(WIDTH, HEIGHT, TILE));
    ck_assert(number(stats, "threads") == 2);
    ck_assert(number(timing, "render_ms") < number(timing, "total_ms"));
    ck_assert(number(timing, "cpu_ms") > 0);
    ck_assert(number(timing, "encode_ms") > 0);
    ck_assert_ptr_null(json_object_get(stats, "tile_ms"));
    ck_assert_ptr_null(json_object_get(stats, "store_before_ms"));
    json_decref(stats);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_stats__ray_counts_do_not_depend_on_the_batches)
{
    json_t *rays[2];
    static const char *const threads[] = {"", ", \"threads\": 1"};
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    for (int i = 0; i < 2; i++) {
        char render[200];
        snprintf(render, sizeof render,
                 ", \"render\": {\"width\": 120, \"height\": 90, \"samples_per_pixel\": 200,"
                 " \"tile\": %d%s}",
                 i ? 90 : 8, threads[i]);
        jobs_submit(&bed, jobs_scene(render), id);
        ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
        json_t *stats = stats_of_job();
        rays[i] = json_deep_copy(json_object_get(stats, "rays"));
        ck_assert(number(stats, "threads") == (i ? 1 : 2));
        json_decref(stats);
    }
    ck_assert(json_equal(rays[0], rays[1]));
    json_decref(rays[0]);
    json_decref(rays[1]);
    jobs_bed_close(&bed);
}
END_TEST

/* Submits balls whose paths fork until they are cut off. Samples on a light that no surface shows
 * take no time, but make more batches. */
static void submit_forks(int light_samples, int tile)
{
    char body[1200];
    snprintf(
        body, sizeof body,
        "{\"scene\": {\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, 10],"
        " \"look_at\": [0, 0, 0]}, \"background\": [1, 1, 1], \"materials\": {\"all\": {\"kr\":"
        " 1, \"kt\": 1}}, \"lights\": [{\"type\": \"point\", \"position\": [9, 9, 9],"
        " \"intensity\": [1, 1, 1], \"radius\": 1}], \"objects\": ["
        "{\"type\": \"sphere\", \"center\": [-1, 0, 0], \"radius\": 2, \"material\": \"all\"},"
        "{\"type\": \"sphere\", \"center\": [1, 0, 0], \"radius\": 2, \"material\": \"all\"},"
        "{\"type\": \"sphere\", \"center\": [0, 1, 0], \"radius\": 2, \"material\": \"all\"}]},"
        " \"render\": {\"width\": 24, \"height\": 24, \"max_depth\": 60, \"light_samples\": %d,"
        " \"tile\": %d}}",
        light_samples, tile);
    jobs_submit(&bed, body, id);
}

static int64_t done_pixels(void)
{
    struct pen_job_record job = store_job_get(bed.bed.store, id);
    int64_t done = job.done_pixels;
    pen_job_record_release(&job);
    return done;
}

static json_t *stats_of_forks(void)
{
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    json_t *stats = stats_of_job();
    json_t *counts = json_pack("{s:O, s:O}", "rays", json_object_get(stats, "rays"), "cut",
                               json_object_get(stats, "truncated_paths"));
    ck_assert(number(counts, "cut") > 100);
    json_decref(stats);
    return counts;
}

/* In one batch, in several, and in several with an interruption. */
START_TEST(test_stats__paths_cut_off_do_not_depend_on_the_batches)
{
    struct pen_status st;
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    submit_forks(1, 24);
    json_t *want = stats_of_forks();
    submit_forks(100000, 6);
    json_t *several = stats_of_forks();
    submit_forks(100000, 6);
    for (int i = 0; i < 60000 && done_pixels() == 0; i++)
        usleep(2000);
    jobs_worker_stop(&bed);
    ck_assert_int_gt(done_pixels(), 0);
    json_t *so_far = pen_jobs_stats_so_far(bed.jobs, id, &st);
    ck_assert(number(json_object_get(so_far, "rays"), "total") > 0);
    ck_assert(number(so_far, "mrays_per_second") > 0);
    ck_assert(number(json_object_get(so_far, "rays"), "total") <
              number(json_object_get(want, "rays"), "total"));
    json_decref(so_far);
    jobs_worker_start(&bed);
    json_t *resumed = stats_of_forks();
    ck_assert(json_equal(several, want));
    ck_assert(json_equal(resumed, want));
    json_decref(want);
    json_decref(several);
    json_decref(resumed);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_stats__come_only_after_the_end)
{
    struct pen_status st;
    jobs_bed_open(&bed);
    jobs_submit(&bed, jobs_scene(""), id);
    ck_assert_ptr_null(pen_jobs_stats(bed.jobs, id, &st));
    ck_assert_int_eq(st.code, PEN_CONFLICT);
    json_t *so_far = pen_jobs_stats_so_far(bed.jobs, id, &st);
    ck_assert(number(json_object_get(so_far, "rays"), "total") == 0);
    json_decref(so_far);
    store_must(pen_store_cancel(bed.bed.store, id, NULL, &st), &st, "cancel");
    json_t *stats = stats_of_job();
    ck_assert(number(json_object_get(stats, "rays"), "total") == 0);
    ck_assert_str_eq(json_string_value(json_object_get(stats, "kernel")), "");
    ck_assert(json_is_array(json_object_get(stats, "effects")));
    ck_assert(json_is_object(json_object_get(stats, "accelerator")));
    ck_assert(json_is_object(json_object_get(stats, "host")));
    ck_assert(number(json_object_get(stats, "timing"), "total_ms") >= 0);
    json_decref(stats);
    ck_assert_ptr_null(pen_jobs_stats(bed.jobs, "nobody", &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    jobs_bed_close(&bed);
}
END_TEST

/* The first of two views is too far away for its resolution. The job warns of it, whichever batch
 * is committed last. */
START_TEST(test_stats__job_has_the_lowest_resolution_of_its_views)
{
    static const char body[] =
        "{\"scene\": {\"format\": \"penumbra-scene/1\", \"ambient\": [1, 1, 1], "
        "\"camera\": {\"position\": [0, 0, 9], \"look_at\": [0, 0, 0]}, \"views\": ["
        "{\"name\": \"far\", \"camera\": {\"position\": [0, 0, 1e16], \"view_plane\": "
        "{\"distance\": 1e16, \"width\": 4, \"height\": 4}}}, {\"name\": \"near\"}], \"objects\": "
        "[{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1}]}, "
        "\"render\": {\"width\": 10, \"height\": 10}}";
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, body, id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    json_t *stats = stats_of_job();
    const json_t *precision = json_object_get(stats, "precision");
    ck_assert(number(precision, "coordinate_max") == 1e16 && number(precision, "ulp") == 2);
    ck_assert(number(precision, "resolution") < 1);
    ck_assert_ptr_nonnull(json_string_value(json_object_get(precision, "warning")));
    json_decref(stats);
    jobs_bed_close(&bed);
}
END_TEST

/* The scene of a second job with the same document is neither parsed nor built again. */
START_TEST(test_stats__cached_scene_costs_no_parse_and_no_build)
{
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    for (int i = 0; i < 2; i++) {
        char body[4300];
        snprintf(body, sizeof body, "{\"scene\": %s, \"render\": {\"width\": %d, \"height\": 10}}",
                 jobs_scene(""), 10 + i);
        jobs_submit(&bed, body, id);
        ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
        json_t *stats = stats_of_job();
        const json_t *timing = json_object_get(stats, "timing");
        ck_assert((number(timing, "parse_ms") > 0) == (i == 0));
        ck_assert((number(timing, "build_ms") > 0) == (i == 0));
        json_decref(stats);
    }
    jobs_bed_close(&bed);
}
END_TEST

struct builds {
    int batches, built;
};

static bool count_builds(void *user, const struct pen_batch_stats *batch)
{
    struct builds *builds = user;
    json_t *stats = json_loads(batch->stats, 0, NULL);
    builds->batches++;
    builds->built += number(json_object_get(stats, "timing"), "build_ms") > 0;
    json_decref(stats);
    return true;
}

/* A scene's views are rendered in one job, from one structure that is built once. */
START_TEST(test_stats__views_share_one_build)
{
    jobs_bed_open(&bed);
    jobs_submit(&bed,
                jobs_scene(", \"views\": [{\"name\": \"a\"}, {\"name\": \"b\"}, {\"name\": \"c\"},"
                           " {\"name\": \"d\"}], \"render\": {\"width\": 24, \"height\": 18,"
                           " \"accelerator\": \"manual\"}"),
                id);
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    struct builds builds = {0};
    struct pen_status st;
    store_must(pen_store_stats(bed.bed.store, id, count_builds, &builds, &st), &st, "stats");
    ck_assert_int_eq(builds.batches, 4);
    ck_assert_int_eq(builds.built, 1);
    json_t *stats = stats_of_job();
    const json_t *accelerator = json_object_get(stats, "accelerator");
    ck_assert_str_eq(json_string_value(json_object_get(accelerator, "kind")), "manual");
    ck_assert(!json_object_get(accelerator, "choice"));
    ck_assert(!json_object_get(accelerator, "expected_costs"));
    ck_assert(number(accelerator, "build_ms") <=
              number(json_object_get(stats, "timing"), "build_ms"));
    ck_assert(number(json_object_get(stats, "rays"), "primary") == 4 * 24 * 18);
    json_decref(stats);
    jobs_bed_close(&bed);
}
END_TEST

/* Percentiles are nearest ranks: of 1 ... 200 they are 100, 190 and 200, whatever the order. */
START_TEST(test_stats__percentiles_of_tiles_are_nearest_ranks)
{
    double ms[200];
    for (int i = 0; i < 200; i++)
        ms[i] = 1 + i * 77 % 200;
    struct pen_render_stats render = {
        .render_ms = 10, .tile_ms = ms, .tile_count = 200, .kernel = "k"};
    struct pen_status st;
    struct pen_limits limits = pen_limits_default();
    struct pen_errors errors = {0};
    struct pen_scene_desc desc;
    struct pen_arena *arena = pen_arena_new(0);
    const char *text = jobs_scene("");
    ck_assert(pen_scene_load(text, strlen(text), &limits, arena, &desc, &errors));
    struct pen_scene *scene = pen_scene_freeze(&desc, PEN_ACCEL_AUTO, 0, &st);
    struct pen_stats_input in = {
        .render = &render, .accel = pen_accel_get_stats(scene->accel), .queue_ms = 1.23456789};
    json_t *stats = pen_stats_json(&in);
    const json_t *tiles = json_object_get(json_object_get(stats, "tiles"), "ms");
    ck_assert(number(tiles, "p50") == 100);
    ck_assert(number(tiles, "p95") == 190);
    ck_assert(number(tiles, "max") == 200);
    ck_assert(number(json_object_get(stats, "timing"), "queue_ms") == 1.234568);
    const json_t *accelerator = json_object_get(stats, "accelerator");
    ck_assert(!json_object_get(accelerator, "box_tests_per_ray"));
    const char *choice = json_string_value(json_object_get(accelerator, "choice"));
    ck_assert_str_eq(choice, pen_auto_choice_name(in.accel->choice));
    const json_t *costs = json_object_get(accelerator, "expected_costs");
    ck_assert_uint_eq(json_object_size(costs), 3);
    ck_assert(number(costs, choice) <= number(costs, "none"));
    ck_assert(number(costs, choice) <= number(costs, "tree"));
    ck_assert(number(costs, choice) <= number(costs, "packets"));
    json_decref(stats);
    render.tests_counted = true; /* only benchmarks count tests */
    render.tests = (struct pen_test_counts){.boxes = 50, .primitives = 9};
    render.rays = (struct pen_ray_counts){.primary = 3, .shadow = 1};
    stats = pen_stats_json(&in);
    ck_assert(number(json_object_get(stats, "accelerator"), "box_tests_per_ray") == 12.5);
    ck_assert(number(json_object_get(stats, "accelerator"), "primitive_tests_per_ray") == 2.25);
    json_decref(stats);
    pen_scene_free(scene);
    pen_arena_free(arena);
}
END_TEST

PEN_SUITE("stats", test_stats__job_has_the_sums_of_its_batches,
          test_stats__ray_counts_do_not_depend_on_the_batches,
          test_stats__paths_cut_off_do_not_depend_on_the_batches,
          test_stats__come_only_after_the_end,
          test_stats__job_has_the_lowest_resolution_of_its_views,
          test_stats__cached_scene_costs_no_parse_and_no_build, test_stats__views_share_one_build,
          test_stats__percentiles_of_tiles_are_nearest_ranks)
