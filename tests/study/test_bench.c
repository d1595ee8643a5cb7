/* SPDX-License-Identifier: MIT */
/* The order of runs, medians, the comparison of pictures, and the reasons for an early end of a
 * benchmark. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "film/film.h"
#include "study/bench.h"
#include "support/kit.h"
#include "support/suite.h"
#include "support/unfinished.h"

enum { ROWS_MAX = 16, SEEN_MAX = 4096 };

static struct kit kit;
static struct pen_bench bench;
static struct pen_bench_row rows[ROWS_MAX];
static struct pen_bench_result result;
static struct pen_status st;
static const int views[] = {0};

/* Records of the hooks: the rows whose pictures were checked, and the progress reported. */
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
    bench = (struct pen_bench){.frame = {.desc = &kit.desc,
                                         .pool = pen_thread_pool_new(threads, &st),
                                         .progress = note_progress},
                               .views = views,
                               .view_count = 1,
                               .rows = rows,
                               .repeats = 3,
                               .warmup = 1};
    ck_assert_ptr_nonnull(bench.frame.pool);
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
    pen_thread_pool_free(bench.frame.pool);
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

/* Checks that each pass of `slots` runs visited rows 0 .. slots - 1 once. *first becomes the number
 * of passes that began with row 0. */
static void check_passes(int passes, int slots, int *first)
{
    *first = 0;
    ck_assert_int_eq(seen_count, passes * slots);
    for (int pass = 0; pass < passes; pass++) {
        unsigned visited = 0;
        for (int i = 0; i < slots; i++)
            visited |= 1u << seen[pass * slots + i];
        ck_assert_uint_eq(visited, (1u << slots) - 1);
        *first += seen[pass * slots] == 0;
    }
}

START_TEST(test_bench__runs_are_interleaved_after_the_warm_up)
{
    int first;
    set_up(2);
    add_none_and_auto();
    bench.tamper = note_row;
    run();
    check_passes(4, 2, &first); /* and two runs that count tests */
    ck_assert_int_eq(total, 10);
    ck_assert_int_eq(pen_bench_runs(&bench), 10);
    ck_assert_int_eq(progress_count, 11);
    for (int i = 0; i < progress_count; i++)
        ck_assert_int_eq(progress[i], i);
    tear_down();
}
END_TEST

START_TEST(test_bench__order_of_a_pass_is_random_and_follows_from_the_seed)
{
    int first, orders[2][SEEN_MAX];
    set_up(1);
    kit.settings.width = kit.settings.height = 4;
    add_row("{\"tile\": 8}");
    add_row("{\"tile\": 16}");
    add_row("{\"tile\": 32}");
    bench.tamper = note_row;
    bench.repeats = 9;
    bench.warmup = 10;
    for (int i = 0; i < 2; i++) {
        bench.order_seed = 7;
        seen_count = progress_count = 0;
        run();
        check_passes(19, 3, &first);
        ck_assert_int_gt(first, 0); /* of 19 passes about 6; none once in 2000 seeds */
        ck_assert_int_lt(first, 19);
        memcpy(orders[i], seen, sizeof seen);
        pen_bench_result_release(&bench, &result);
    }
    ck_assert_mem_eq(orders[0], orders[1], sizeof orders[0]);
    bench.order_seed = 8;
    seen_count = progress_count = 0;
    run();
    ck_assert(memcmp(orders[0], seen, sizeof seen) != 0);
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

/* Lengthens every run of row 1 by `dawdle_ms`, of processor time or of sleep. */
static double dawdle_ms;
static bool dawdle_sleeps;

static void dawdle(void *user, int row)
{
    (void)user;
    const int64_t begun_ns = pen_clock_ns();
    if (row == 1 && dawdle_sleeps)
        usleep((useconds_t)(dawdle_ms * 1000));
    while (row == 1 && (double)(pen_clock_ns() - begun_ns) * 1e-6 < dawdle_ms) {
    }
}

/* Adds two rows that differ in the tile alone. The second one dawdles. */
static void add_equal_rows(void)
{
    kit.settings.width = kit.settings.height = 16;
    add_row("{\"tile\": 16}")->tile = 16;
    add_row("{\"tile\": 32}")->tile = 32;
    bench.dawdle = dawdle;
    dawdle_sleeps = false;
}

static double pair(const struct pen_bench_row_result *row, int repeat)
{
    const struct pen_bench_times *a = &row->runs[repeat], *b = &result.rows[0].runs[repeat];
    return (a->build_ms + a->render_ms) / (b->build_ms + b->render_ms);
}

START_TEST(test_bench__ratio_is_the_median_of_the_pairs_of_one_repeat)
{
    set_up(1);
    add_equal_rows();
    bench.repeats = 11;
    bench.least_effect = 0.02;
    dawdle_ms = 50; /* more than other programs may take of an unspoiled run */
    run();
    const struct pen_bench_row_result *slow = &result.rows[1];
    double ratios[11];
    int spoiled = 0;
    for (int i = 0; i < 11; i++) {
        ratios[i] = pair(slow, i);
        spoiled += slow->runs[i].spoiled || result.rows[0].runs[i].spoiled;
    }
    qsort(ratios, 11, sizeof *ratios, by_value);
    ck_assert(slow->ratio.median == ratios[5] && slow->ratio.count == 11);
    ck_assert_int_eq(slow->ratio.spoiled, spoiled);
    if (spoiled == 0) {
        ck_assert(slow->ratio.low == ratios[1] && slow->ratio.high == ratios[9]);
        ck_assert_int_eq(slow->verdict, PEN_VERDICT_SLOWER);
    }
    ck_assert_int_eq(result.rows[0].verdict, PEN_VERDICT_BASELINE);
    ck_assert_int_eq(result.repeats, 11);
    ck_assert_ptr_nonnull(result.twin.runs);
    ck_assert(result.twin.ratio.median > 0.2 && result.twin.ratio.median < 5);
    ck_assert(result.calibration.median > 0.05); /* ms, for a million tests of a ray and a sphere */
    tear_down();
}
END_TEST

START_TEST(test_bench__few_repeats_have_neither_twin_nor_verdict)
{
    set_up(1);
    add_equal_rows();
    dawdle_ms = 5;
    run();
    ck_assert_ptr_null(result.twin.runs);
    ck_assert_int_eq(result.rows[1].verdict, PEN_VERDICT_UNDECIDED);
    ck_assert_ptr_nonnull(strstr(result.rows[1].reason, "fewer than 10 pairs"));
    tear_down();
}
END_TEST

START_TEST(test_bench__runs_below_a_millisecond_are_made_several_times_in_a_row)
{
    int several = 0;
    set_up(1);
    kit.settings.width = kit.settings.height = 4;
    add_row("{}");
    bench.repeats = 20;
    run();
    const struct pen_bench_row_result *row = &result.rows[0];
    for (int i = 0; i < bench.repeats; i++) {
        const struct pen_bench_times *t = &row->runs[i];
        several += t->in_a_row > 1;
        ck_assert(t->build_ms + t->render_ms > 0);
        ck_assert_msg(t->in_a_row > 1 || t->build_ms + t->render_ms >= 1, "%g ms, once",
                      t->build_ms + t->render_ms);
    }
    ck_assert_int_gt(several, 0); /* it takes some microseconds */
    ck_assert_uint_eq(row->stats.rays.primary, 16u * (unsigned)kit.settings.samples_per_pixel);
    json_t *report = pen_bench_report_new(&bench, &result, json_object());
    char *notes = json_dumps(json_object_get(report, "notes"), 0);
    ck_assert_msg(several < bench.repeats || strstr(notes, "a run of row 0 takes less than 1 ms"),
                  "%s", notes);
    free(notes);
    json_decref(report);
    tear_down();
}
END_TEST

START_TEST(test_bench__runs_that_wait_are_spoiled_and_decide_nothing)
{
    set_up(1);
    add_equal_rows();
    bench.repeats = 10;
    dawdle_ms = 200;
    dawdle_sleeps = true; /* like a thread without a processor */
    run();
    const struct pen_bench_row_result *row = &result.rows[1];
    ck_assert_int_eq(row->spoiled, 10);
    ck_assert(row->used < 0.9);
    ck_assert_int_eq(row->verdict, PEN_VERDICT_UNDECIDED);
    ck_assert(!row->ratio.bounded);
    ck_assert_ptr_nonnull(strstr(row->reason, "too many runs are spoiled"));
    json_t *report = pen_bench_report_new(&bench, &result, json_object());
    char *notes = json_dumps(json_object_get(report, "notes"), 0);
    ck_assert_msg(strstr(notes, "10 of 10 runs of row 1 are spoiled") != NULL, "%s", notes);
    json_t *last = json_array_get(json_object_get(report, "rows"), 1);
    ck_assert_uint_eq(json_array_size(json_object_get(last, "spoiled_runs")), 10);
    free(notes);
    json_decref(report);
    tear_down();
}
END_TEST

/* Checks that the benchmark ended because its interval is narrow. On a machine on which most runs
 * are spoiled, it ends at the most repeats without an interval. */
static void check_ended_by_interval(void)
{
    const struct pen_confidence *ratio = &result.rows[1].ratio;
    if (result.end == PEN_BENCH_END_INTERVAL) {
        ck_assert(ratio->bounded);
    } else {
        ck_assert_int_eq(result.end, PEN_BENCH_END_REPEATS);
        ck_assert_int_eq(result.repeats, PEN_PAIRS_MAX);
        ck_assert_int_ge(ratio->spoiled, PEN_PAIRS_MAX / 4);
    }
}

START_TEST(test_bench__repeats_end_when_the_interval_is_narrow)
{
    set_up(1);
    add_equal_rows();
    bench.interval = 1e6;
    bench.budget_ms = 1e9;
    dawdle_ms = 1;
    run();
    check_ended_by_interval();
    ck_assert_int_eq(result.repeats % 10, 0);
    ck_assert_int_eq(total, 3 * (result.repeats + 1) + 1);
    ck_assert_int_eq(progress[progress_count - 1], total);
    tear_down();
}
END_TEST

START_TEST(test_bench__repeats_end_when_the_budget_is_spent)
{
    set_up(1);
    add_equal_rows();
    dawdle_ms = 1;
    bench.interval = 1e-9;
    bench.budget_ms = 200;
    const int64_t begun_ns = pen_clock_ns();
    run();
    const double took_ms = (double)(pen_clock_ns() - begun_ns) * 1e-6;
    ck_assert_int_eq(result.end, PEN_BENCH_END_BUDGET);
    ck_assert_int_ge(result.repeats, 1);
    ck_assert_int_lt(result.repeats, PEN_PAIRS_MAX);
    ck_assert_double_ge(took_ms, 200);
    ck_assert_timed(took_ms < 60000);
    tear_down();
}
END_TEST

START_TEST(test_bench__faster_with_another_picture_is_no_speed_up)
{
    set_up(1);
    bench.repeats = 10;
    kit.settings.width = kit.settings.height = 16;
    add_row("{\"precision\": \"robust\"}");
    add_row("{\"precision\": \"fast\"}")->max_depth = 0; /* simulates a wrong result */
    run();
    ck_assert(result.rows[0].picture_hash != result.rows[1].picture_hash);
    ck_assert_int_eq(result.rows[1].verdict, PEN_VERDICT_DIFFERENT_PICTURE);
    tear_down();
}
END_TEST

START_TEST(test_bench__picture_hash_is_that_of_the_film)
{
    set_up(1);
    add_none_and_auto();
    run();
    struct pen_film *film = pen_film_new(kit.settings.width, kit.settings.height, &st);
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_render_stats stats;
    struct pen_render_task task = {
        .scene = scene, .settings = &kit.settings, .tile_count = -1, .rgb = film->rgb};
    ck_assert(pen_render_run(bench.frame.pool, &task, &stats, &st));
    ck_assert(result.rows[0].picture_hash == pen_film_hash(film));
    ck_assert(result.rows[1].picture_hash == pen_film_hash(film));
    pen_scene_free(scene);
    pen_film_free(film);
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
    ck_assert_ptr_null(strstr(notes, "row 1 asks"));
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

/* Changes the last bit of one value of the fourth picture. */
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
    ck_assert_ptr_nonnull(strstr(st.msg, "row 0 (accelerator none)"));
    char other[40];
    snprintf(other, sizeof other, "row %d (accelerator ", seen[3]);
    ck_assert_ptr_nonnull(strstr(st.msg, other));
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

/* The saved state of an interrupted benchmark. */
static struct unfinished_bed bed;

/* Makes the benchmark be saved, and interrupted after this number of runs. */
static void interrupt_after(int runs)
{
    bench.frame.between = unfinished_keep;
    bench.frame.user = &bed;
    bed.runs_left = runs;
}

/* Runs the benchmark until it ends, interrupted after every `each` runs. Returns the number of
 * interruptions. */
static int run_in_parts(int each)
{
    for (int interruptions = 0;; interruptions++) {
        interrupt_after(each);
        if (pen_bench_run(&bench, &result, &st)) {
            unfinished_release(&bed);
            return interruptions;
        }
        ck_assert_msg(st.code == PEN_UNAVAILABLE, "%s", st.msg);
        pen_bench_result_release(&bench, &result);
        bench.frame.kept = &bed.kept;
    }
}

START_TEST(test_bench__interrupted_benchmark_makes_the_runs_of_a_whole_one)
{
    int whole[SEEN_MAX], whole_count;
    set_up(2);
    add_none_and_auto();
    bench.tamper = note_row;
    bench.order_seed = 9;
    run();
    whole_count = seen_count;
    memcpy(whole, seen, sizeof whole);
    const uint64_t hash = result.rows[0].picture_hash, boxes = result.rows[1].stats.tests.boxes;
    pen_bench_result_release(&bench, &result);
    seen_count = 0;
    const int interruptions = run_in_parts(3);
    ck_assert_int_ge(interruptions, 2);
    ck_assert_int_eq(result.breaks, interruptions);
    ck_assert_int_eq(seen_count,
                     whole_count + interruptions); /* each process discards its first run */
    for (int i = 0, at = 0; i < seen_count; i++) {
        if (i > 0 && i % 4 == 3 && at < whole_count) {
            ck_assert_int_eq(seen[i], 0); /* of the baseline */
            continue;
        }
        ck_assert_msg(seen[i] == whole[at], "run %d", i);
        at++;
    }
    ck_assert_int_eq(result.repeats, 3);
    ck_assert(result.rows[0].picture_hash == hash && result.rows[1].stats.tests.boxes == boxes);
    for (int row = 0; row < 2; row++)
        for (int i = 0; i < 3; i++)
            ck_assert(result.rows[row].runs[i].render_ms > 0);
    json_t *report = pen_bench_report_new(&bench, &result, json_object());
    size_t i;
    json_t *note;
    int said = 0;
    json_array_foreach(json_object_get(report, "notes"), i, note)
    {
        said += strstr(json_string_value(note), "was interrupted") != NULL;
    }
    ck_assert_int_eq(said, 1);
    json_decref(report);
    tear_down();
}
END_TEST

START_TEST(test_bench__what_is_kept_of_another_benchmark_is_not_used)
{
    static const char *const changes[][2] = {
        {"/version", "99"},        {"/kind", "\"effects\""},
        {"/order_seed", "5"},      {"/warmup", "2"},
        {"/host", "{}"},           {"/pool_threads", "7"},
        {"/passes", "100"},        {"/passes", "-1"},
        {"/place", "2"},           {"/rows", "[1]"},
        {"/rows/1/runs", "[]"},    {"/rows/1/runs", "[1, 2]"},
        {"/rows/1/threads", "-1"}, {"/rows/0/picture_hash", "\"\""},
        {"/elapsed_ms", "-1"}};
    struct pen_kept_study last;
    set_up(1);
    add_none_and_auto();
    interrupt_after(4);
    ck_assert(!pen_bench_run(&bench, &result, &st));
    pen_bench_result_release(&bench, &result);
    bench.frame.between = NULL;
    last = bed.kept;
    bench.frame.kept = &last;
    for (size_t i = 0; i < sizeof changes / sizeof changes[0]; i++) {
        json_t *bad = unfinished_changed(bed.state, changes[i][0], changes[i][1]);
        last.state = bad;
        run();
        ck_assert_msg(result.breaks == 0, "%s %s", changes[i][0], changes[i][1]);
        pen_bench_result_release(&bench, &result);
        json_decref(bad);
    }
    last.state = bed.state;
    run();
    ck_assert_int_eq(result.breaks, 1);
    unfinished_release(&bed);
    tear_down();
}
END_TEST

START_TEST(test_bench__pictures_must_stay_the_same_over_an_interruption)
{
    set_up(1);
    add_none_and_auto();
    interrupt_after(4);
    ck_assert(!pen_bench_run(&bench, &result, &st));
    pen_bench_result_release(&bench, &result);
    json_object_set_new(json_array_get(json_object_get(bed.state, "rows"), 0), "picture_hash",
                        json_integer(7));
    bench.frame.between = NULL;
    bench.frame.kept = &bed.kept;
    ck_assert(!pen_bench_run(&bench, &result, &st));
    ck_assert_int_eq(st.code, PEN_DIFFERENT);
    unfinished_release(&bed);
    tear_down();
}
END_TEST

START_TEST(test_bench__cancel_ends_it_between_runs_and_within_one)
{
    set_up(1);
    add_none_and_auto();
    bench.frame.cancel = &cancel;
    bench.frame.progress = cancel_at_five;
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
        "settings", "threads",   "median_ms",   "min_ms",           "max_ms",
        "runs_ms",  "speedup",   "rays",        "accelerator",      "rmse",
        "build_ms", "render_ms", "cpu_ms",      "mrays_per_second", "max_difference",
        "ratio",    "verdict",   "reason",      "spoiled_runs",     "cpu_share",
        "steal_ms", "tests",     "picture_hash"};
    static const char *const hosts[] = {"name",     "id",    "microcode", "governor", "kernel",
                                        "compiler", "build", "cpu",       "cores"};
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
    for (size_t i = 0; i < sizeof hosts / sizeof hosts[0]; i++)
        ck_assert_msg(json_object_get(json_object_get(report, "host"), hosts[i]) != NULL, "no %s",
                      hosts[i]);
    ck_assert_int_eq(json_integer_value(json_object_get(report, "pool_threads")), 2);
    json_decref(report);
    tear_down();
}
END_TEST

PEN_SUITE("bench", test_bench__runs_are_interleaved_after_the_warm_up,
          test_bench__order_of_a_pass_is_random_and_follows_from_the_seed,
          test_bench__ratio_is_the_median_of_the_pairs_of_one_repeat,
          test_bench__few_repeats_have_neither_twin_nor_verdict,
          test_bench__runs_below_a_millisecond_are_made_several_times_in_a_row,
          test_bench__runs_that_wait_are_spoiled_and_decide_nothing,
          test_bench__repeats_end_when_the_budget_is_spent,
          test_bench__faster_with_another_picture_is_no_speed_up,
          test_bench__picture_hash_is_that_of_the_film,
          test_bench__medians_and_speedups_are_those_of_the_runs,
          test_bench__rays_and_tests_are_those_of_a_plain_render,
          test_bench__threads_beyond_the_pool_are_capped_and_noted,
          test_bench__other_pictures_are_measured_against_the_first_of_their_size,
          test_bench__one_bit_of_difference_fails_it_and_is_named,
          test_bench__interrupted_benchmark_makes_the_runs_of_a_whole_one,
          test_bench__what_is_kept_of_another_benchmark_is_not_used,
          test_bench__pictures_must_stay_the_same_over_an_interruption,
          test_bench__cancel_ends_it_between_runs_and_within_one,
          test_bench__report_has_the_members_of_the_api, PEN_TIMED,
          test_bench__repeats_end_when_the_interval_is_narrow)
