/* SPDX-License-Identifier: MIT */
/* Studies, from submit to report, and the ways in which they end early: benchmarks, bills of
 * effects and explanations. */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "report/report.h"
#include "scene/scene.h"
#include "support/jobs.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES];

/* A benchmark of the test scene; `more` are members, and end in a comma. */
static const char *benchmark(const char *more)
{
    static char text[8192];
    snprintf(text, sizeof text, "{\"kind\": \"benchmark\", %s \"scene\": %s}", more,
             jobs_scene(""));
    return text;
}

static const char small[] = "\"render\": {\"width\": 20, \"height\": 10}, \"matrix\": "
                            "{\"accelerator\": [\"none\", \"auto\"], \"threads\": [1, 0]},"
                            " \"repeats\": 2, \"baseline\": {\"accelerator\": \"auto\"},";

/* Many runs of a tenth of a second or more: the benchmark never ends before a test has seen it. */
static const char lengthy[] = "\"render\": {\"width\": 300, \"height\": 300, \"tile\": 8,"
                              " \"samples_per_pixel\": 16}, \"repeats\": 100,"
                              " \"matrix\": {\"threads\": [1, 2]},";

/* A bill of the test scene; `more` as above. */
static const char *bill(const char *more)
{
    static char text[8192];
    snprintf(text, sizeof text, "{\"kind\": \"effects\", %s \"scene\": %s}", more, jobs_scene(""));
    return text;
}

static struct pen_image report_as(const char *form)
{
    struct pen_image report;
    struct pen_status st;
    store_must(pen_jobs_report(bed.jobs, id, form, &report, &st), &st, "report");
    return report;
}

static json_t *report_json(void)
{
    struct pen_image report = report_as("json");
    json_t *json = json_loadb((const char *)report.bytes.data, report.bytes.bytes, 0, NULL);
    ck_assert_ptr_nonnull(json);
    ck_assert_str_eq(report.type, "application/json");
    pen_buf_release(&report.bytes);
    return json;
}

static void check_refused(bool ok, const struct pen_status *st, enum pen_code code,
                          const char *words);
static void wait_for_runs(int runs);

static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    ck_assert_msg(text != NULL, "no %s", key);
    return text;
}

START_TEST(test_study__answer_to_a_submit_shows_what_was_accepted)
{
    jobs_bed_open(&bed);
    jobs_submit(&bed, benchmark(small), id);
    json_t *job = jobs_get(&bed, id);
    ck_assert_str_eq(text_of(job, "kind"), "benchmark");
    ck_assert_int_eq(json_integer_value(json_object_get(job, "repeats")), 2);
    ck_assert_int_eq(json_integer_value(json_object_get(job, "warmup")), 1);
    char *baseline = json_dumps(json_object_get(job, "baseline"), JSON_COMPACT);
    ck_assert_str_eq(baseline, "{\"accelerator\":\"auto\",\"threads\":1}");
    free(baseline);
    json_t *links = json_object_get(job, "links");
    ck_assert_ptr_nonnull(strstr(text_of(links, "report"), "/report"));
    ck_assert_ptr_null(json_object_get(links, "image"));
    json_t *progress = json_object_get(job, "progress");
    ck_assert_int_eq(json_integer_value(json_object_get(progress, "total")), 4 * 3 + 2);
    json_decref(job);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_study__report_has_every_format)
{
    static const char *const forms[][2] = {{"html", "text/html; charset=utf-8"},
                                           {"csv", "text/csv; charset=utf-8"},
                                           {"md", "text/markdown; charset=utf-8"}};
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, benchmark(small), id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    json_t *report = report_json();
    json_t *rows = json_object_get(report, "rows");
    ck_assert_uint_eq(json_array_size(rows), 4);
    ck_assert_int_eq(json_integer_value(json_object_get(report, "baseline")), 2);
    ck_assert_int_eq(json_integer_value(json_object_get(report, "pool_threads")), 2);
    ck_assert(json_real_value(json_object_get(json_array_get(rows, 2), "speedup")) == 1);
    for (size_t i = 0; i < 3; i++) {
        struct pen_image form = report_as(forms[i][0]);
        ck_assert_str_eq(form.type, forms[i][1]);
        ck_assert_ptr_nonnull(strstr((const char *)form.bytes.data, "none"));
        ck_assert_int_eq(form.etag[0], '"');
        struct pen_image again = report_as(forms[i][0]);
        ck_assert_str_eq(form.etag, again.etag);
        pen_buf_release(&form.bytes);
        pen_buf_release(&again.bytes);
    }
    json_decref(report);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_study__all_views_of_the_job_are_rendered)
{
    static const char views[] = "\"render\": {\"width\": 20, \"height\": 10}, \"repeats\": 1,"
                                " \"views\": [\"far\", \"near\"],";
    static const char scene[] = ", \"views\": [{\"name\": \"near\"}, {\"name\": \"mid\"},"
                                " {\"name\": \"far\", \"camera\": {\"position\": [0, 1, 30]}}]";
    char text[8192];
    snprintf(text, sizeof text, "{\"kind\": \"benchmark\", %s \"scene\": %s}", views,
             jobs_scene(scene));
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, text, id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    json_t *report = report_json();
    char *names = json_dumps(json_object_get(report, "views"), JSON_COMPACT);
    ck_assert_str_eq(names, "[\"far\",\"near\"]");
    free(names);
    json_t *row = json_array_get(json_object_get(report, "rows"), 0);
    json_t *rays = json_object_get(row, "rays");
    ck_assert_int_eq(json_integer_value(json_object_get(rays, "primary")), 2 * 20 * 10);
    json_decref(report);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_study__statistics_are_those_of_the_baseline)
{
    struct pen_status st;
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, benchmark(small), id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    json_t *stats = pen_jobs_stats(bed.jobs, id, &st);
    store_must(stats != NULL, &st, "stats");
    json_t *accelerator = json_object_get(stats, "accelerator");
    ck_assert_str_eq(text_of(accelerator, "kind"), "auto");
    ck_assert(json_real_value(json_object_get(accelerator, "primitive_tests_per_ray")) > 0);
    json_t *rays = json_object_get(stats, "rays");
    ck_assert_int_eq(json_integer_value(json_object_get(rays, "primary")), 200);
    json_t *tiles = json_object_get(stats, "tiles");
    ck_assert_int_eq(json_integer_value(json_object_get(tiles, "count")), 1);
    ck_assert(json_real_value(json_object_get(json_object_get(tiles, "ms"), "max")) > 0);
    json_decref(stats);
    jobs_bed_close(&bed);
}
END_TEST

/* The effects that the bill's rows lack, in order; `rays` are the primary rays of each. */
static void check_bill(const json_t *report, int rays)
{
    const json_t *rows = json_object_get(report, "rows");
    unsigned seen = 0;
    size_t i;
    json_t *row;
    ck_assert_uint_gt(json_array_size(rows), 1);
    json_array_foreach(rows, i, row)
    {
        const json_t *counts = json_object_get(row, "rays");
        const json_int_t primary = json_integer_value(json_object_get(counts, "primary"));
        if (i == 0) {
            ck_assert(json_is_null(json_object_get(row, "without")));
            ck_assert_int_eq(primary, rays);
            continue;
        }
        ck_assert_int_eq(primary < rays, strcmp(text_of(row, "without"), "anti_aliasing") == 0);
        int bit = 0;
        while (strcmp(pen_effect_name(bit), text_of(row, "without")) != 0)
            ck_assert_int_lt(++bit, PEN_FX_COUNT);
        ck_assert(!(seen >> bit & 1));
        seen |= 1u << bit;
    }
}

START_TEST(test_study__bill_has_a_row_for_each_effect_and_every_format)
{
    static const char some[] = "\"render\": {\"width\": 20, \"height\": 10}, \"repeats\": 2,";
    struct pen_status st;
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, bill(some), id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    json_t *report = report_json(), *job = jobs_get(&bed, id);
    const json_t *progress = json_object_get(job, "progress"),
                 *rows = json_object_get(report, "rows");
    check_bill(report, 200);
    ck_assert_int_eq(json_integer_value(json_object_get(progress, "total")),
                     3 * (json_int_t)json_array_size(rows));
    ck_assert_int_eq(json_integer_value(json_object_get(progress, "done")),
                     3 * (json_int_t)json_array_size(rows));
    ck_assert_uint_eq(json_array_size(json_object_get(job, "effects")), json_array_size(rows) - 1);
    json_t *stats = pen_jobs_stats(bed.jobs, id, &st);
    store_must(stats != NULL, &st, "stats");
    ck_assert_str_eq(text_of(stats, "kernel"), text_of(json_array_get(rows, 0), "kernel"));
    for (int i = 0; pen_report_formats[i]; i++) {
        struct pen_image form = report_as(pen_report_formats[i]);
        ck_assert_ptr_nonnull(strstr((const char *)form.bytes.data, "ambient"));
        ck_assert_str_eq(form.type, pen_report_media_type(pen_report_formats[i]));
        pen_buf_release(&form.bytes);
    }
    json_decref(stats);
    json_decref(job);
    json_decref(report);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_study__bill_is_of_the_view_that_is_named)
{
    static const char scene[] =
        ", \"views\": [{\"name\": \"near\"}, {\"name\": \"far\", \"camera\": "
        "{\"position\": [0, 1, 30], \"aperture_radius\": 1, \"focus_distance\": 9}}]";
    static const char *const names[] = {"", "\"views\": [\"far\"],"};
    char text[8192];
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    for (int i = 0; i < 2; i++) {
        snprintf(text, sizeof text,
                 "{\"kind\": \"effects\", \"repeats\": 1, %s"
                 " \"render\": {\"width\": 8, \"height\": 8, \"lens_samples\": 3}, \"scene\": %s}",
                 names[i], jobs_scene(scene));
        jobs_submit(&bed, text, id);
        ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
        json_t *report = report_json();
        char *rows = json_dumps(json_object_get(report, "rows"), JSON_COMPACT);
        ck_assert_str_eq(text_of(report, "view"), i == 0 ? "near" : "far");
        ck_assert_int_eq(strstr(rows, "depth_of_field") != NULL, i == 1);
        free(rows);
        json_decref(report);
    }
    jobs_bed_close(&bed);
}
END_TEST

/* Submits the body as POST /v1/explain does. */
static void submit_explain(const char *body)
{
    const struct pen_submission in = {.body = body, .bytes = strlen(body), .explain = true};
    struct pen_submitted out;
    struct pen_errors errors = {0};
    ck_assert_msg(pen_jobs_submit(bed.jobs, &in, &out, &errors), "%s", errors.item[0].msg);
    memcpy(id, out.id, sizeof id);
    pen_buf_release(&out.answer);
}

START_TEST(test_study__explanation_has_actual_figures_where_asked)
{
    static const char render[] = "\"render\": {\"width\": 32, \"height\": 24},";
    static const struct {
        const char *members;
        int priority, runs, actual;
    } cases[] = {{"", 100, 1, 0},
                 {"\"analyze\": true,", 0, 2, 1},
                 {"\"kind\": \"render\", \"analyze\": false, \"priority\": -3,", -3, 1, 0}};
    char text[8192];
    struct pen_status st;
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    for (int i = 0; i < 3; i++) {
        struct pen_image image;
        snprintf(text, sizeof text, "{%s %s \"scene\": %s}", cases[i].members, render,
                 jobs_scene(""));
        submit_explain(text);
        ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
        json_t *report = report_json(), *job = jobs_get(&bed, id);
        const json_t *rays = json_object_get(report, "rays");
        const json_t *primary = json_object_get(rays, "primary");
        ck_assert_str_eq(text_of(job, "kind"), "explain");
        ck_assert_int_eq(json_integer_value(json_object_get(job, "priority")), cases[i].priority);
        ck_assert_int_eq(
            json_integer_value(json_object_get(json_object_get(job, "progress"), "done")),
            cases[i].runs);
        ck_assert(json_number_value(json_object_get(primary, "expected")) == 32 * 24);
        ck_assert_int_eq(json_object_get(primary, "actual") != NULL, cases[i].actual);
        if (cases[i].actual)
            ck_assert(json_number_value(json_object_get(primary, "actual")) == 32 * 24);
        check_refused(pen_jobs_report(bed.jobs, id, "html", &image, &st), &st, PEN_ACCEPT,
                      "application/json");
        json_t *stats = pen_jobs_stats(bed.jobs, id, &st);
        store_must(stats != NULL, &st, "stats");
        ck_assert_int_eq(text_of(stats, "kernel")[0] == 0, !cases[i].actual);
        json_decref(stats);
        json_decref(job);
        json_decref(report);
    }
    jobs_bed_close(&bed);
}
END_TEST

/* The forecast of a picture that would take hours is ready after a moment, and its render is not
 * made for longer than the operator allows. */
START_TEST(test_study__explanation_ends_however_much_there_is_to_render)
{
    static const char render[] =
        "\"render\": {\"width\": 64, \"height\": 64, \"samples_per_pixel\": 1000000},";
    char text[8192];
    jobs_bed_open(&bed);
    bed.max_seconds = 1;
    jobs_worker_start(&bed);
    snprintf(text, sizeof text, "{%s \"scene\": %s}", render, jobs_scene(""));
    submit_explain(text);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    json_t *report = report_json();
    const json_t *primary = json_object_get(json_object_get(report, "rays"), "primary");
    const double wanted = 64 * 64 * 1e6;
    ck_assert(fabs(json_number_value(json_object_get(primary, "expected")) - wanted) <
              1e-6 * wanted);
    json_decref(report);
    snprintf(text, sizeof text, "{%s \"analyze\": true, \"scene\": %s}", render, jobs_scene(""));
    submit_explain(text);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_FAILED);
    json_t *job = jobs_get(&bed, id);
    ck_assert_ptr_nonnull(strstr(text_of(json_object_get(job, "error"), "detail"), "max-seconds"));
    json_decref(job);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_study__bill_of_a_killed_worker_is_finished)
{
    static const char some[] = "\"render\": {\"width\": 200, \"height\": 150, \"tile\": 8,"
                               " \"samples_per_pixel\": 36}, \"repeats\": 1,";
    int status, opened;
    store_bed_make(&bed.bed);
    pid_t pid = jobs_worker_fork(&bed);
    jobs_bed_open(&bed);
    jobs_submit(&bed, bill(some), id);
    wait_for_runs(2);
    kill(pid, SIGKILL);
    ck_assert_int_eq(waitpid(pid, &status, 0), pid);
    opened = store_worker_died(bed.bed.store, "doomed:1:1");
    ck_assert_int_eq(opened, 1);
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    json_t *report = report_json();
    check_bill(report, 200 * 150 * 36);
    json_decref(report);
    jobs_bed_close(&bed);
}
END_TEST

static void check_refused(bool ok, const struct pen_status *st, enum pen_code code,
                          const char *words)
{
    ck_assert(!ok);
    ck_assert_int_eq(st->code, code);
    ck_assert_msg(strstr(st->msg, words) != NULL, "%s", st->msg);
}

START_TEST(test_study__missing_results_are_refused)
{
    struct pen_image_query query = {0};
    struct pen_image image;
    struct pen_status st;
    jobs_bed_open(&bed);
    jobs_submit(&bed, benchmark(small), id);
    check_refused(pen_jobs_report(bed.jobs, id, "html", &image, &st), &st, PEN_CONFLICT, "queued");
    check_refused(pen_jobs_image(bed.jobs, id, &query, &image, &st), &st, PEN_NOT_FOUND,
                  "it has a report and no picture");
    check_refused(pen_jobs_preview(bed.jobs, id, NULL, &image, &st), &st, PEN_NOT_FOUND, "report");
    jobs_submit(&bed, jobs_scene(", \"render\": {\"width\": 8, \"height\": 8}"), id);
    check_refused(pen_jobs_report(bed.jobs, id, "html", &image, &st), &st, PEN_NOT_FOUND,
                  "kind \"render\", which has no report");
    jobs_bed_close(&bed);
}
END_TEST

static int64_t done_runs(void)
{
    struct pen_job_record job = store_job_get(bed.bed.store, id);
    int64_t done = job.done_pixels;
    ck_assert_msg(!pen_job_state_ended(job.state), "it has ended: %s", job.error ? job.error : "");
    pen_job_record_release(&job);
    return done;
}

static void wait_for_runs(int runs)
{
    for (int i = 0; i < 1200 && done_runs() < runs; i++)
        usleep(50000);
    ck_assert_int_ge(done_runs(), runs);
}

START_TEST(test_study__cancel_stops_a_run)
{
    struct pen_job_snapshot snapshot;
    struct pen_status st;
    char next[PEN_ID_BYTES];
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, benchmark(lengthy), id);
    wait_for_runs(1);
    jobs_submit(&bed, jobs_scene(", \"render\": {\"width\": 4, \"height\": 4}"), next);
    ck_assert_int_eq(store_job_state(bed.bed.store, next), PEN_JOB_QUEUED);
    store_must(pen_jobs_cancel(bed.jobs, id, NULL, &snapshot, &st), &st, "cancel");
    int64_t begun_ns = pen_clock_ns();
    json_decref(snapshot.json);
    /* The next job is done only after the worker has left the first one. */
    ck_assert_int_eq(jobs_wait(&bed, next), PEN_JOB_SUCCEEDED);
    int64_t took_ms = (pen_clock_ns() - begun_ns) / 1000000;
    ck_assert_timed(took_ms < 30000);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_study__time_limit_ends_it)
{
    char text[512];
    snprintf(text, sizeof text, "\"timeout_seconds\": 0.7, %s", lengthy);
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, benchmark(text), id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_FAILED);
    json_t *job = jobs_get(&bed, id);
    json_t *error = json_object_get(job, "error");
    ck_assert_str_eq(text_of(error, "type"), "urn:penumbra:problem:timeout");
    const char *repeat = text_of(error, "repeat");
    ck_assert_msg(strstr(repeat, "| penumbra bench - --view 'main' --set width=300") != NULL, "%s",
                  repeat);
    ck_assert_msg(strstr(repeat, " --matrix threads=1,2 --repeats 100 --warmup 1") != NULL, "%s",
                  repeat);
    json_decref(job);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_study__stopping_worker_gives_it_back)
{
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, benchmark(lengthy), id);
    wait_for_runs(1);
    int64_t begun_ns = pen_clock_ns();
    jobs_worker_stop(&bed);
    int64_t took_ms = (pen_clock_ns() - begun_ns) / 1000000;
    ck_assert_timed(took_ms < 30000);
    int opened = -1;
    opened = store_worker_died(bed.bed.store, "test:1:1");
    ck_assert_int_eq(opened, 0);
    struct pen_job_record job = store_job_get(bed.bed.store, id);
    ck_assert_int_eq(job.state, PEN_JOB_RUNNING);
    ck_assert_int_eq(job.attempts, 1);
    pen_job_record_release(&job);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_study__benchmark_of_a_killed_worker_goes_on)
{
    static const char some[] = "\"render\": {\"width\": 200, \"height\": 150, \"tile\": 8,"
                               " \"samples_per_pixel\": 36}, \"repeats\": 4,"
                               " \"matrix\": {\"threads\": [1, 2]},";
    int status, opened;
    char killed[25];
    store_bed_make(&bed.bed);
    pid_t pid = jobs_worker_fork(&bed);
    jobs_bed_open(&bed);
    jobs_submit(&bed, benchmark(some), id);
    wait_for_runs(2);
    kill(pid, SIGKILL);
    ck_assert_int_eq(waitpid(pid, &status, 0), pid);
    pen_clock_format(pen_clock_wall_ms(), killed);
    opened = store_worker_died(bed.bed.store, "doomed:1:1");
    ck_assert_int_eq(opened, 1);
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    json_t *report = report_json();
    ck_assert_msg(strcmp(text_of(report, "began_at"), killed) <= 0, "%s after %s",
                  text_of(report, "began_at"), killed);
    int interrupted = 0;
    size_t i;
    json_t *note;
    json_array_foreach(json_object_get(report, "notes"), i, note)
    {
        interrupted += strstr(json_string_value(note), "interrupted 1 time") != NULL;
    }
    ck_assert_int_eq(interrupted, 1);
    json_t *row;
    json_array_foreach(json_object_get(report, "rows"), i, row)
    {
        ck_assert_uint_eq(json_array_size(json_object_get(row, "runs_ms")), 4);
    }
    json_decref(report);
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("study", test_study__bill_has_a_row_for_each_effect_and_every_format,
          test_study__bill_is_of_the_view_that_is_named,
          test_study__explanation_has_actual_figures_where_asked,
          test_study__explanation_ends_however_much_there_is_to_render,
          test_study__bill_of_a_killed_worker_is_finished,
          test_study__answer_to_a_submit_shows_what_was_accepted,
          test_study__report_has_every_format, test_study__all_views_of_the_job_are_rendered,
          test_study__statistics_are_those_of_the_baseline, test_study__missing_results_are_refused,
          test_study__cancel_stops_a_run, test_study__time_limit_ends_it,
          test_study__stopping_worker_gives_it_back,
          test_study__benchmark_of_a_killed_worker_goes_on)
