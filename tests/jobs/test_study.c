/* SPDX-License-Identifier: MIT */
/* Benchmark jobs, from submit to report, and the ways in which they end early. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
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
    store_must(pen_jobs_cancel(bed.jobs, id, &snapshot, &st), &st, "cancel");
    int64_t begun_ns = pen_clock_ns();
    json_decref(snapshot.json);
    /* The next job is done only after the worker has left the first one. */
    ck_assert_int_eq(jobs_wait(&bed, next), PEN_JOB_SUCCEEDED);
    int64_t took_ms = (pen_clock_ns() - begun_ns) / 1000000;
    ck_assert_msg(took_ms < 10000, "it took %lld ms", (long long)took_ms);
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
    ck_assert_msg(took_ms < 10000, "it took %lld ms", (long long)took_ms);
    struct pen_status st;
    int opened = -1;
    store_must(pen_store_expire_leases(bed.bed.store, "test:1:1", &opened, &st), &st,
               "expire leases");
    ck_assert_int_eq(opened, 0);
    struct pen_job_record job = store_job_get(bed.bed.store, id);
    ck_assert_int_eq(job.state, PEN_JOB_RUNNING);
    ck_assert_int_eq(job.attempts, 1);
    pen_job_record_release(&job);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_study__killed_worker_leaves_no_times_behind)
{
    static const char some[] = "\"render\": {\"width\": 200, \"height\": 150, \"tile\": 8,"
                               " \"samples_per_pixel\": 36}, \"repeats\": 4,"
                               " \"matrix\": {\"threads\": [1, 2]},";
    struct pen_status st;
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
    store_must(pen_store_expire_leases(bed.bed.store, "doomed:1:1", &opened, &st), &st,
               "expire leases");
    ck_assert_int_eq(opened, 1);
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    json_t *report = report_json();
    ck_assert_msg(strcmp(text_of(report, "began_at"), killed) >= 0, "%s before %s",
                  text_of(report, "began_at"), killed);
    size_t i;
    json_t *row;
    json_array_foreach(json_object_get(report, "rows"), i, row)
    {
        ck_assert_uint_eq(json_array_size(json_object_get(row, "runs_ms")), 4);
    }
    json_decref(report);
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("study", test_study__answer_to_a_submit_shows_what_was_accepted,
          test_study__report_has_every_format, test_study__all_views_of_the_job_are_rendered,
          test_study__statistics_are_those_of_the_baseline, test_study__missing_results_are_refused,
          test_study__cancel_stops_a_run, test_study__time_limit_ends_it,
          test_study__stopping_worker_gives_it_back,
          test_study__killed_worker_leaves_no_times_behind)
