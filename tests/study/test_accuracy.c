/* SPDX-License-Identifier: MIT */
/* Accuracy studies: their results are compared with pictures that are rendered here, of a small
 * room with soft shadows. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "film/encode.h"
#include "jobs/accuracy_spec.h"
#include "report/report.h"
#include "study/accuracy.h"
#include "study/accuracy_summary.h"
#include "support/kit.h"
#include "support/suite.h"
#include "support/unfinished.h"

enum { THREADS = 2 };

static struct kit kit;
static struct pen_accuracy_spec spec;
static struct pen_accuracy accuracy;
static struct pen_thread_pool *pool;
static struct pen_status st;

/* A sphere over a floor, below a light with a radius. Only its shadow is sampled. */
static void make_scene(void)
{
    kit_init(&kit);
    kit.settings.width = 48;
    kit.settings.height = 36;
    kit.settings.seed = 7;
    kit.view.camera.position = pen_vec3(0, 3, 8);
    kit.view.camera.direction = pen_vec3(0, -0.4, -1);
    kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 1, 0), kit_material(&kit, kit_matte(0.75)));
    kit_sphere(&kit, pen_vec3(0, 1.5, 0), 1, kit_material(&kit, kit_matte(0.5)));
    kit_point(&kit, pen_vec3(2, 6, 2), pen_vec3(1, 1, 1))->radius = 1.5;
}

static struct pen_accuracy_task task_of(const char *members)
{
    struct pen_errors errors = {0};
    json_t *json = json_loads(members, 0, NULL);
    ck_assert_msg(json != NULL, "%s", members);
    if (!pen_accuracy_spec_read(json, &kit.desc, &kit.settings, &spec, &errors))
        ck_abort_msg("%s: %s", errors.item[0].at, errors.item[0].msg);
    json_decref(json);
    pool = pen_thread_pool_new(THREADS, &st);
    ck_assert_ptr_nonnull(pool);
    struct pen_accuracy_task task = pen_accuracy_of_spec(&spec);
    task.frame.desc = &kit.desc;
    task.settings = &kit.settings;
    task.limits = pen_limits_default();
    task.frame.pool = pool;
    return task;
}

static void make(const struct pen_accuracy_task *task)
{
    ck_assert_msg(pen_accuracy_make(task, &accuracy, &st), "%s", st.msg);
}

static void release(void)
{
    pen_accuracy_release(&accuracy);
    pen_accuracy_spec_release(&spec);
    pen_thread_pool_free(pool);
}

static float *render(struct pen_settings settings, uint64_t seed)
{
    settings.seed = seed;
    struct pen_scene *scene = kit_freeze(&kit);
    float *film = kit_film(scene, &settings, THREADS);
    pen_scene_free(scene);
    return film;
}

static double rmse_of(const float *a, const float *b)
{
    const int values = 3 * kit.settings.width * kit.settings.height;
    double sum = 0;
    for (int i = 0; i < values; i++) {
        const double d = pen_encode_unit((double)a[i], PEN_TRANSFER_SRGB) -
                         pen_encode_unit((double)b[i], PEN_TRANSFER_SRGB);
        sum += d * d;
    }
    return sqrt(sum / values);
}

START_TEST(test_accuracy__rows_are_what_their_settings_render)
{
    make_scene();
    const struct pen_accuracy_task task =
        task_of("{\"ladder\": {\"light_samples\": [1, 4, 16]}, \"seeds\": 3}");
    make(&task);
    for (int i = 0; i < 3; i++) {
        const struct pen_accuracy_row_result *row = &accuracy.row[i];
        ck_assert_int_eq(row->runs, 3);
        for (int run = 0; run < 3; run++) {
            float *film = render(spec.rows[i].settings, 7 + (uint64_t)run);
            const double error = row->run[run].error[PEN_METRIC_RMSE];
            if (run == 0)
                ck_assert_mem_eq(film, row->rgb, 3 * 48 * 36 * sizeof *film);
            ck_assert_msg(fabs(rmse_of(film, accuracy.reference.rgb) - error) < 1e-12,
                          "row %d, run %d", i, run);
            free(film);
        }
    }
    release();
}
END_TEST

/* The estimated error of the reference agrees with its error against a reference of 16 times the
 * samples. */
START_TEST(test_accuracy__reference_knows_its_error)
{
    make_scene();
    const struct pen_accuracy_task task =
        task_of("{\"ladder\": {\"light_samples\": [1, 4, 16]}, \"seeds\": 1}");
    make(&task);
    struct pen_settings far = accuracy.reference.settings;
    const double best = pen_accuracy_error_of(&accuracy.row[2], PEN_METRIC_RMSE).median;
    ck_assert_int_ge(far.light_samples, 8 * 16);
    ck_assert_msg(accuracy.reference.error <= best / 5, "%g of %g", accuracy.reference.error, best);
    far.light_samples *= 16;
    float *film = render(far, 99);
    const double error = rmse_of(film, accuracy.reference.rgb);
    ck_assert_msg(error > 0.7 * accuracy.reference.error && error < 1.4 * accuracy.reference.error,
                  "estimated %g, found %g", accuracy.reference.error, error);
    free(film);
    release();
}
END_TEST

START_TEST(test_accuracy__given_reference_is_kept_and_resolves_what_it_can)
{
    make_scene();
    const struct pen_accuracy_task task =
        task_of("{\"ladder\": {\"light_samples\": [1, 64]}, \"seeds\": 2,"
                " \"reference\": {\"light_samples\": 64}}");
    make(&task);
    ck_assert_int_eq(accuracy.reference.settings.light_samples, 64);
    ck_assert(pen_accuracy_resolved(&accuracy, &accuracy.row[1]));
    ck_assert(!pen_accuracy_resolved(&accuracy,
                                     &accuracy.row[2])); /* its error is that of the reference */
    json_t *report = pen_accuracy_json(&accuracy, "s"), *rows = json_object_get(report, "rows");
    const json_t *row = json_array_get(rows, 2);
    ck_assert(json_is_false(json_object_get(row, "resolved")));
    ck_assert(json_is_null(json_object_get(row, "rmse")));
    ck_assert(fabs(json_number_value(json_object_get(row, "rmse_below")) /
                       (2 * accuracy.reference.error) -
                   1) < 1e-3);
    ck_assert_uint_eq(json_array_size(json_object_get(report, "left_out")), 1);
    json_decref(report);
    release();
}
END_TEST

/* Rows with given times and errors, to test the results that follow from them. */
static struct pen_accuracy_row_result row_of(struct pen_accuracy_run *run, double ms, double rmse)
{
    *run = (struct pen_accuracy_run){
        .time = {.ms = ms, .used = 1},
        .error = {[PEN_METRIC_RMSE] = rmse, [PEN_METRIC_PSNR] = -log10(rmse)}};
    return (struct pen_accuracy_row_result){.runs = 1, .run = run};
}

START_TEST(test_accuracy__front_and_target)
{
    struct pen_accuracy_task task = {.row_count = 6, .metric = PEN_METRIC_RMSE, .target = 0.035};
    struct pen_accuracy_run run[6];
    struct pen_accuracy_row_result row[6] = {
        row_of(&run[0], 10, 0.10),  row_of(&run[1], 20, 0.03),   row_of(&run[2], 25, 0.04),
        row_of(&run[3], 40, 0.001), row_of(&run[4], 50, 0.0005), row_of(&run[5], 20, 0.03)};
    const struct pen_accuracy a = {.task = &task, .row = row, .reference.error = 0.001};
    static const bool wanted[] = {true, true, false, true, false, false};
    bool front[PEN_ACCURACY_ROWS_MAX];
    pen_accuracy_front(&a, front);
    for (int i = 0; i < 6; i++) /* 3 and 4 are unresolved, 5 equals 1 */
        ck_assert_msg(front[i] == wanted[i], "row %d", i);
    ck_assert_int_eq(pen_accuracy_recommended(&a), 1);
    task.target = 0.0001;
    ck_assert_int_eq(pen_accuracy_recommended(&a), -1);
    task.metric = PEN_METRIC_PSNR; /* more is better */
    task.target = 1.45;
    ck_assert_int_eq(pen_accuracy_recommended(&a), 1);
    row[1].runs = row[5].runs = 0; /* left out */
    ck_assert_int_eq(pen_accuracy_recommended(&a), 3);
}
END_TEST

START_TEST(test_accuracy__times_that_say_nothing_give_way_to_rays)
{
    struct pen_accuracy_task task = {.row_count = 3, .metric = PEN_METRIC_RMSE, .target = 1};
    struct pen_accuracy_run run[3];
    struct pen_accuracy_row_result row[3] = {row_of(&run[0], 20, 0.03), row_of(&run[1], 20.3, 0.04),
                                             row_of(&run[2], 40, 0.02)};
    const struct pen_accuracy a = {.task = &task, .row = row};
    row[0].rays.shadow = 300;
    row[1].rays.shadow = 200;
    row[2].rays.shadow = 100;
    ck_assert_int_eq(pen_accuracy_recommended(&a), 1); /* of equal times, the fewer rays */
    run[2].time.used = 0.5;                            /* its threads waited for 20 of 40 ms */
    ck_assert_int_eq(pen_accuracy_recommended(&a), 2);
    run[2].time = (struct pen_run_time){.ms = 40, .used = 1};
    run[1].time.spoiled = true;
    ck_assert_int_eq(pen_accuracy_recommended(&a), 1); /* one of three is spoiled */
    run[0].time.spoiled = true;
    ck_assert_int_eq(pen_accuracy_recommended(&a), -1);
}
END_TEST

/* Rows that differ in light_samples, each with 4 times as many as the row before, and with 4 camera
 * rays. The reference samples the area of pixels. */
struct ladder {
    struct pen_accuracy_task task;
    struct pen_accuracy_row rows[PEN_ACCURACY_ROWS_MAX];
    struct pen_accuracy_row_result row[PEN_ACCURACY_ROWS_MAX];
    struct pen_accuracy_run run[PEN_ACCURACY_ROWS_MAX];
    struct pen_accuracy accuracy;
};

static void add_rung(struct ladder *l, int camera, int light, double rmse)
{
    const int i = l->task.row_count++;
    l->rows[i] = (struct pen_accuracy_row){
        kit.settings, json_pack("{s:i, s:i}", "light_samples", light, "samples_per_pixel", camera)};
    l->rows[i].settings.samples_per_pixel = camera;
    l->rows[i].settings.light_samples = light;
    l->row[i] = row_of(&l->run[i], 10, rmse);
    l->task.frame.desc = &kit.desc;
    l->task.rows = l->rows;
    l->task.metric = PEN_METRIC_RMSE;
    l->accuracy.task = &l->task;
    l->accuracy.row = l->row;
    l->accuracy.reference.settings.samples_per_pixel = 32;
}

static void drop(struct ladder *l)
{
    for (int i = 0; i < l->task.row_count; i++)
        json_decref((json_t *)(uintptr_t)l->rows[i].varied);
    *l = (struct ladder){0};
}

START_TEST(test_accuracy__slopes_tell_which_error_is_left)
{
    static const double slopes[] = {-0.5, -0.75, -1};
    struct ladder l = {0};
    struct pen_accuracy_series series;
    make_scene();
    for (size_t s = 0; s < 3; s++) { /* no slope alone is reported as a floor */
        for (int i = 0; i < 4; i++)
            add_rung(&l, 4, 1 << 2 * i, 0.1 * pow(1 << 2 * i, slopes[s]));
        series = pen_accuracy_series_of(&l.accuracy, 0, PEN_SAMPLE_LIGHT, false);
        ck_assert_msg(series.line.known && !series.floored, "%g: %g", slopes[s], series.floor);
        drop(&l);
    }
    /* An error of 0.01 from edges. The light's own error is 0.04 N^-0.75, which is 0.0018 at 64. */
    for (int i = 3; i >= 0; i--)
        add_rung(&l, 4, 1 << 2 * i, hypot(0.01, 0.04 * pow(1 << 2 * i, -0.75)));
    series = pen_accuracy_series_of(&l.accuracy, 0, PEN_SAMPLE_LIGHT, false);
    ck_assert(series.floored && series.causes == 1u << PEN_SAMPLE_PIXEL);
    ck_assert_msg(fabs(series.floor - 1 / (1 + 0.04 * 0.04 / 0.01 / 0.01 / 512)) < 1e-3, "%g",
                  series.floor);
    /* A target of half of that needs at least 4 times the camera rays: 4 * 2^2, and a little more
     * for the light's part. */
    l.task.target = 0.005;
    struct pen_accuracy_need need = pen_accuracy_needed(&l.accuracy);
    ck_assert_str_eq(need.setting, "samples_per_pixel");
    ck_assert_msg(need.samples == 17, "%g", need.samples);
    ck_assert_msg(need.ms > 10 * 17.0 / 4 / 1.01 && need.ms < 10 * 17.0 / 4 * 1.01, "%g", need.ms);
    drop(&l);
    /* If the light causes most of the error, edges are not named, and more light samples are
     * needed. */
    for (int i = 0; i < 3; i++)
        add_rung(&l, 4, 1 << 2 * i, 0.1 * pow(1 << 2 * i, -0.75));
    l.task.target = 0.1 * pow(64, -0.75);
    need = pen_accuracy_needed(&l.accuracy);
    ck_assert_str_eq(need.setting, "light_samples");
    ck_assert_msg(fabs(need.samples - 64) <= 1, "%g", need.samples);
    drop(&l);
}
END_TEST

/* Distant checkers under a light with a radius: with 4 camera rays, only edges cause the remaining
 * error. */
START_TEST(test_accuracy__edges_are_named_where_they_are_what_is_left)
{
    make_scene();
    kit.settings.samples_per_pixel = 4;
    for (int i = 0; i < 40; i++)
        kit_sphere(&kit, pen_vec3(i % 8 - 3.5, 0.2, i / 8 - 1.5), 0.15,
                   kit_material(&kit, kit_matte(i % 2)));
    const struct pen_accuracy_task task =
        task_of("{\"ladder\": {\"light_samples\": [1, 4, 16, 64]}, \"seeds\": 1}");
    make(&task);
    json_t *report = pen_accuracy_json(&accuracy, "s");
    struct pen_buf out = {0};
    ck_assert(pen_report_write(report, "text", NULL, &out, &st));
    const char *text = (const char *)out.data;
    ck_assert_msg(strstr(text, "does not come from soft shadows, but from edges, which take more "
                               "than samples_per_pixel 4."),
                  "%s", text);
    pen_buf_release(&out);
    json_decref(report);
    release();
}
END_TEST

/* Delays the threads, as other programs that use the processors do, and counts the renders of the
 * whole picture. */
static void wait_a_little(void *user, int thread, int x, int y)
{
    (void)thread;
    if (x == 0 && y == 0)
        atomic_fetch_add((atomic_int *)user, 1);
    if (x == 0)
        usleep(1000);
}

START_TEST(test_accuracy__spoiled_runs_are_repeated_and_recommend_nothing)
{
    static const char *const formats[] = {"text", "md"};
    atomic_int renders = 0;
    make_scene();
    struct pen_accuracy_task task =
        task_of("{\"ladder\": {\"light_samples\": [1, 4]}, \"seeds\": 2, \"target\": "
                "{\"metric\": \"flip\", \"value\": 1}}");
    task.frame.pixel_begins = wait_a_little;
    task.frame.pixel_user = &renders;
    task.budget_ms = 1e6;
    make(&task);
    const struct pen_runs_use use = pen_accuracy_use(&accuracy);
    ck_assert_int_eq(use.runs, 2 * task.row_count);
    ck_assert_int_eq(use.spoiled, use.runs);
    ck_assert_int_ge(atomic_load(&renders), 3 * use.runs);
    ck_assert_int_eq(pen_accuracy_recommended(&accuracy), -1);
    json_t *report = pen_accuracy_json(&accuracy, "s");
    ck_assert(json_is_null(json_object_get(report, "recommended")));
    for (int i = 0; i < 2; i++) {
        struct pen_buf out = {0};
        ck_assert(pen_report_write(report, formats[i], NULL, &out, &st));
        const char *words = strstr((const char *)out.data, " runs are spoiled: other programs");
        ck_assert_ptr_nonnull(words);
        ck_assert_ptr_nonnull(strstr(words, "No row is recommended"));
        ck_assert_int_eq(words - (const char *)out.data < 30, 1);
        pen_buf_release(&out);
    }
    json_decref(report);
    release();
}
END_TEST

/* The report comments on a forecast that was far from the real time. */
START_TEST(test_accuracy__overruns_are_commented)
{
    static const struct {
        double took, share, factor;
        const char *words;
    } cases[] = {{25, 1, 8, NULL},
                 {322, 0.3, 8, "That is 13.4 times as long: other programs"},
                 {322, 1, 32, "the reference was made again, with 32 times"},
                 {322, 1, 8, "the forecast, which renders a few pixels"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct pen_buf out = {0};
        json_t *report =
            json_pack("{s:s, s:f, s:{s:f, s:f, s:f, s:f}, s:{s:f}, s:{s:f}}", "kind", "accuracy",
                      "budget_seconds", 600.0, "forecast", "expected_seconds", 24.0, "low", 20.0,
                      "high", 30.0, "actual", cases[i].took, "timing", "cpu_share", cases[i].share,
                      "reference", "factor", cases[i].factor);
        ck_assert(pen_report_write(report, "text", NULL, &out, &st));
        const char *text = (const char *)out.data;
        if (cases[i].words)
            ck_assert_msg(strstr(text, cases[i].words) != NULL, "%s", text);
        else
            ck_assert_msg(strstr(text, "times as long") == NULL, "%s", text);
        pen_buf_release(&out);
        json_decref(report);
    }
}
END_TEST

START_TEST(test_accuracy__fitted_slope_and_its_interval)
{
    /* First y = 3 x^-0.75 without noise. Then points whose line and interval are known: x =
     * e^0..e^4 with log y = 0, 1, 0, 1, 0. The slope is 0, the residual variance is 1.2 / 3, and
     * the sum of squares of log x is 10. So the half-width is 3.182 sqrt(0.04). */
    double x[5], y[5];
    for (int i = 0; i < 5; i++) {
        x[i] = pow(4, i);
        y[i] = 3 * pow(x[i], -0.75);
    }
    struct pen_accuracy_line line = pen_accuracy_fit(x, y, 5);
    ck_assert(line.known && fabs(line.slope + 0.75) < 1e-12 && fabs(line.at_1 - 3) < 1e-12);
    ck_assert(fabs(line.high - line.low) < 1e-6);
    for (int i = 0; i < 5; i++) {
        x[i] = exp(i);
        y[i] = exp(i % 2);
    }
    line = pen_accuracy_fit(x, y, 5);
    ck_assert(fabs(line.slope) < 1e-12);
    ck_assert(fabs(line.high - 3.182 * 0.2) < 1e-12 && fabs(line.low + 3.182 * 0.2) < 1e-12);
    ck_assert(!pen_accuracy_fit(x, y, 2).known);
}
END_TEST

START_TEST(test_accuracy__convergence_of_the_study)
{
    make_scene();
    const struct pen_accuracy_task task =
        task_of("{\"ladder\": {\"light_pattern\": [\"random\", \"sobol\"],"
                " \"light_samples\": [1, 4, 16, 64]}, \"product\": true, \"seeds\": 3}");
    make(&task);
    json_t *report = pen_accuracy_json(&accuracy, "s"),
           *series = json_object_get(report, "convergence");
    ck_assert_uint_eq(json_array_size(series), 2);
    for (size_t i = 0; i < 2; i++) {
        const json_t *one = json_array_get(series, i);
        const double slope = json_number_value(json_object_get(one, "slope")),
                     expected = json_number_value(json_object_get(one, "expected"));
        ck_assert(expected == (i == 0 ? -0.5 : -0.75));
        ck_assert_msg(fabs(slope - expected) < 0.12, "%g, expected %g", slope, expected);
        ck_assert_uint_eq(json_array_size(json_object_get(one, "points")), 4);
    }
    json_decref(report);
    release();
}
END_TEST

START_TEST(test_accuracy__budget_leaves_out_the_dearest_and_says_so)
{
    make_scene();
    kit.settings.light_samples = 1;
    struct pen_accuracy_task task =
        task_of("{\"ladder\": {\"light_samples\": [100000000]}, \"budget_seconds\": 20}");
    task.seeds = 2;
    make(&task);
    ck_assert_int_ge(accuracy.row[0].runs, 1);
    ck_assert_int_eq(accuracy.row[1].runs, 0);
    const char *text = json_string_value(json_array_get(accuracy.left_out, 0));
    ck_assert_ptr_nonnull(text);
    ck_assert_ptr_nonnull(strstr(text, "light_samples 100000000: one run is expected to take"));
    json_t *report = pen_accuracy_json(&accuracy, "s");
    struct pen_buf out = {0};
    ck_assert(pen_report_write(report, "text", NULL, &out, &st));
    ck_assert_ptr_nonnull(strstr((const char *)out.data, "left out: light_samples 100000000"));
    pen_buf_release(&out);
    ck_assert(pen_accuracy_figures(&accuracy, report, &out, &st));
    pen_buf_release(&out);
    json_decref(report);
    release();
}
END_TEST

START_TEST(test_accuracy__formats)
{
    static const struct {
        const char *format, *words;
    } formats[] = {{"text", "The cheapest row with FLIP at most"},
                   {"csv", "row,light_samples,runs,median_ms"},
                   {"md", "# Accuracy: a\\<b\\>"},
                   {"json", "\"kind\": \"accuracy\""}};
    make_scene();
    const struct pen_accuracy_task task =
        task_of("{\"ladder\": {\"light_samples\": [1, 16, 256]}, \"seeds\": 2,"
                " \"target\": {\"metric\": \"flip\", \"value\": 0.5}}");
    make(&task);
    json_t *report = pen_accuracy_json(&accuracy, "a<b>");
    struct pen_buf out = {0};
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++) {
        ck_assert(pen_report_write(report, formats[i].format, NULL, &out, &st));
        const char *words =
            strcmp(formats[i].format, "md") == 0 ? "# Accuracy: a&lt;b\\>" : formats[i].words;
        ck_assert_msg(strstr((const char *)out.data, words) != NULL, "%s: %s", formats[i].format,
                      (const char *)out.data);
        pen_buf_release(&out);
    }
    struct pen_buf figures = {0};
    ck_assert(pen_accuracy_figures(&accuracy, report, &figures, &st));
    ck_assert(pen_report_write(report, "html", &figures, &out, &st));
    const char *page = (const char *)out.data;
    ck_assert_ptr_nonnull(strstr(page, "<h1>Accuracy: a&lt;b&gt;</h1>"));
    ck_assert_ptr_nonnull(strstr(page, "<figure class=\"reference\""));
    ck_assert_ptr_nonnull(strstr(page, "<figure class=\"picture\" data-row=\"2\""));
    ck_assert_ptr_nonnull(strstr(page, "<figure class=\"map\" data-row=\"2\""));
    ck_assert_ptr_nonnull(strstr(page, "pale yellow a FLIP of "));
    pen_buf_release(&figures);
    pen_buf_release(&out);
    json_decref(report);
    release();
}
END_TEST

static void cancel_after_two(void *user, int done, int total)
{
    (void)total;
    if (done >= 2)
        atomic_store((atomic_bool *)user, true);
}

START_TEST(test_accuracy__can_be_cancelled)
{
    make_scene();
    struct pen_accuracy_task task = task_of("{\"ladder\": {\"light_samples\": [1, 4, 16]}}");
    atomic_bool cancel = false;
    task.frame.cancel = &cancel;
    task.frame.progress = cancel_after_two;
    task.frame.user = &cancel;
    ck_assert(!pen_accuracy_make(&task, &accuracy, &st));
    ck_assert_int_eq(st.code, PEN_CANCELLED);
    release();
}
END_TEST

START_TEST(test_accuracy__targets_and_depths_are_rows)
{
    make_scene();
    const struct pen_accuracy_task task =
        task_of("{\"ladder\": {\"target_error\": [0.05], \"max_depth\": [1]}, \"seeds\": 1}");
    make(&task);
    ck_assert(pen_settings_adaptive(&spec.rows[1].settings));
    ck_assert(accuracy.reference.settings.target_error == 0);
    ck_assert_int_gt(accuracy.reference.settings.samples_per_pixel, 32);
    const double error = pen_accuracy_error_of(&accuracy.row[1], PEN_METRIC_RMSE).median;
    ck_assert_msg(error <= 0.05, "%g", error);
    release();
}
END_TEST

static const char steps[] = "{\"ladder\": {\"light_samples\": [1, 4, 16]}, \"seeds\": 3}";

/* A study with enough time, whose reference may be interrupted after each tile. */
static struct pen_accuracy_task patient_task(void)
{
    make_scene();
    kit.settings.tile = 16;
    struct pen_accuracy_task task = task_of(steps);
    task.budget_ms = 1e9;
    task.at_once_ms = 1e-6;
    task.metric = PEN_METRIC_RMSE;
    return task;
}

static void check_same_row(const struct pen_accuracy_row_result *a,
                           const struct pen_accuracy_row_result *b)
{
    ck_assert_int_eq(b->runs, a->runs);
    ck_assert_uint_eq(b->picture_hash, a->picture_hash);
    ck_assert_int_eq(b->threads, a->threads);
    ck_assert_mem_eq(&b->rays, &a->rays, sizeof a->rays);
    ck_assert_mem_eq(b->rgb, a->rgb, 3 * 48 * 36 * sizeof *a->rgb);
    for (int run = 0; run < a->runs; run++) {
        ck_assert(b->run[run].time.ms > 0);
        for (int m = 0; m < PEN_METRIC_COUNT; m++)
            ck_assert_msg(b->run[run].error[m] == a->run[run].error[m], "run %d: %s", run,
                          pen_metrics[m]);
    }
}

START_TEST(test_accuracy__interrupted_study_has_the_results_of_a_whole_one)
{
    struct unfinished_bed bed = {0};
    struct pen_accuracy_task task = patient_task();
    struct pen_accuracy whole;
    int interruptions = 0;
    make(&task);
    whole = accuracy;
    /* Only the best row meets the target, so times do not decide which row is recommended. */
    task.target = 1.01 * whole.row[2].run[0].error[PEN_METRIC_RMSE];
    const struct pen_accuracy_task whole_task = task;
    whole.task = &whole_task;
    task.frame.between = unfinished_keep;
    task.frame.user = &bed;
    for (bed.runs_left = 1; !pen_accuracy_make(&task, &accuracy, &st); bed.runs_left = 1) {
        ck_assert_msg(st.code == PEN_UNAVAILABLE, "%s", st.msg);
        pen_accuracy_release(&accuracy);
        task.frame.kept = &bed.kept;
        interruptions++;
    }
    /* The runs of three rows with three seeds, and two renders of 9 tiles or more. */
    ck_assert_int_ge(interruptions, 3 * 3 + 2 * 9);
    for (int i = 0; i < 3; i++)
        check_same_row(&whole.row[i], &accuracy.row[i]);
    ck_assert_int_eq(accuracy.reference.factor, whole.reference.factor);
    ck_assert(accuracy.reference.error == whole.reference.error);
    ck_assert_mem_eq(accuracy.reference.rgb, whole.reference.rgb, 3 * 48 * 36 * sizeof(float));
    ck_assert_mem_eq(&accuracy.reference.settings, &whole.reference.settings,
                     sizeof whole.reference.settings);
    ck_assert_mem_eq(&accuracy.stats.rays, &whole.stats.rays, sizeof whole.stats.rays);
    ck_assert_int_eq(pen_accuracy_recommended(&accuracy), 2);
    ck_assert_int_eq(pen_accuracy_recommended(&whole), 2);
    ck_assert(json_equal(accuracy.left_out, whole.left_out));
    ck_assert_int_ge(accuracy.began_ms, whole.began_ms);
    unfinished_release(&bed);
    pen_accuracy_release(&whole);
    release();
}
END_TEST

/* Whether the study resumes from a state in which the first row's run with the first seed took this
 * long. */
static bool goes_on_with(struct pen_accuracy_task *task, const struct pen_kept_study *kept)
{
    task->frame.kept = kept;
    make(task);
    const bool goes_on = accuracy.row[0].run[0].time.ms == 1e6;
    pen_accuracy_release(&accuracy);
    return goes_on;
}

START_TEST(test_accuracy__what_is_kept_of_another_study_is_not_used)
{
    static const char *const changes[][2] = {{"/version", "99"},
                                             {"/kind", "\"benchmark\""},
                                             {"/pool_threads", "7"},
                                             {"/host", "{}"},
                                             {"/elapsed_ms", "-1"},
                                             {"/expected_ms", "[1, 2]"},
                                             {"/left_out", "1"},
                                             {"/done", "-1"},
                                             {"/pass", "4"},
                                             {"/pass", "0"},
                                             {"/place", "4"},
                                             {"/rows/2/next", "9"},
                                             {"/rows/2/next", "-1"},
                                             {"/halves", "1"},
                                             {"/tiles", "1"},
                                             {"/factor", "0"},
                                             {"/first_hash", "7"},
                                             {"/rows", "[]"},
                                             {"/rows/2/wanted", "false"},
                                             {"/rows/2/runs", "[]"},
                                             {"/rows/2/runs", "[{}]"},
                                             {"/rows/2/threads", "-9"},
                                             {"/rows/2/shadow", "1.5"},
                                             {"/rows/2/picture_hash", "\"\""},
                                             {"/rows/2/expected_ms", "\"\""}};
    struct unfinished_bed bed = {0};
    struct pen_accuracy_task task = patient_task(), first = task;
    task.at_once_ms = 0;
    first.at_once_ms = 0;
    first.frame.between = unfinished_keep;
    first.frame.user = &bed;
    make(&first);
    pen_accuracy_release(&accuracy);
    bed.runs_left = bed.calls - 2; /* before the last two runs of the last pass */
    ck_assert(!pen_accuracy_make(&first, &accuracy, &st));
    pen_accuracy_release(&accuracy);
    json_t *marked = unfinished_changed(bed.state, "/rows/0/runs/0/ms", "1e6");
    struct pen_kept_study kept = bed.kept;
    for (size_t i = 0; i < sizeof changes / sizeof changes[0]; i++) {
        json_t *changed = unfinished_changed(marked, changes[i][0], changes[i][1]);
        kept.state = changed;
        ck_assert_msg(!goes_on_with(&task, &kept), "%s: %s", changes[i][0], changes[i][1]);
        json_decref(changed);
    }
    kept.state = NULL;
    ck_assert(!goes_on_with(&task, &kept));
    kept.state = marked;
    ck_assert(goes_on_with(&task, &kept));
    bed.picture[3][7] += 1; /* of the reference */
    ck_assert(!goes_on_with(&task, &kept));
    json_decref(marked);
    unfinished_release(&bed);
    pen_accuracy_spec_release(&spec);
    pen_thread_pool_free(pool);
}
END_TEST

PEN_SUITE("accuracy", test_accuracy__rows_are_what_their_settings_render,
          test_accuracy__reference_knows_its_error,
          test_accuracy__given_reference_is_kept_and_resolves_what_it_can,
          test_accuracy__front_and_target, test_accuracy__times_that_say_nothing_give_way_to_rays,
          test_accuracy__slopes_tell_which_error_is_left,
          test_accuracy__edges_are_named_where_they_are_what_is_left,
          test_accuracy__spoiled_runs_are_repeated_and_recommend_nothing,
          test_accuracy__overruns_are_commented, test_accuracy__fitted_slope_and_its_interval,
          test_accuracy__convergence_of_the_study,
          test_accuracy__budget_leaves_out_the_dearest_and_says_so, test_accuracy__formats,
          test_accuracy__can_be_cancelled, test_accuracy__targets_and_depths_are_rows,
          test_accuracy__interrupted_study_has_the_results_of_a_whole_one,
          test_accuracy__what_is_kept_of_another_study_is_not_used)
